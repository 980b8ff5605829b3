//! How the error grows with the angle between surface and section plane, as a chart.

use super::error::NodeError;
use crate::chart::{Axis, Chart};
use crate::statistics::quantile;
use transect_exchange::svg::{Figure, Mark};

/// Classes of angles of this width, in degrees.
const CLASS: f64 = 10.0;

/// Fewer nodes than these make no point.
const ENOUGH: usize = 200;

/// Colours of the surfaces, in their order.
const COLOURS: [&str; 5] = ["#466ea0", "#c83c28", "#288c5a", "#965aaa", "#d28c1e"];

/// The colour of theory.
const THEORY: &str = "#8a8a8a";

/// The median error of each class over that of the first one, and what theory says.
pub fn growth(surfaces: &[(&str, Vec<NodeError>)]) -> Figure {
    let mut chart = Chart::new(
        "How the error grows with the angle",
        "Error in multiples of that at 0° to 10°, over the angle between surface normal and \
         section plane in degrees.",
        [Axis::linear([0.0, 90.0]), Axis::linear([0.0, 9.0])],
    );
    let theory = (0..84).map(f64::from).map(|angle| [angle, 1.0 / angle.to_radians().cos()]);
    chart.line(theory, THEORY, 2.0);
    chart.figure.legend(Mark::Line(THEORY), "1 / cos(angle)");
    for ((name, errors), colour) in surfaces.iter().zip(COLOURS) {
        let points = relative(errors);
        chart.line(points.iter().copied(), colour, 2.0);
        chart.dots(points, colour, 3.0);
        chart.figure.legend(Mark::Line(colour), *name);
    }
    chart.figure
}

/// Median angle of each class, and its median error over that of the first one.
fn relative(errors: &[NodeError]) -> Vec<[f64; 2]> {
    let median = |class: u32| {
        let low = CLASS * f64::from(class);
        let within = errors.iter().filter(|e| (low..low + CLASS).contains(&e.angle));
        let (angles, sizes): (Vec<f64>, Vec<f64>) =
            within.map(|e| (e.angle, e.signed.abs())).unzip();
        (sizes.len() >= ENOUGH).then(|| (quantile(angles, 0.5), quantile(sizes, 0.5)))
    };
    let medians: Vec<(f64, f64)> = (0..9).filter_map(median).collect();
    let first = medians.first().map_or(f64::NAN, |m| m.1);
    medians.into_iter().map(|(angle, median)| [angle, median / first]).collect()
}
