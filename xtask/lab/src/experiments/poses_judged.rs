//! Is a turned view named, and by how much does it spoil the sections?
//!
//! One view of a scan is turned about one of its own axes. The scan is judged, and reconstructed to
//! see whether its error grew.

use super::lab::Lab;
use super::trial;
use crate::failure::Failure;
use crate::table::{line, say};
use nalgebra::{Isometry3, Vector3};
use rayon::prelude::*;
use transect_device::View;
use transect_register::{CoarseView, Finding, judge};
use transect_workflow::simulation::SensorPlan;

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

/// Counts for one angle: trials, the view named alone, another named, none named, errors that grew,
/// and these without the name.
type Counts = [usize; 6];

/// Runs the experiment.
pub fn run(arguments: &Arguments, lab: &Lab) -> Result<(), Failure> {
    let mut counts = [Counts::default(); DEGREES.len()];
    let chosen = |name: &str| arguments.scene.as_ref().is_none_or(|scene| scene == name);
    for (name, views) in SCANS.into_iter().filter(|(name, _)| chosen(name)) {
        let scene = trial::bundled(name)?;
        let views = scene.simulate(&SensorPlan { views, ..SensorPlan::OWN })?.views;
        let setup = trial::setup(&scene);
        let before =
            (!arguments.quick).then(|| trial::errors(&scene, &views, &setup)).transpose()?;
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
                            let after = trial::errors(&scene, &turned, &setup)?;
                            after.iter().zip(before).any(|(a, b)| *a > GREW * b)
                        }
                        None => false,
                    };
                    let is_named = verdict == Some(true);
                    let of_trial = [
                        true,
                        is_named,
                        verdict == Some(false),
                        verdict.is_none(),
                        grew,
                        grew && !is_named,
                    ];
                    counts.iter_mut().zip(of_trial).for_each(|(sum, is)| *sum += usize::from(is));
                    if !is_named {
                        let (view, grew) = (views[view].name(), if grew { "grew" } else { "held" });
                        let turn = format!("{view} by {degrees} degrees about axis {axis}");
                        say(&format!("  not named: {turn}; the error {grew}"));
                    }
                }
            }
        }
    }
    print(&counts, lab)
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

fn print(counts: &[Counts], lab: &Lab) -> Result<(), Failure> {
    let of_turn = |(degrees, counts): (&f64, &Counts)| {
        line(format!("{degrees}°"), counts.map(|n| n.to_string()))
    };
    let heads = "turn | trials | named alone | another named | nothing named | error grew by more than half | of these not named";
    lab.table("table", heads, DEGREES.iter().zip(counts).map(of_turn))?;
    say("The error is the median or the 95 % quantile of the distances from the true sections.");
    Ok(())
}
