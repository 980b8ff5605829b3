//! How the error grows with the angle between surface and section plane, as a chart.

use super::error::NodeError;
use crate::experiments::pictures::charts::draw;
use crate::failure::Failure;
use crate::statistics::quantile;
use plotters::prelude::*;
use std::path::Path;

/// Classes of angles of this width, in degrees.
const CLASS: f64 = 10.0;

/// Fewer nodes than these make no point.
const ENOUGH: usize = 200;

/// Colours of the surfaces, in their order.
const COLOURS: [RGBColor; 5] = [
    RGBColor(70, 110, 160),
    RGBColor(200, 60, 40),
    RGBColor(40, 140, 90),
    RGBColor(150, 90, 170),
    RGBColor(210, 140, 30),
];

/// Draws the median error of each class over that of the first one, and what theory says.
pub fn growth(file: &Path, surfaces: &[(&str, Vec<NodeError>)]) -> Result<(), Failure> {
    let heads = (
        "angle between surface normal and section plane [degrees]",
        "error, times that at 0° to 10°",
    );
    draw(file, (0.0..90.0, 0.0..9.0), heads, |chart| {
        let theory = (0..84).map(f64::from).map(|a| (a, 1.0 / a.to_radians().cos()));
        chart.draw_series(LineSeries::new(theory, BLACK.mix(0.5).stroke_width(2)))?;
        let mut labels = vec![("1 / cos(angle)", BLACK.mix(0.5))];
        for ((name, errors), colour) in surfaces.iter().zip(COLOURS) {
            let points = relative(errors);
            chart.draw_series(LineSeries::new(points.clone(), colour.stroke_width(2)))?;
            chart.draw_series(points.into_iter().map(|p| Circle::new(p, 3, colour.filled())))?;
            labels.push((name, colour.to_rgba()));
        }
        chart.draw_series(labels.iter().enumerate().map(|(k, (text, colour))| {
            let style = ("sans-serif", 16).into_font().color(colour);
            Text::new((*text).to_owned(), (3.0, 8.6 - 0.55 * k as f64), style)
        }))?;
        Ok(())
    })
}

/// Median angle of each class, and its median error over that of the first one.
fn relative(errors: &[NodeError]) -> Vec<(f64, f64)> {
    let median = |class: u32| {
        let low = CLASS * f64::from(class);
        let within = errors.iter().filter(|e| (low..low + CLASS).contains(&e.angle));
        let (angles, sizes): (Vec<f64>, Vec<f64>) =
            within.map(|e| (e.angle, e.signed.abs())).unzip();
        (sizes.len() >= ENOUGH).then(|| (quantile(angles, 0.5), quantile(sizes, 0.5)))
    };
    let medians: Vec<(f64, f64)> = (0..9).filter_map(median).collect();
    let first = medians.first().map_or(f64::NAN, |m| m.1);
    medians.into_iter().map(|(angle, median)| (angle, median / first)).collect()
}
