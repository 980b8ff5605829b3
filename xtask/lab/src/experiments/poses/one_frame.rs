//! How well a frame of a depth camera comes back that is far off among frames whose poses err, too.
//!
//! A frame sees one or two walls, so distances from the others hardly tell where it is along them.

use super::Normal;
use crate::experiments::{depth_camera, lab::Lab};
use crate::failure::Failure;
use crate::table::{digits, line, say};
use nalgebra::{Isometry3, Point3, Vector3};
use rayon::prelude::*;
use std::f64::consts::TAU;
use transect_device::{View, median};
use transect_register::{CoarseView, PoseOutcome, RefineOptions, RefinedPose, refine};
use transect_scene::Station;
use transect_workflow::simulation::{PreparedScene, SensorPlan, SimulatedScan, describe};

/// Frames of the walk through the room. No unit. Chosen by hand: about as many as the kitchen has
/// here. Doubled, neighbours share more, and the table takes four times the time.
const WALK: usize = 32;

/// Standard deviations of a step of that walk's errors about and along each axis, in degrees and
/// metres. Chosen by hand: poses drift by half a degree and 2 cm, as those of visual tracking.
/// Doubled, exact places can be told less well.
const STEP: [f64; 2] = [0.1, 0.003];

/// Every so many of the frames is moved. No unit. Chosen by hand: six trials for each motion.
/// Doubled, there are half as many.
const EVERY: usize = 6;

/// The turns and shifts, in degrees and metres, and their names.
const MOTIONS: [([f64; 2], &str); 4] = [
    ([10.0, 0.0], "10°"),
    ([30.0, 0.0], "30°"),
    ([0.0, 0.5], "0.5 m"),
    ([10.0, 0.5], "10° and 0.5 m"),
];

/// Seed of their directions.
const DIRECTIONS: u64 = 5;

/// Where a frame counts as back: a turn in degrees, and a distance in metres. Chosen by hand: most
/// others lie farther along a wall. Doubled, short slides count as back.
const BACK: [f64; 2] = [2.0, 0.06];

/// What became of a frame: its outcome, and by how many degrees and metres it is off.
type Trial = (PoseOutcome, [f64; 2]);

/// Frames, and the poses that they were taken at.
struct Scan {
    name: String,
    views: Vec<View>,
    exact: Vec<Isometry3<f64>>,
}

/// Prints the table.
pub fn table(lab: &Lab) -> Result<(), Failure> {
    let mut lines = Vec::new();
    for scan in [kitchen()?, walk_through_room()?] {
        let copies: Vec<CoarseView> = scan.views.par_iter().map(CoarseView::new).collect();
        for (motion, motion_name) in MOTIONS {
            let frames = (0..copies.len()).step_by(EVERY);
            let trial = |frame| scan.trial(&copies, frame, motion);
            let trials: Vec<Trial> = frames.map(trial).collect::<Result<_, _>>()?;
            lines.push(line(format!("{}, {motion_name}", scan.name), cells(&trials)));
        }
    }
    let heads = "scan, motion | frames | back | farther off, named | farther off, not named | farthest, ° / m";
    lab.table("one-frame", heads, lines)?;
    say("A frame is back within 2° and 6 cm of its exact place among the others.");
    Ok(())
}

/// The kitchen, with all errors of a depth camera. Its poses err one by one.
fn kitchen() -> Result<Scan, Failure> {
    let kitchen = PreparedScene::new(depth_camera::kitchen(None, 1)?)?;
    let SimulatedScan { instruments, views, .. } = kitchen.simulate(&SensorPlan::OWN)?;
    let exact = instruments.iter().map(|placed| placed.instrument.world_from_sensor).collect();
    Ok(Scan { name: format!("kitchen, {} frames", views.len()), views, exact })
}

/// Around the middle of the room, looking outwards. Its poses drift.
fn walk_through_room() -> Result<Scan, Failure> {
    let mut room = describe("room".as_ref())?;
    let like_these = describe("kitchen".as_ref())?.stations;
    room.stations = (0..WALK).zip(like_these.iter().cycle()).map(on_walk).collect();
    let scan = PreparedScene::new(room)?.simulate(&SensorPlan::OWN)?;
    let exact: Vec<Isometry3<f64>> =
        scan.views.iter().map(|view| *view.world_from_sensor()).collect();
    let mut numbers = Normal(DIRECTIONS);
    let mut error = [Vector3::zeros(); 2];
    let drifted = scan.views.iter().map(|view| {
        for (sum, step) in error.iter_mut().zip(STEP) {
            *sum += step * Vector3::from_fn(|_, _| numbers.next());
        }
        let error = Isometry3::new(error[1], error[0].map(f64::to_radians));
        Ok(view.with_pose(view.world_from_sensor() * error)?)
    });
    let views: Vec<View> = drifted.collect::<Result<_, Failure>>()?;
    Ok(Scan { name: format!("room, {} frames", views.len()), views, exact })
}

/// A station of the walk, with the camera of another one.
fn on_walk((place, like): (usize, &Station)) -> Station {
    let mut station = like.clone();
    station.name = format!("frame {place:02}");
    let turn = TAU * place as f64 / WALK as f64;
    let (sin, cos) = turn.sin_cos();
    let at = Point3::new(3.0 + 1.1 * cos, 2.5 + 0.8 * sin, 1.35);
    let ahead = Vector3::new(cos, sin, 0.25 * (3.0 * turn).sin() - 0.45);
    station.world_from_sensor = Isometry3::face_towards(&at, &(at + ahead), &-Vector3::z());
    station
}

impl Scan {
    /// The fate of a frame that is turned about a random axis through its sensor, and shifted.
    fn trial(
        &self,
        copies: &[CoarseView],
        frame: usize,
        [degrees, shift]: [f64; 2],
    ) -> Result<Trial, Failure> {
        let mut numbers = Normal(DIRECTIONS + frame as u64);
        let mut direction = || Vector3::from_fn(|_, _| numbers.next()).normalize();
        let turn = direction() * degrees.to_radians();
        let motion = Isometry3::new(direction() * shift, turn);
        let mut copies = copies.to_vec();
        let moved = self.views[frame].world_from_sensor() * motion;
        copies[frame] = copies[frame].clone().with_pose(moved);
        // The errors of the camera stay: they are no question here.
        let options = RefineOptions { images_stay: true, ..RefineOptions::default() };
        let poses = refine(&copies, &options)?.poses;
        Ok((poses[frame].outcome, self.off(&poses, frame)))
    }

    /// By how many degrees and metres a frame is off, seen from the others: medians.
    fn off(&self, poses: &[RefinedPose], frame: usize) -> [f64; 2] {
        let motion = |k: usize| poses[k].world_from_sensor * self.exact[k].inverse();
        let sensor = Point3::from(self.exact[frame].translation.vector);
        let others = (0..poses.len()).filter(|k| *k != frame);
        let errors = others.map(|k| {
            let error: Isometry3<f64> = motion(k).inverse() * motion(frame);
            [error.rotation.angle().to_degrees(), (error * sensor - sensor).norm()]
        });
        let errors: Vec<[f64; 2]> = errors.collect();
        let off = |k: usize| median(errors.iter().map(|error| error[k]));
        [0, 1].map(|k| off(k).unwrap_or(f64::INFINITY))
    }
}

fn cells(trials: &[Trial]) -> Vec<String> {
    let is_back = |off: &[f64; 2]| off.iter().zip(BACK).all(|(off, most)| *off <= most);
    // Warnings name all frames but these.
    let is_silent =
        |outcome: PoseOutcome| matches!(outcome, PoseOutcome::Refined | PoseOutcome::Kept);
    let (back, farther): (Vec<_>, Vec<_>) = trials.iter().partition(|(_, off)| is_back(off));
    let farthest = farther.iter().map(|(_, off)| off).max_by(|a, b| a[1].total_cmp(&b[1]));
    let farthest = farthest.map_or("–".to_owned(), |[turn, distance]| {
        format!("{} / {}", digits(*turn), digits(*distance))
    });
    let silent = farther.iter().filter(|(outcome, _)| is_silent(*outcome)).count();
    let counts = [trials.len(), back.len(), farther.len() - silent, silent];
    counts.map(|n| n.to_string()).into_iter().chain([farthest]).collect()
}
