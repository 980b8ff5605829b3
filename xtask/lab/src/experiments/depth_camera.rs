//! What each error of a depth camera costs: the kitchen with all errors, and without one of them.

use super::output::Output;
use crate::failure::Failure;
use crate::table::say;
use transect::{Setup, Unwatched, reconstruct};
use transect_scene::Noise;
use transect_workflow::simulation::{PreparedScene, SensorPlan, describe};
use transect_workflow::{ScoreLimits, simulated_accuracy};

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
    say("\nIn mm: distances from the true sections, and the spread that the run measures.");
    Ok(())
}

fn line((name, without): (&str, Without)) -> Result<Vec<String>, Failure> {
    let mut description = describe("kitchen".as_ref())?;
    without(&mut description.noise);
    let scene = PreparedScene::new(description)?;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let setup = Setup::new(scene.description.unit, scene.description.planes.clone());
    let run = reconstruct(&views, &setup, &Unwatched)?;
    let limits = ScoreLimits::default();
    let accuracy = simulated_accuracy(&run.model, &scene.truth, views, &limits)?;
    let figure = |metres: Option<f64>| metres.map_or("none".to_owned(), |m| three_digits(1e3 * m));
    let spread = Some(run.report.fusion.spread);
    let figures = [accuracy.median, accuracy.p95, spread].map(figure);
    Ok(std::iter::once(name.to_owned()).chain(figures).collect())
}

fn three_digits(value: f64) -> String {
    let decimals = (2 - value.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{value:.decimals$}")
}
