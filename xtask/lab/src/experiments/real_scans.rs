//! The public scans of real things: each without any option, the bunny against its reference, and a
//! plane of the red kitchen with and without averaging the views' surfaces.

use super::lab::Lab;
use super::posters::INK;
use super::posters::projection::{Projection, panel, stroke};
use super::trial::{self, Public};
use crate::failure::Failure;
use crate::table::line;
use std::path::{Path, PathBuf};
use std::time::Instant;
use transect::evaluate::evaluate;
use transect::{Setup, Unwatched, reconstruct};
use transect_exchange::OpenOptions;
use transect_exchange::svg::{Anchor, Figure, Mark};
use transect_fusion::{ConsensusOptions, FusionMethod};
use transect_geometry::{Curve, LengthUnit, PlaneIndex, Point2};
use transect_model::Model;
use transect_scene::sections;
use transect_workflow::{OpenScan, Settings};

/// The scans below the data's folder, and what they show.
const SCANS: [(&str, &str); 4] = [
    ("tls_pump_e57", "a plant room, 1 scan"),
    ("lidar_pair_hdl32", "a rotating lidar, 2 turns of 32 rings"),
    ("stanford_bunny", "10 range grids"),
    ("rgbd_redkitchen", "50 depth images"),
];

/// The plane of the kitchen that is drawn, 0.2 m below the first camera: walls, table and shelf.
const PLANE: PlaneIndex = PlaneIndex(2);

/// Width and height of one panel, and the space between two, in pixels.
const PANEL: [f64; 2] = [560.0, 470.0];
const BETWEEN: f64 = 30.0;

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    let data = lab.scans()?;
    without_options(data, lab)?;
    bunny(data, lab)?;
    kitchen(data, lab)
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

/// What to open of a folder: its only E57 file, its Stanford scan, else the folder.
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

/// A plane of the red kitchen without and with the step that averages the views' surfaces.
fn kitchen(data: &Path, lab: &Lab) -> Result<(), Failure> {
    let kitchen = trial::red_kitchen(data)?;
    let models = [averaged(&kitchen, false)?, averaged(&kitchen, true)?];
    let mut figure = Figure::new(
        "A section of a real kitchen by a depth camera",
        "The red kitchen of 7-Scenes, 50 frames: plane 2, across the upright. Poses and depths of \
         the frames differ by centimetres.",
        [2.0 * PANEL[0] + BETWEEN, PANEL[1] + 70.0],
    );
    let names = ["every view as it is", "views' surfaces averaged (default)"];
    let frame = models[1].planes().frame(PLANE);
    for (k, (name, model)) in names.into_iter().zip(&models).enumerate() {
        let at = Point2::new(k as f64 * (PANEL[0] + BETWEEN), 30.0);
        let shown = models[1].section(PLANE).into_iter().flat_map(|s| s.curves());
        let nodes = shown.flat_map(Curve::nodes).map(|n| frame.world_from_plane(&n.position));
        let projection = Projection::onto(&frame).fitting(nodes, at, PANEL);
        let curves: Vec<&Curve> =
            model.section(PLANE).into_iter().flat_map(|s| s.curves()).collect();
        figure.text(Point2::new(at.x, 16.0), Anchor::Start, 18.0, INK, name);
        let lines = projection.lines(&frame, curves.iter().copied());
        panel(&mut figure, (at, PANEL), (projection.scale, "m"), |figure| {
            figure.path(&lines, 1.2, &stroke(INK));
        });
    }
    figure.legend(Mark::Line(INK), "fused curve");
    lab.picture("depth_camera", |file| figure.write(file))
}

/// The model of the kitchen with or without averaging the views' surfaces.
fn averaged(kitchen: &Public, settle: bool) -> Result<Model, Failure> {
    let mut setup = Setup::new(LengthUnit::Metre, kitchen.planes.clone());
    let mut options = ConsensusOptions::default();
    options.steps.settle = settle;
    setup.fusion = FusionMethod::Consensus(options);
    Ok(reconstruct(&kitchen.views, &setup, &Unwatched)?.model)
}
