//! What each error of a depth camera costs: the kitchen with all errors, and without one of them.
//! What refined poses and corrected images gain.

use super::output::Output;
use super::trial;
use crate::failure::Failure;
use crate::table::say;
use transect::{Setup, Unwatched, reconstruct};
use transect_device::View;
use transect_register::{CoarseView, RefineOptions, refine};
use transect_scene::{Noise, Station};
use transect_workflow::simulation::{PreparedScene, SensorPlan, describe};

/// Removes an error.
type Without = fn(&mut Noise);

/// The errors by the keys of a scene file.
const ERRORS: [(&str, Without); 8] = [
    ("all", |_| ()),
    ("without `correlation`", |n| n.correlation = 0.0),
    ("without `distortion`", |n| n.depth_camera.distortion = 0.0),
    ("without `pose`", |n| n.pose = Noise::NONE.pose),
    ("without `disparity_step`", |n| n.depth_camera.disparity_step = 0.0),
    ("without `shuffle`", |n| n.depth_camera.shuffle = 0.0),
    ("without `mixed`", |n| n.mixed = 0.0),
    ("`quantum` and `dropout` alone", |n| {
        *n = Noise { quantum: n.quantum, dropout: n.dropout, seed: n.seed, ..Noise::NONE };
    }),
];

/// Runs the experiment.
pub fn run(out: &Output) -> Result<(), Failure> {
    let lines: Vec<_> = ERRORS.into_iter().map(line).collect::<Result<_, _>>()?;
    out.table("table", &["errors", "median", "95 %", "spread between views"], &lines)?;
    say("\nIn mm: distances from the true sections, and the spread that the run measures.\n");
    let lines: Vec<_> = KITCHENS.into_iter().map(of_kitchen).collect::<Result<_, _>>()?;
    out.table(
        "corrected",
        &["kitchen", "as given", "poses refined", "images corrected, too"],
        &lines,
    )?;
    say("\nMedian and 95 % distance in mm, and the share of the visible truth that is found.");
    Ok(())
}

/// Kitchens that refinement is measured with: the seed of the noise, or the scene's own, and how
/// often frames are taken between those of the scene.
const KITCHENS: [(Option<u64>, u32); 6] =
    [(None, 0), (Some(2027), 0), (Some(2028), 0), (None, 1), (Some(2027), 1), (Some(2028), 1)];

/// The kitchen as given, at refined poses, and with corrected images, too.
fn of_kitchen((seed, denser): (Option<u64>, u32)) -> Result<Vec<String>, Failure> {
    let mut description = describe("kitchen".as_ref())?;
    description.noise.seed = seed.unwrap_or(description.noise.seed);
    (0..denser).for_each(|_| description.stations = with_frames_between(&description.stations));
    let name = seed.map_or("its own seed".to_owned(), |seed| format!("seed {seed}"));
    let name = format!("{name}, {} frames", description.stations.len());
    let scene = PreparedScene::new(description)?;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let copies: Vec<CoarseView> = views.iter().map(CoarseView::new).collect();
    let poses = refine(&copies, &RefineOptions::default()).poses;
    let pairs = views.iter().zip(&poses);
    let refined = pairs.map(|(view, pose)| view.with_pose(pose.world_from_sensor));
    let refined: Vec<View> = refined.collect::<Result<_, _>>()?;
    let mut cells = vec![name];
    for (views, options) in
        [(&views, None), (&refined, None), (&views, Some(RefineOptions::default()))]
    {
        let mut setup = Setup::new(scene.description.unit, scene.description.planes.clone());
        setup.refine_poses = options;
        let model = reconstruct(views, &setup, &Unwatched)?.model;
        let found = trial::accuracy(&model, &scene, views.clone())?;
        let length =
            |metres: Option<f64>| metres.map_or("∞".to_owned(), |m| three_digits(1e3 * m));
        let complete = 100.0 * found.completeness.unwrap_or(0.0);
        cells.push(format!("{} / {}, {complete:.1} %", length(found.median), length(found.p95)));
    }
    Ok(cells)
}

/// The stations, and one half way between each and the next.
fn with_frames_between(stations: &[Station]) -> Vec<Station> {
    let half_way = |pair: &[Station]| {
        let mut between = pair[0].clone();
        between.name = format!("after {}", pair[0].name);
        let next = &pair[1].world_from_sensor;
        between.world_from_sensor = pair[0].world_from_sensor.lerp_slerp(next, 0.5);
        between
    };
    let between = stations.windows(2).map(half_way).map(Some).chain([None]);
    stations
        .iter()
        .cloned()
        .zip(between)
        .flat_map(|(at, next)| [Some(at), next])
        .flatten()
        .collect()
}

fn line((name, without): (&str, Without)) -> Result<Vec<String>, Failure> {
    let mut description = describe("kitchen".as_ref())?;
    without(&mut description.noise);
    let scene = PreparedScene::new(description)?;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let setup = Setup::new(scene.description.unit, scene.description.planes.clone());
    let run = reconstruct(&views, &setup, &Unwatched)?;
    let accuracy = trial::accuracy(&run.model, &scene, views)?;
    let figure = |metres: Option<f64>| metres.map_or("none".to_owned(), |m| three_digits(1e3 * m));
    let spread = Some(run.report.fusion.spread);
    let figures = [accuracy.median, accuracy.p95, spread].map(figure);
    Ok(std::iter::once(name.to_owned()).chain(figures).collect())
}

fn three_digits(value: f64) -> String {
    let decimals = (2 - value.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{value:.decimals$}")
}
