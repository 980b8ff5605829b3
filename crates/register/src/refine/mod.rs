//! Poses of all views, refined together.
//!
//! **Problem.** Real poses err by more than the images do. Naive refinement makes good poses worse:
//! raw points are too crude, thousands of neighbouring pixels share one error of the sensor, and
//! what the views do not determine drifts.
//!
//! **Idea.** Point to plane (Chen and Medioni, 1992) over the patches of all pairs of views at once,
//! associated along the rays (Blais and Levine, 1995), with a robust weight. The given poses are a
//! prior, and how far they may be wrong follows from the views' contradictions (MacKay, 1992).
//! Observations count as far as they are independent (Kish, 1965).
//!
//! **Steps.**
//! 1. Pairs of views that overlap: `pairs.rs`.
//! 2. Rounds: every patch is looked up in the other views; the most probable small motions of all
//!    views together (`solve.rs`); how far poses are wrong.
//! 3. The motion that all views share is taken out.
//! 4. Pairs that were left out judge the result: `left_out.rs`.

mod left_out;
mod outcome;
mod pairs;
mod solve;

use crate::CoarseView;
use crate::tuning::{
    BLOCKS, FIRST_ROTATION_DEGREES, FIRST_TRANSLATION, OBSERVATIONS, PRIOR_ROUNDS, ROUNDS, SETTLED,
};
use pairs::{Pair, Reach, Scene, Sums, samples};
use solve::{Motion, Solution, System, estimated_prior, motion_between, moved};
use std::collections::BTreeMap;
use transect_device::{Isometry3, Point3, Vector3};

pub use outcome::{PoseOutcome, RefinedPose, Refinement};

/// How far poses may be wrong, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PosePrior {
    /// Of the rotation about each axis, in radians.
    pub rotation: f64,
    /// Of the translation along each axis, in the model's length unit.
    pub translation: f64,
}

/// Options of [`refine`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RefineOptions {
    /// How far the given poses may be wrong; estimated from the views' contradictions if `None`.
    pub prior: Option<PosePrior>,
}

/// Refines the poses of all views together.
///
/// The result does not depend on the order of the views.
pub fn refine(views: &[CoarseView], options: &RefineOptions) -> Refinement {
    // Sums depend on their order, so the views are taken in an order of their own.
    let mut order: Vec<usize> = (0..views.len()).collect();
    let key = |k: usize| {
        let pose = views.get(k).map(|v| v.world_from_sensor().to_homogeneous());
        (views.get(k).map(|v| v.name().to_owned()), pose.map(|p| p.map(f64::to_bits).data.0))
    };
    order.sort_by_cached_key(|k| key(*k));
    let sorted: Vec<CoarseView> = order.iter().filter_map(|k| views.get(*k)).cloned().collect();
    let mut refinement = refine_sorted(&sorted, options);
    let mut poses: Vec<_> = order.into_iter().zip(refinement.poses).collect();
    poses.sort_by_key(|(k, _)| *k);
    refinement.poses = poses.into_iter().map(|(_, pose)| pose).collect();
    refinement
}

fn refine_sorted(views: &[CoarseView], options: &RefineOptions) -> Refinement {
    let given: Vec<Isometry3> = views.iter().map(|v| *v.world_from_sensor()).collect();
    let scene = scene(views, &given);
    let mut rounds = Rounds::new(&scene, given, options);
    rounds.run();
    rounds.finish()
}

/// The samples of all views, as many as their pairs may have.
fn scene<'a>(views: &'a [CoarseView], poses: &[Isometry3]) -> Scene<'a> {
    let samples: Vec<_> = views.iter().map(|view| samples(view, usize::MAX)).collect();
    let places = samples.iter().zip(poses).flat_map(|(samples, pose)| {
        let middle = samples.iter().map(|s| s.in_sensor.coords).sum::<Vector3>();
        (!samples.is_empty()).then(|| pose * Point3::from(middle / samples.len() as f64))
    });
    let places: Vec<Point3> = places.collect();
    let sum = places.iter().map(|p| p.coords).sum::<Vector3>();
    let origin = Point3::from(sum / places.len().max(1) as f64);
    Scene { views, samples, origin }
}

/// The state of a refinement between its rounds.
struct Rounds<'a> {
    scene: &'a Scene<'a>,
    given: Vec<Isometry3>,
    poses: Vec<Isometry3>,
    first: PosePrior,
    prior: PosePrior,
    stated: bool,
    candidates: Vec<(usize, usize)>,
    /// The pairs at the given poses, for the report.
    before: Vec<Pair>,
    pairs: Vec<Pair>,
    independent: f64,
    variances: Vec<Motion>,
}

impl<'a> Rounds<'a> {
    fn new(scene: &'a Scene<'a>, given: Vec<Isometry3>, options: &RefineOptions) -> Self {
        let mut distances: Vec<f64> =
            scene.samples.iter().flatten().map(|s| s.in_sensor.coords.norm()).collect();
        distances.sort_unstable_by(f64::total_cmp);
        let distance = distances.get(distances.len() / 2).copied().unwrap_or(1.0);
        let first = PosePrior {
            rotation: FIRST_ROTATION_DEGREES.to_radians(),
            translation: FIRST_TRANSLATION * distance,
        };
        let first = options.prior.unwrap_or(first);
        let reach = Reach { rotation: first.rotation, translation: first.translation };
        let candidates = scene.pairs(&given, reach);
        Self {
            scene,
            poses: given.clone(),
            given,
            first,
            prior: first,
            stated: options.prior.is_some(),
            candidates,
            before: Vec::new(),
            pairs: Vec::new(),
            independent: 1.0,
            variances: Vec::new(),
        }
    }

    fn run(&mut self) {
        for round in 0..ROUNDS {
            // Poses settle before the contradictions that are left tell how far they were off.
            let settling = round < ROUNDS / 4;
            let reach = if settling { self.first } else { self.prior };
            self.observe(reach);
            if round == 0 {
                self.before = self.pairs.clone();
            }
            let Some(step) = self.step(settling) else { break };
            let largest = step.iter().zip(&self.variances).flat_map(|(step, variance)| {
                (0..6).map(move |c| step[c].abs() / variance[c].sqrt())
            });
            let largest = largest.fold(0.0, f64::max);
            if std::env::var("REGDBG").is_ok() {
                eprintln!(
                    "round {round}: {} pairs, {} obs, indep {:.4}, prior {:.5} deg {:.6}, step {largest:.3}, excess {:.6}",
                    self.pairs.len(),
                    self.pairs.iter().map(|p| p.observations.len()).sum::<usize>(),
                    self.independent,
                    self.prior.rotation.to_degrees(),
                    self.prior.translation,
                    {
                        let mut e: Vec<f64> = self.pairs.iter().map(|p| p.excess.sqrt()).collect();
                        e.sort_by(f64::total_cmp);
                        e.get(e.len() / 2).copied().unwrap_or(0.0)
                    }
                );
            }
            if !settling
                && self.prior.rotation < 1e-3 * self.first.rotation
                && self.prior.translation < 1e-3 * self.first.translation
            {
                break;
            }
            if !settling && largest < SETTLED {
                break;
            }
        }
    }

    fn observe(&mut self, reach: PosePrior) {
        let reach = Reach { rotation: reach.rotation, translation: reach.translation };
        let per_pair = (OBSERVATIONS / self.candidates.len().max(1)).max(100);
        self.pairs = self.scene.observe_all(&self.candidates, &self.poses, reach, 2 * per_pair);
    }

    /// Moves all views once; `None` if nothing determines them.
    fn step(&mut self, settling: bool) -> Option<Vec<Motion>> {
        self.independent = independent_share(self.scene.views, &self.pairs);
        let sums: Vec<Sums> = self.pairs.iter().map(Pair::sums).collect();
        let sensors: Vec<Point3> =
            self.poses.iter().map(|p| Point3::from(p.translation.vector)).collect();
        let system = System::new(&sensors, self.scene.origin, &sums, self.independent);
        let moves = self.given.iter().zip(&self.poses).map(|(from, to)| motion_between(from, to));
        let so_far: Vec<Motion> = moves.collect();
        let mut solution: Solution = system.solve(&self.prior, &so_far)?;
        self.variances = solution.variances();
        for _ in 0..if self.stated || settling { 0 } else { PRIOR_ROUNDS } {
            let total: Vec<Motion> =
                so_far.iter().zip(&solution.motions).map(|(a, b)| a + b).collect();
            self.prior = estimated_prior(&self.prior, &total, &self.variances);
            solution = system.solve(&self.prior, &so_far)?;
            self.variances = solution.variances();
        }
        for (pose, motion) in self.poses.iter_mut().zip(&solution.motions) {
            *pose = moved(pose, motion);
        }
        Some(solution.motions)
    }
}

/// The share of the observations that are independent (Kish, 1965).
///
/// Blocks of an image may share an error of the sensor. Their sums then vary more than sums of
/// independent errors do. Both directions of a pair compare the same patches, so one half at most.
fn independent_share(views: &[CoarseView], pairs: &[Pair]) -> f64 {
    let mut blocks: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    let mut squares = 0.0;
    for pair in pairs {
        let Some(size) = views.get(pair.b).map(CoarseView::size) else { continue };
        for o in &pair.observations {
            let value = pair.weight(o) * (o.variance + pair.excess).sqrt() * o.distance;
            let (row, col) = (o.cell / size.cols, o.cell % size.cols);
            let block = row * BLOCKS / size.rows * BLOCKS + col * BLOCKS / size.cols;
            *blocks.entry((pair.b, block)).or_default() += value;
            squares += value * value;
        }
    }
    let sums: f64 = blocks.values().map(|sum| sum * sum).sum();
    if sums > 0.0 { (0.5 * squares / sums).min(0.5) } else { 0.5 }
}
