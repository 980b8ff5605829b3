//! Charts: a camera row with its stripe, and the grids of a calibration.

use crate::failure::Failure;
use plotters::prelude::*;
use std::ops::Range;
use std::path::Path;
use transect_device::{ImageSize, Pixel};
use transect_scene::Counts;
use transect_sensors::light_stripe::stripe::{IntensityImage, StripeFinder, StripeProfile};
use transect_sensors::lookup_table::{CalibrationSweep, CarriedScanner, LinearSteps};
use transect_workflow::simulation::{PlacedInstrument, PreparedScene, stripe_camera};

const SIZE: (u32, u32) = (900, 420);
const INK: RGBColor = RGBColor(34, 34, 34);
const LIGHT: RGBColor = RGBColor(70, 110, 160);
const FITTED: RGBColor = RGBColor(200, 60, 40);

/// The intensities of a camera row around its stripe, and the template in its best place.
pub fn stripe_row(
    scene: &PreparedScene,
    placed: &[PlacedInstrument],
    file: &Path,
) -> Result<(), Failure> {
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
    let around = (place - 60.0).max(0.0)..(place + 60.0).min(cells.cols as f64);
    let shown = around.clone();
    draw(file, (around, 0.0..220.0), ("x_frame [cells]", "intensity [counts]"), |chart| {
        let seen = light.iter().enumerate().map(|(k, v)| (k as f64 + 0.5, *v));
        let seen = seen.filter(|p| shown.contains(&p.0));
        let base = light.iter().copied().fold(f64::INFINITY, f64::min) + 5.0;
        let template = (-80..=80)
            .map(|k| f64::from(k) * 0.1)
            .map(|off| (place + off, base + finder.profile.at(off)));
        chart.draw_series(seen.clone().map(|p| Circle::new(p, 2, LIGHT.filled())))?;
        chart.draw_series(LineSeries::new(seen, LIGHT))?;
        chart.draw_series(LineSeries::new(template, FITTED.stroke_width(2)))?;
        chart.draw_series(LineSeries::new([(place, 0.0), (place, 215.0)], FITTED))?;
        Ok(())
    })
}

/// The sweeps of a calibration in the detector's coordinates (p over θ) and in space (v over u).
pub fn calibration(folder: &Path) -> Result<(), Failure> {
    let sweeps = CarriedScanner::hyscan(LinearSteps::single(0.0)).sweeps();
    let detector = |s: &CalibrationSweep| -> Vec<(f64, f64)> {
        s.samples.iter().map(|s| (s.theta_rad.to_degrees(), s.p)).collect()
    };
    let space = |s: &CalibrationSweep| -> Vec<(f64, f64)> {
        s.samples.iter().map(|s| (s.u, s.v)).collect()
    };
    let detector: Vec<_> = sweeps.iter().map(detector).collect();
    let space: Vec<_> = sweeps.iter().map(space).collect();
    let heads = ("θ [degrees]", "p [detector units]");
    grid(&folder.join("lookup_table-p.svg"), &detector, heads)?;
    grid(&folder.join("lookup_table-uv.svg"), &space, ("u [mm]", "v [mm]"))
}

/// The sweeps as lines, and every sixteenth beam through all of them.
fn grid(file: &Path, sweeps: &[Vec<(f64, f64)>], heads: (&str, &str)) -> Result<(), Failure> {
    let all = || sweeps.iter().flatten();
    let ranges = (range(all().map(|p| p.0)), range(all().map(|p| p.1)));
    draw(file, ranges, heads, |chart| {
        for sweep in sweeps {
            chart.draw_series(LineSeries::new(sweep.iter().copied(), LIGHT))?;
        }
        let beams = sweeps.iter().map(Vec::len).min().unwrap_or(0);
        for beam in (0..beams).step_by(16) {
            let along: Vec<_> = sweeps.iter().filter_map(|s| s.get(beam).copied()).collect();
            chart.draw_series(LineSeries::new(along.clone(), INK.mix(0.6)))?;
            chart.draw_series(along.into_iter().map(|p| Circle::new(p, 1, INK.filled())))?;
        }
        Ok(())
    })
}

/// The range of some values with a margin.
fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let margin = 0.03 * (high - low);
    low - margin..high + margin
}

/// A chart that is being drawn.
pub type Chart<'a, 'b> = ChartContext<
    'a,
    SVGBackend<'b>,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;
/// Whether a part of a chart could be drawn.
pub type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// Draws a chart with its axes into a file.
pub fn draw(
    file: &Path,
    (x, y): (Range<f64>, Range<f64>),
    (x_head, y_head): (&str, &str),
    content: impl FnOnce(&mut Chart<'_, '_>) -> Drawn,
) -> Result<(), Failure> {
    let drawn = || -> Drawn {
        let area = SVGBackend::new(file, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&area)
            .margin(14)
            .x_label_area_size(44)
            .y_label_area_size(60)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(INK.mix(0.12))
            .x_desc(x_head)
            .y_desc(y_head)
            .label_style(("sans-serif", 14, &INK))
            .draw()?;
        content(&mut chart)?;
        area.present()
    };
    drawn().map_err(|e| Failure::with_file(file, e))
}
