//! The public scans of real things: each without any option, and the bunny against its reference.

use super::lab::Lab;
use super::trial::{self, Public};
use crate::failure::Failure;
use crate::table::line;
use std::path::{Path, PathBuf};
use std::time::Instant;
use transect::Unwatched;
use transect::evaluate::evaluate;
use transect_exchange::OpenOptions;
use transect_geometry::LengthUnit;
use transect_scene::sections;
use transect_workflow::{OpenScan, Settings};

/// The scans below the data's folder, and what they show.
const SCANS: [(&str, &str); 4] = [
    ("tls_pump_e57", "a plant room, 1 scan"),
    ("lidar_pair_hdl32", "a rotating lidar, 2 turns of 32 rings"),
    ("stanford_bunny", "10 range grids"),
    ("rgbd_redkitchen", "50 depth images"),
];

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    let data = lab.scans()?;
    without_options(data, lab)?;
    bunny(data, lab)
}

/// Every scan as `transect reconstruct PATH` models it.
fn without_options(data: &Path, lab: &Lab) -> Result<(), Failure> {
    let (mut lines, mut times) = (Vec::new(), Vec::new());
    for (folder, what) in SCANS {
        eprintln!("{folder}");
        let start_time = Instant::now();
        let mut scan = OpenScan::open(path(&data.join(folder))?, &OpenOptions::default())?;
        let settings = Settings::default();
        if scan.lacks_planes(&settings) {
            scan.suggest_planes(&settings)?;
        }
        let fusion = scan.reconstruct(&settings, &Unwatched)?.reconstruction.report.fusion;
        let seconds = format!("{:.1} s", start_time.elapsed().as_secs_f64());
        let name = format!("`{folder}`: {what}");
        let open = fusion.curves - fusion.closed;
        let counts = [fusion.planes, fusion.curves, open, fusion.closed];
        lines.push(line(name.clone(), counts.map(|n| n.to_string())));
        times.push(vec![name, seconds]);
    }
    let place = "below `../shared/data`";
    lab.table("scans", &format!("{place} | planes | curves | open | closed"), lines)?;
    lab.times(&format!("{place} | time"), times)
}

/// The path to open for a folder: its only E57 file, its Stanford scan, else the folder.
fn path(folder: &Path) -> Result<PathBuf, Failure> {
    let entries = std::fs::read_dir(folder).map_err(|e| Failure::with_file(folder, e))?;
    let is_scan = |file: &PathBuf| file.extension().is_some_and(|e| e == "e57" || e == "conf");
    let scan = entries.flatten().map(|entry| entry.path()).find(is_scan);
    Ok(scan.unwrap_or_else(|| folder.to_owned()))
}

/// The bunny on planes 1 mm apart, held against the published mesh.
fn bunny(data: &Path, lab: &Lab) -> Result<(), Failure> {
    let (Public { views, planes }, mesh) = trial::bunny(data)?;
    let truth = sections(&mesh, &planes)?;
    let model = trial::model(&views, LengthUnit::Metre, planes.clone())?;
    let curves = model.sections().map(|(k, s)| (k, s.curves().cloned().collect())).collect();
    let accuracy = evaluate(&planes, &curves, &truth, &trial::bunny_options())?;
    let rows = accuracy.rows(LengthUnit::Metre).into_iter().map(|row| row.shown(None));
    let is_figure =
        |metric: &str| metric == "length off the truth" || !metric.starts_with("length");
    let figures = rows.filter(|row| !row.unit.is_empty() && is_figure(&row.metric));
    let lines: Vec<_> =
        figures.map(|row| vec![row.metric, format!("{} {}", row.value, row.unit)]).collect();
    lab.table("bunny", "metric | value", lines)
}
