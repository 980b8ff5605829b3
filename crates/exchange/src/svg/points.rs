//! Points in space, coloured by station: the samples of a sensor.

use super::camera::Camera;
use super::canvas::{self, PathData};
use super::options::OverviewOptions;
use super::ramp::{self, Colour, Stations};
use std::io::{self, Write};
use transect_geometry::{LengthUnit, PlaneFamily, Point3};

/// Steps of drawn coordinates per pixel. Theory: a step of 0.1 px of a dot of 2.4 px cannot be
/// seen. Doubled, files are larger.
const STEPS: f64 = 10.0;
/// Colours in use; points of one colour share a path. Chosen by hand: neighbouring colours
/// look alike. Doubled, files have up to twice the paths.
const COLOURS: usize = 16;
/// Diameter of a point, in pixels. Chosen by hand: single points can be seen. Doubled, more points
/// hide each other.
const DOT: f64 = 2.4;

/// Writes a picture of points in the world, seen as [`write_overview`](super::write_overview) sees
/// a model on the same planes. `caption` is written under the heading; lengths are in `unit`.
///
/// # Errors
/// An error of `out`.
pub fn write_points(
    points: &[Point3],
    planes: &PlaneFamily,
    unit: LengthUnit,
    caption: &str,
    options: &OverviewOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    options.write_opening(out)?;
    let camera = Camera::fitting(planes, points.iter().copied(), options);
    let range = stations(points, planes);
    let mut paths: Vec<_> = (0..COLOURS).map(|_| PathData::new(STEPS)).collect();
    for point in points {
        let station = planes.guide().station(point).unwrap_or(range.first);
        let colour = (range.share(station) * COLOURS as f64) as usize;
        if let Some(path) = paths.get_mut(colour.min(COLOURS - 1)) {
            path.polyline([&camera.place(point)], false);
        }
    }
    writeln!(
        out,
        "<g transform=\"scale({})\" fill=\"none\" stroke-linecap=\"round\" stroke-width=\"{:.0}\">",
        1.0 / STEPS,
        DOT * STEPS
    )?;
    for (number, path) in paths.iter().enumerate() {
        let colour = Colour::ramp((number as f64 + 0.5) / COLOURS as f64);
        path.write(&format!("stroke=\"{colour}\""), out)?;
    }
    writeln!(out, "</g>")?;
    canvas::text(out, (40.0, 46.0), "font-size=\"26\" font-weight=\"bold\"", &options.title)?;
    canvas::text(out, (40.0, 72.0), "fill=\"#555\"", caption)?;
    ramp::write_ramp(&range, unit, options, out)?;
    camera.write_axes(unit, options, out)?;
    writeln!(out, "</svg>")
}

/// The stations of the points.
fn stations(points: &[Point3], planes: &PlaneFamily) -> Stations {
    let stations = points.iter().filter_map(|p| planes.guide().station(p));
    let (first, last) = stations
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| (low.min(s), high.max(s)));
    let (first, last) = if first.is_finite() { (first, last) } else { (0.0, 0.0) };
    Stations { first, last, step: planes.interval() * 1e-2 }
}
