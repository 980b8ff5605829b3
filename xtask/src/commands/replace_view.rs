//! `cargo xtask replace-view`: puts a new image or a new pose in a view's place in a model store.

use super::growing::StoreView;
use super::model_file::{open_finished, setup_of, view_named};
use crate::failure::Failure;
use crate::table::{Row, print};
use std::path::{Path, PathBuf};
use transect::Grower;
use transect_exchange::{Scan, ScanView, pose_of_row_major};
use transect_geometry::Isometry3;

/// Options of `replace-view`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model store.
    file: PathBuf,
    /// The view to replace, as list-views names it.
    name: String,
    /// Scan to take the view from again [default: the one that it came from].
    scan: Option<PathBuf>,
    /// The view in that scan, as its manifest names it [default: that which the view came from].
    #[arg(long, value_name = "NAME")]
    view: Option<String>,
    /// Pose in place of the scan's own: 16 numbers with commas between them, sensor to world, row by row.
    #[arg(long, value_name = "NUMBERS", allow_hyphen_values = true)]
    pose: Option<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = &arguments.file;
    let pose = arguments.pose.as_deref().map(parse_pose).transpose()?;
    let store = open_finished(path)?;
    let header = store.read()?.header().clone();
    let setup = setup_of(path, &header)?;
    let id = view_named(&store, path, &arguments.name)?;
    let there = store.read()?.view(&id)?.ok_or_else(|| Failure::because("the view has gone"))?;
    let scan_path = arguments.scan.clone().unwrap_or_else(|| there.entry.source.clone().into());
    // A scan that does not state its unit is taken to have the store's; one of another unit is refused.
    let scan = Scan::open_with_unit(&scan_path, Some(header.unit))?;
    let view = find(&scan, &scan_path, arguments.view.as_deref().unwrap_or(&there.entry.name))?;
    let origin = std::path::absolute(&scan_path).unwrap_or(scan_path).display().to_string();
    let source = StoreView { view, id: id.0.clone(), origin, pose };
    let stored = Grower::new(&store, &setup)?.replace_view(&id, &source)?;
    let mut planes = there.planes;
    planes.extend(&stored.planes);
    planes.sort_unstable();
    planes.dedup();
    store.close()?;
    print(&[
        Row::new("replaced", id.to_string(), ""),
        Row::count("planes fused anew", planes.len()),
        Row::count("planes with its curves", stored.planes.len()),
    ]);
    Ok(())
}

fn find<'a>(scan: &'a Scan, path: &Path, name: &str) -> Result<&'a ScanView, Failure> {
    let found = scan.views.iter().find(|view| view.name() == name);
    found.ok_or_else(|| {
        let names: Vec<&str> = scan.views.iter().take(20).map(ScanView::name).collect();
        Failure::with_file(path, format!("no view {name:?}; it has {}", names.join(", ")))
    })
}

fn parse_pose(text: &str) -> Result<Isometry3, Failure> {
    let wrong = |reason: String| Failure::Usage(format!("--pose: {reason}"));
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    let numbers = numbers.map_err(|e| wrong(e.to_string()))?;
    let count = numbers.len();
    let matrix = <[f64; 16]>::try_from(numbers);
    let matrix = matrix.map_err(|_| wrong(format!("16 numbers are wanted, got {count}")))?;
    pose_of_row_major(&matrix).map_err(wrong)
}
