//! Charts: a camera row with its stripe, and the grids of a calibration.

use crate::chart::{Axis, Chart};
use crate::failure::Failure;
use transect_device::{ImageSize, Pixel};
use transect_exchange::svg::{Figure, Mark};
use transect_scene::Counts;
use transect_sensors::light_stripe::stripe::{IntensityImage, StripeFinder, StripeProfile};
use transect_sensors::lookup_table::{CalibrationSample, CarriedScanner, LinearSteps};
use transect_workflow::simulation::{PlacedInstrument, PreparedScene, stripe_camera};

const INK: &str = "#222222";
const LIGHT: &str = "#466ea0";
const FITTED: &str = "#c83c28";

/// The intensities of a camera row around its stripe, and the template in its best place.
pub fn stripe_row(scene: &PreparedScene, placed: &[PlacedInstrument]) -> Result<Figure, Failure> {
    let Some((instrument, frame)) =
        placed.first().and_then(|p| Some((&p.instrument, p.instrument.light_stripe.as_ref()?)))
    else {
        return Err(Failure::because("no light-stripe sensor to draw a row of"));
    };
    let cells = frame.parameters().camera();
    let camera = stripe_camera(cells.cols, 1);
    let column = |_: Pixel, d3: f64| Some(d3 - 0.5);
    let images =
        scene.scene.stripe_images(frame, &instrument.world_from_sensor, &camera, &column, 0)?;
    let (row, step) = (cells.rows / 2, images.steps / 2);
    let counts = match images.image(step) {
        Some(Counts::Eight(counts)) => counts,
        _ => return Err(Failure::because("the camera gave no image")),
    };
    let size = ImageSize { rows: cells.rows, cols: cells.cols };
    let image = IntensityImage::from_u8(size, counts)?;
    let finder = StripeFinder::new(StripeProfile::triangle(2.0 * camera.width, camera.peak));
    let found = finder.curve(&image)?.get(row).copied().flatten();
    let Some(place) = found else {
        return Err(Failure::because("the row drawn has no stripe"));
    };
    let mut light = Vec::new();
    image.copy_row(row, &mut light);
    let around = [(place - 60.0).max(0.0), (place + 60.0).min(cells.cols as f64)];
    let seen = light.iter().enumerate().map(|(k, v)| [k as f64 + 0.5, *v]);
    let seen: Vec<_> = seen.filter(|p| p[0] >= around[0] && p[0] < around[1]).collect();
    let base = light.iter().copied().fold(f64::INFINITY, f64::min) + 5.0;
    let template = (-80..=80).map(|k| f64::from(k) * 0.1);
    let template = template.map(|off| [place + off, base + finder.profile.at(off)]);
    let mut chart = Chart::new(
        "The stripe in a row of the camera",
        "Intensity in counts, over x_frame in cells.",
        [Axis::linear(around), Axis::linear([0.0, 220.0])],
    );
    chart.line(seen.iter().copied(), LIGHT, 1.0);
    chart.dots(seen, LIGHT, 2.0);
    chart.line(template, FITTED, 2.0);
    chart.line([[place, 0.0], [place, 215.0]], FITTED, 1.0);
    chart.figure.legend(Mark::Line(LIGHT), "camera row");
    chart.figure.legend(Mark::Line(FITTED), "template in its best place");
    Ok(chart.figure)
}

/// The sweeps of a calibration by name: in the detector's coordinates (p over θ) and in space (v
/// over u).
pub fn calibration() -> [(&'static str, Figure); 2] {
    let sweeps = CarriedScanner::hyscan(LinearSteps::single(0.0)).sweeps();
    let points = |of: fn(&CalibrationSample) -> [f64; 2]| -> Vec<Vec<[f64; 2]>> {
        sweeps.iter().map(|sweep| sweep.samples.iter().map(of).collect()).collect()
    };
    let (detector, space) = (points(|s| [s.theta_rad.to_degrees(), s.p]), points(|s| [s.u, s.v]));
    [
        ("lookup_table-p", grid(&detector, "p in detector units, over θ in degrees.")),
        ("lookup_table-uv", grid(&space, "v in millimetres, over u in millimetres.")),
    ]
}

/// The sweeps as lines, and every sixteenth beam through all of them.
fn grid(sweeps: &[Vec<[f64; 2]>], caption: &str) -> Figure {
    let axes = [0, 1].map(|k| Axis::linear(range(sweeps.iter().flatten().map(|p| p[k]))));
    let mut chart = Chart::new("Calibration of the look-up table", caption, axes);
    for sweep in sweeps {
        chart.line(sweep.iter().copied(), LIGHT, 1.0);
    }
    let beams = sweeps.iter().map(Vec::len).min().unwrap_or(0);
    for beam in (0..beams).step_by(16) {
        let along: Vec<_> = sweeps.iter().filter_map(|s| s.get(beam).copied()).collect();
        chart.line(along.iter().copied(), INK, 0.8);
        chart.dots(along, INK, 1.5);
    }
    chart.figure.legend(Mark::Line(LIGHT), "sweep at one depth");
    chart.figure.legend(Mark::Line(INK), "beam of one column; every sixteenth");
    chart.figure
}

/// The range of some values with a margin.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let margin = 0.03 * (high - low);
    [low - margin, high + margin]
}
