//! `transect inspect`: the contents of a scan, before it is modelled, or of a model.

use super::inspect_model;
use super::scan::ScanArguments;
use crate::failure::Failure;
use crate::table::{Lengths, Row, digits, length, print};
use rayon::prelude::*;
use std::path::PathBuf;
use transect_device::{Pixel, Point3, View};
use transect_exchange::{Scan, ScanView};
use transect_geometry::LengthUnit;
use transect_image::estimate_sigma;
use transect_workflow::{is_model, with_causes};

/// Options of `inspect`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Scan: a folder with scan.json, a scan.json, a Stanford .conf, or a folder of depth images;
    /// or a model file, a model store, or a folder that `reconstruct` wrote.
    scan: PathBuf,
    #[command(flatten)]
    open: ScanArguments,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if is_model(&arguments.scan) {
        return inspect_model::run(&arguments.scan);
    }
    let scan = Scan::open_with(&arguments.scan, &arguments.open.options())?;
    let loaded: Vec<_> = scan.views.par_iter().map(ScanView::load).collect();
    scan.notes.iter().for_each(|n| eprintln!("note: {n}"));
    let mut rows = scan_rows(&scan);
    let mut corners: Option<(Point3, Point3)> = None;
    let mut failures = Vec::new();
    for (source, loaded) in scan.views.iter().zip(&loaded) {
        match loaded {
            Ok((view, notes)) => {
                notes.iter().for_each(|n| eprintln!("note: {n}"));
                rows.push(view_row(view, scan.unit));
                corners = around(corners, view);
            }
            Err(error) => failures.push(format!("view {}: {}", source.name(), with_causes(error))),
        }
    }
    rows.extend(corners.into_iter().flat_map(|c| extent_rows(c, scan.unit)));
    print(&rows);
    // Every bad view is named, not only the first.
    if failures.is_empty() { Ok(()) } else { Err(Failure::Failed(failures.join("\n").into())) }
}

fn scan_rows(scan: &Scan) -> Vec<Row> {
    let mut rows =
        vec![Row::new("scan", scan.name.clone(), ""), Row::plain("views", scan.views.len())];
    if let Some(planes) = &scan.planes {
        rows.push(Row::new("planes, normal", planes.normal.map(digits).join(", "), ""));
        rows.push(Row::length("planes, offset", planes.offset, scan.unit));
        rows.push(Row::length("planes, interval", planes.interval, scan.unit));
    }
    rows
}

fn extent_rows((low, high): (Point3, Point3), unit: LengthUnit) -> [Row; 3] {
    let row = |axis: &str, low: f64, high: f64| {
        let lengths = Lengths::new(unit, low.abs().max(high.abs()));
        let range = format!("{} to {}", lengths.digits(low, 1), lengths.digits(high, 1));
        Row::new(format!("extent, {axis}"), range, lengths.unit.symbol())
    };
    [row("x", low.x, high.x), row("y", low.y, high.y), row("z", low.z, high.z)]
}

fn view_row(view: &View, unit: LengthUnit) -> Row {
    let (image, size) = (view.image(), view.image().size());
    let valid = 100.0 * image.valid_count() as f64 / size.pixels() as f64;
    let (near, far) = image.extremes().unwrap_or((f32::NAN, f32::NAN));
    let (sigma, how) = match view.sigma() {
        Some(sigma) => (sigma, "given"),
        None => (estimate_sigma(view), "estimated"),
    };
    let value = format!(
        "{size}, {valid:.1} % valid, values {} to {}, noise {} {how}",
        digits(f64::from(near)),
        digits(f64::from(far)),
        length(sigma, unit)
    );
    Row::new(format!("view {}", view.name()), value, "")
}

/// The box around all points so far, in the world.
fn around(corners: Option<(Point3, Point3)>, view: &View) -> Option<(Point3, Point3)> {
    let size = view.image().size();
    let pixels = (0..size.rows).flat_map(|row| (0..size.cols).map(move |col| Pixel::new(row, col)));
    let points =
        pixels.filter_map(|p| view.point_in_sensor(p)).map(|p| view.world_from_sensor() * p);
    points.fold(corners, |corners, p| {
        let (low, high) = corners.unwrap_or((p, p));
        Some((low.inf(&p), high.sup(&p)))
    })
}
