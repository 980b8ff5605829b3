//! The result of a refinement: what moved, how far, and what that is worth.

use super::pairs::Pair;
use super::solve::{Motion, motion_between};
use super::{PosePrior, Rounds};
use nalgebra::{Matrix3, UnitQuaternion};
use transect_device::{Isometry3, Point3, Vector3};

/// What became of the pose of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PoseOutcome {
    /// It moved.
    Refined,
    /// It was farther off than the prior explains, and the other views brought it back.
    BroughtBack,
    /// It stays as given: pairs that were left out of the estimate do not agree better.
    Kept,
    /// It stays as given: no other view sees enough of the same surfaces.
    Alone,
    /// It stays as given, though it contradicts the other views: no nearby pose agrees with them.
    Misplaced,
}

/// The refined pose of one view.
#[derive(Debug, Clone, serde::Serialize)]
pub struct RefinedPose {
    /// The name of the view.
    pub view: String,
    /// World coordinates from sensor coordinates; the given pose unless the view moved.
    pub world_from_sensor: Isometry3,
    /// What became of it.
    pub outcome: PoseOutcome,
    /// Angle between the given pose and the refined one, in radians.
    pub rotation: f64,
    /// Distance that the middle of the view's surface moved, in the model's length unit.
    pub translation: f64,
    /// Standard deviations of the refined pose, common motions of all views left out.
    pub sigma: PosePrior,
    /// Median distance of the view's patches from the other views' surfaces at the given poses, in
    /// the model's length unit; `None` without overlap.
    pub residual_before: Option<f64>,
    /// The same at the refined poses.
    pub residual_after: Option<f64>,
}

/// The result of [`refine`](super::refine).
#[derive(Debug, Clone, serde::Serialize)]
pub struct Refinement {
    /// One for each view, in their order.
    pub poses: Vec<RefinedPose>,
    /// How far the given poses were taken to be wrong.
    pub prior: PosePrior,
    /// Change of the squared distances of the pairs that were left out of the estimate, as a share:
    /// -0.5 is half of them. `None` if there were too few pairs to leave some out.
    pub left_out_pairs: Option<f64>,
}

impl Rounds<'_> {
    pub(super) fn finish(mut self) -> Refinement {
        self.take_out_common_motion();
        let before = medians(&self.before, self.given.len());
        let after = medians(&self.pairs, self.given.len());
        let poses = (0..self.given.len()).map(|k| {
            let (given, pose) = (self.given[k], self.poses[k]);
            let motion = motion_between(&given, &pose);
            let middle = middle(&self.scene.samples[k]);
            let variance = self.variances.get(k).copied().unwrap_or_else(Motion::zeros);
            RefinedPose {
                view: self.scene.views[k].name().to_owned(),
                world_from_sensor: pose,
                outcome: PoseOutcome::Refined,
                rotation: motion.fixed_rows::<3>(3).norm(),
                translation: (given * middle - pose * middle).norm(),
                sigma: PosePrior {
                    rotation: (variance.fixed_rows::<3>(3).sum() / 3.0).sqrt(),
                    translation: (variance.fixed_rows::<3>(0).sum() / 3.0).sqrt(),
                },
                residual_before: before[k],
                residual_after: after[k],
            }
        });
        let poses = poses.collect();
        Refinement { poses, prior: self.prior, left_out_pairs: None }
    }

    /// Moves all views together, so that their surfaces stay at the given place as a whole.
    fn take_out_common_motion(&mut self) {
        let places = |poses: &[Isometry3]| -> Vec<Point3> {
            let views = self.scene.samples.iter().zip(poses);
            let of = |samples: &[super::pairs::Sample], pose: &Isometry3| -> Vec<Point3> {
                samples.iter().take(256).map(|s| pose * s.in_sensor).collect()
            };
            views.flat_map(|(samples, pose)| of(samples, pose)).collect()
        };
        let back = rigid_fit(&places(&self.poses), &places(&self.given));
        for pose in &mut self.poses {
            *pose = back * *pose;
        }
    }
}

fn middle(samples: &[super::pairs::Sample]) -> Point3 {
    let sum = samples.iter().map(|s| s.in_sensor.coords).sum::<Vector3>();
    Point3::from(sum / samples.len().max(1) as f64)
}

/// Median distance of each view's patches from the surfaces of the others.
fn medians(pairs: &[Pair], views: usize) -> Vec<Option<f64>> {
    let mut distances = vec![Vec::new(); views];
    for pair in pairs {
        let found = pair.observations.iter().map(|o| o.distance.abs());
        for view in [pair.a, pair.b] {
            if let Some(list) = distances.get_mut(view) {
                list.extend(found.clone());
            }
        }
    }
    let median = |list: &mut Vec<f64>| {
        let middle = list.len() / 2;
        (!list.is_empty()).then(|| *list.select_nth_unstable_by(middle, f64::total_cmp).1)
    };
    distances.iter_mut().map(median).collect()
}

/// The rigid motion that best takes points to others (Kabsch, 1976).
fn rigid_fit(from: &[Point3], to: &[Point3]) -> Isometry3 {
    let mean = |points: &[Point3]| {
        points.iter().map(|p| p.coords).sum::<Vector3>() / points.len().max(1) as f64
    };
    let (from_mean, to_mean) = (mean(from), mean(to));
    let mut scatter = Matrix3::zeros();
    for (a, b) in from.iter().zip(to) {
        scatter += (b.coords - to_mean) * (a.coords - from_mean).transpose();
    }
    let rotation = UnitQuaternion::from_matrix(&scatter_rotation(&scatter));
    let shift = to_mean - rotation * from_mean;
    Isometry3::from_parts(shift.into(), rotation)
}

fn scatter_rotation(scatter: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = scatter.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    let mut mirror = Matrix3::identity();
    mirror[(2, 2)] = (u * v_t).determinant().signum();
    u * mirror * v_t
}

impl RefinedPose {
    /// Whether the refined pose differs from the given one.
    pub fn has_moved(&self) -> bool {
        matches!(self.outcome, PoseOutcome::Refined | PoseOutcome::BroughtBack)
    }
}
