//! The error of the sections by errors of poses, noise and number of views, with the poses as given
//! and refined.
//!
//! The machined part is simulated once for each noise. Every pose is moved by normally distributed
//! angles and places about the middle of the part, from a fixed seed. A place errs by the angle
//! times half the part's size.
//!
//! `one_wrong.rs` turns one view alone, and `one_frame.rs` one of a depth camera's frames that all
//! err.

mod one_frame;
mod one_wrong;

use super::lab::Lab;
use super::trial;
use crate::chart::{Axis, Chart};
use crate::failure::Failure;
use crate::table::{self, digits, say};
use nalgebra::{Isometry3, Vector3};
use transect_device::View;
use transect_exchange::svg::{Figure, Mark};
use transect_scene::{Description, Noise};
use transect_workflow::simulation::{PreparedScene, SensorPlan, describe};

/// Options of `experiments poses`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Also four times the noise, and none.
    #[arg(long)]
    full: bool,
}

/// The scene.
pub const SCENE: &str = "machined_part";

/// Standard deviations of the angle about each axis, in degrees.
const DEGREES: [f64; 5] = [0.0, 0.02, 0.1, 0.5, 1.0];

/// Range noise, as multiples of the scene's own; without `--full` the first alone.
const NOISE: [f64; 3] = [1.0, 0.0, 4.0];

/// Every so many of the scene's views is used.
const EVERY: [usize; 3] = [1, 2, 3];

/// Seed of the poses' errors.
const SEED: u64 = 20;

/// Section errors at given and at refined poses: median, 95 % quantile.
type Errors = [[f64; 2]; 2];

/// Runs the experiment.
pub fn run(arguments: &Arguments, lab: &Lab) -> Result<(), Failure> {
    let mut lines = Vec::new();
    let mut curves = [Vec::new(), Vec::new()];
    let count = if arguments.full { NOISE.len() } else { 1 };
    for &noise in &NOISE[..count] {
        let scene = PreparedScene::new(with_noise(noise)?)?;
        let all = scene.simulate(&SensorPlan::OWN)?.views;
        for every in EVERY {
            let views: Vec<View> = all.iter().step_by(every).cloned().collect();
            for degrees in DEGREES {
                let errors = errors(&scene, &moved(&scene, &views, degrees)?)?;
                if noise == 1.0 && every == 1 && degrees > 0.0 {
                    for (curve, [median, _]) in curves.iter_mut().zip(errors) {
                        curve.push([degrees, median]);
                    }
                }
                lines.push(cells((noise, views.len(), degrees), &errors));
            }
        }
    }
    let heads = "noise, σ of the scene | views | pose error, ° | as given: median | p95 | refined: median | p95";
    lab.table("table", heads, lines)?;
    say("Distances in mm from the true sections.");
    let figure = chart(&curves);
    lab.picture("poses", |file| figure.write(file))?;
    one_wrong::table(lab)?;
    one_frame::table(lab)
}

/// The median errors by the pose errors, as given and refined.
fn chart(curves: &[Vec<[f64; 2]>; 2]) -> Figure {
    let degrees = DEGREES.into_iter().filter(|degrees| *degrees > 0.0).collect();
    let axes = [
        Axis::logarithmic([0.014, 1.4], degrees, "°"),
        Axis::logarithmic([0.0005, 2.0], vec![0.001, 0.01, 0.1, 1.0], ""),
    ];
    let mut chart = Chart::new(
        "What errors of poses cost",
        "Median distance of the sections from the truth in mm, over the standard deviation of each \
         pose's angles in degrees; all 11 views.",
        axes,
    );
    let names = [("#d55e00", "poses as given"), ("#0072b2", "poses refined")];
    for (curve, (colour, name)) in curves.iter().zip(names) {
        chart.line(curve.iter().copied(), colour, 2.5);
        chart.dots(curve.iter().copied(), colour, 5.0);
        chart.figure.legend(Mark::Line(colour), name);
    }
    chart.figure
}

/// The scene with a multiple of its own range noise.
fn with_noise(factor: f64) -> Result<Description, Failure> {
    let mut description = describe(SCENE.as_ref())?;
    if factor == 0.0 {
        description.noise = Noise::NONE;
    } else {
        description.noise.sigma *= factor;
    }
    Ok(description)
}

fn cells((noise, views, degrees): (f64, usize, f64), errors: &Errors) -> Vec<String> {
    let error = |e: &f64| if e.is_finite() { digits(*e) } else { "∞".to_owned() };
    let errors: Vec<String> = errors.iter().flatten().map(error).collect();
    table::cells(&format!("{noise} | {views} | {degrees} | {}", errors.join(" | ")))
}

/// The views with errors of their poses.
pub fn moved(scene: &PreparedScene, views: &[View], degrees: f64) -> Result<Vec<View>, Failure> {
    let (angle, mut numbers) = (degrees.to_radians(), Normal(SEED));
    let middle = Isometry3::translation(0.0, 0.0, 15.0);
    let moved = views.iter().map(|view| {
        let mut vector = |size: f64| size * Vector3::from_fn(|_, _| numbers.next());
        let by = Isometry3::new(vector(0.5 * scene.bounds.size() * angle), vector(angle));
        let by = middle * by * middle.inverse();
        Ok(view.with_pose(by * view.world_from_sensor())?)
    });
    moved.collect()
}

/// The errors with the poses as given and refined.
pub fn errors(scene: &PreparedScene, views: &[View]) -> Result<Errors, Failure> {
    let given = trial::setup(scene);
    let mut refined = given.clone();
    refined.refine_poses = Some(Default::default());
    Ok([trial::errors(scene, views, &given)?, trial::errors(scene, views, &refined)?])
}

/// Normally distributed numbers: sums of twelve uniform ones of SplitMix64 (Steele, 2014).
pub struct Normal(pub u64);

impl Normal {
    pub fn next(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
