//! Is a view named that was turned or shifted, and by how much does it spoil the sections?
//!
//! One view of a scan is turned about one of its own axes, or shifted along it. The scan is judged,
//! and reconstructed to see whether its error grew.

use super::lab::Lab;
use super::trial;
use crate::failure::Failure;
use crate::table::{line, say};
use nalgebra::{Isometry3, Vector3};
use rayon::prelude::*;
use transect_device::{Pixel, View, median};
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

/// Most views of a scan that are moved, evenly over its views. No unit. Chosen by hand: each is a
/// reconstruction for every axis and angle. Doubled, the experiment takes twice the time.
const MOVED: usize = 4;

/// A motion of a view in its own frame.
#[derive(Debug, Clone, Copy)]
enum Motion {
    /// In degrees.
    Turn(f64),
    /// Over the median distance of the view's surface from its sensor.
    Shift(f64),
}

/// The motions that are tried about, and along, each axis.
const MOTIONS: [Motion; 8] = [
    Motion::Turn(1.0),
    Motion::Turn(3.0),
    Motion::Turn(10.0),
    Motion::Turn(30.0),
    Motion::Shift(0.01),
    Motion::Shift(0.03),
    Motion::Shift(0.1),
    Motion::Shift(0.3),
];

impl std::fmt::Display for Motion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Turn(degrees) => write!(f, "turned by {degrees}°"),
            Self::Shift(share) => write!(f, "shifted by {} %", 100.0 * share),
        }
    }
}

/// Factor on the error from which it grew. No unit. Chosen by hand: half more than without the
/// motion. Doubled, only motions that ruin the sections count.
const GREW: f64 = 1.5;

/// Counts for one motion: trials, the view named alone, another named, none named, errors that
/// grew, and these without the name.
type Counts = [usize; 6];

/// Runs the experiment.
pub fn run(arguments: &Arguments, lab: &Lab) -> Result<(), Failure> {
    let mut counts = [Counts::default(); MOTIONS.len()];
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
        let step = views.len().div_ceil(MOVED);
        for view in (0..views.len()).step_by(step) {
            for axis in 0..3 {
                for (motion, counts) in MOTIONS.iter().zip(&mut counts) {
                    let moved = moved(&views, view, axis, *motion)?;
                    let verdict = verdict(&coarse, *moved[view].world_from_sensor(), view);
                    let grew = match before {
                        Some(before) => {
                            let after = trial::errors(&scene, &moved, &setup)?;
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
                        say(&format!(
                            "  not named: {view}, {motion}, axis {axis}; the error {grew}"
                        ));
                    }
                }
            }
        }
    }
    print(&counts, lab)
}

fn moved(views: &[View], view: usize, axis: usize, by: Motion) -> Result<Vec<View>, Failure> {
    let mut views = views.to_vec();
    let motion = match by {
        Motion::Turn(degrees) => Isometry3::rotation(Vector3::ith(axis, degrees.to_radians())),
        Motion::Shift(share) => {
            let by = Vector3::ith(axis, share * distance(&views[view]));
            Isometry3::translation(by.x, by.y, by.z)
        }
    };
    views[view] = views[view].with_pose(views[view].world_from_sensor() * motion)?;
    Ok(views)
}

/// The median distance of a view's surface from its sensor; 0 without any.
fn distance(view: &View) -> f64 {
    let size = view.image().size();
    let pixels = (0..size.rows).flat_map(|row| (0..size.cols).map(move |col| Pixel::new(row, col)));
    let points = pixels.filter_map(|pixel| view.point_in_sensor(pixel));
    median(points.map(|point| point.coords.norm())).unwrap_or(0.0)
}

/// Whether the moved view is named, and no other; `None` if nothing is found.
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
    let of_motion = |(motion, counts): (&Motion, &Counts)| {
        line(motion.to_string(), counts.map(|n| n.to_string()))
    };
    let heads = "one view | trials | named alone | another named | nothing named | error grew by more than half | of these not named";
    lab.table("table", heads, MOTIONS.iter().zip(counts).map(of_motion))?;
    say("The error is the median or the 95 % quantile of the distances from the true sections.");
    Ok(())
}
