//! Is a turned view named, and by how much does it spoil the sections?
//!
//! One view of a scan is turned about one of its own axes. The scan is judged, and reconstructed to
//! see whether its error grew.

use super::output::Output;
use super::trial;
use crate::failure::Failure;
use crate::table::say;
use nalgebra::{Isometry3, Vector3};
use rayon::prelude::*;
use transect::evaluate::Accuracy;
use transect_device::View;
use transect_register::{CoarseView, Finding, judge};
use transect_workflow::simulation::{PreparedScene, SensorPlan};
use transect_workflow::{ScoreLimits, simulated_accuracy};

/// Options of `experiments poses-judged`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Judge only, without the error of the sections.
    #[arg(long)]
    quick: bool,
    /// Judge as every run does, by copies of a quarter of the cells.
    #[arg(long)]
    copies_of_runs: bool,
    /// Only this bundled scene.
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
}

/// Scenes, and the number of views of each; the scene's own number if `None`.
const SCANS: [(&str, Option<usize>); 5] = [
    ("room", None),
    ("room", Some(12)),
    ("face_mask", None),
    ("machined_part", None),
    ("tunnel", None),
];

/// Most views of a scan that are turned, evenly over its views. No unit. Chosen by hand: each is a
/// reconstruction for every axis and angle. Doubled, the experiment takes twice the time.
const TURNED: usize = 4;

/// Turns, in degrees.
const DEGREES: [f64; 4] = [1.0, 3.0, 10.0, 30.0];

/// Factor on the error from which it grew. No unit. Chosen by hand: half more than without the
/// turn. Doubled, only turns that ruin the sections count.
const GREW: f64 = 1.5;

/// What became of the trials of one angle.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    trials: usize,
    alone: usize,
    other: usize,
    unnamed: usize,
    grew: usize,
    grew_unnamed: usize,
}

/// Runs the experiment.
pub fn run(arguments: &Arguments, out: &Output) -> Result<(), Failure> {
    let mut counts = DEGREES.map(|_| Counts::default());
    let chosen = |name: &str| arguments.scene.as_ref().is_none_or(|scene| scene == name);
    for (name, views) in SCANS.into_iter().filter(|(name, _)| chosen(name)) {
        let scene = trial::bundled(name)?;
        let views = scene.simulate(&SensorPlan { views, ..SensorPlan::OWN })?.views;
        let before = (!arguments.quick).then(|| errors(&scene, &views)).transpose()?;
        let copy = if arguments.copies_of_runs { CoarseView::quick } else { CoarseView::new };
        let coarse: Vec<CoarseView> = views.par_iter().map(copy).collect();
        say(&format!("{name}, {} views: {:?}", views.len(), judge(&coarse).findings));
        let step = views.len().div_ceil(TURNED);
        for view in (0..views.len()).step_by(step) {
            for axis in 0..3 {
                for (degrees, counts) in DEGREES.iter().zip(&mut counts) {
                    let turned = turned(&views, view, axis, *degrees)?;
                    let verdict = verdict(&coarse, *turned[view].world_from_sensor(), view);
                    let grew = match before {
                        Some(before) => {
                            let after = errors(&scene, &turned)?;
                            after.iter().zip(before).any(|(a, b)| *a > GREW * b)
                        }
                        None => false,
                    };
                    counts.add(verdict, grew);
                    if verdict != Some(true) {
                        let (view, grew) = (views[view].name(), if grew { "grew" } else { "held" });
                        let turn = format!("{view} by {degrees} degrees about axis {axis}");
                        say(&format!("  not named: {turn}; the error {grew}"));
                    }
                }
            }
        }
    }
    print(&counts, out)
}

impl Counts {
    fn add(&mut self, verdict: Option<bool>, grew: bool) {
        self.trials += 1;
        self.alone += usize::from(verdict == Some(true));
        self.other += usize::from(verdict == Some(false));
        self.unnamed += usize::from(verdict.is_none());
        self.grew += usize::from(grew);
        self.grew_unnamed += usize::from(grew && verdict != Some(true));
    }
}

fn turned(views: &[View], view: usize, axis: usize, degrees: f64) -> Result<Vec<View>, Failure> {
    let turn = Isometry3::rotation(Vector3::ith(axis, degrees.to_radians()));
    let mut views = views.to_vec();
    views[view] = views[view].with_pose(views[view].world_from_sensor() * turn)?;
    Ok(views)
}

/// Whether the turned view is named, and no other; `None` if nothing is found.
fn verdict(coarse: &[CoarseView], pose: Isometry3<f64>, view: usize) -> Option<bool> {
    let mut coarse = coarse.to_vec();
    coarse[view] = coarse[view].clone().with_pose(pose);
    let name = coarse[view].name().to_owned();
    match &judge(&coarse).findings[..] {
        [] => None,
        [Finding::Misplaced(found)] => Some(found.view == name),
        [Finding::Apart { view }] => Some(*view == name),
        _ => Some(false),
    }
}

/// Median and 95 % quantile of the distances from the true sections.
fn errors(scene: &PreparedScene, views: &[View]) -> Result<[f64; 2], Failure> {
    let model = trial::model(views, scene.description.unit, scene.description.planes.clone())?;
    let limits = ScoreLimits::default();
    let Accuracy { median, p95, .. } =
        simulated_accuracy(&model, &scene.truth, views.to_vec(), &limits)?;
    Ok([median, p95].map(|error| error.unwrap_or(f64::INFINITY)))
}

fn print(counts: &[Counts], out: &Output) -> Result<(), Failure> {
    let line = |(degrees, c): (&f64, &Counts)| {
        let counts = [c.trials, c.alone, c.other, c.unnamed, c.grew, c.grew_unnamed];
        let counts = counts.iter().map(usize::to_string);
        std::iter::once(format!("{degrees}°")).chain(counts).collect()
    };
    let lines: Vec<Vec<String>> = DEGREES.iter().zip(counts).map(line).collect();
    let heads = [
        "turn",
        "trials",
        "named alone",
        "another named",
        "nothing named",
        "error grew by more than half",
        "of these not named",
    ];
    out.table("table", &heads, &lines)?;
    say("\nThe error is the median or the 95 % quantile of the distances from the true sections.");
    Ok(())
}
