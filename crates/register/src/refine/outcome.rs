//! The result of a refinement: what moved, how far, and what that is worth.

use super::Rounds;
use super::common_motion::{OfView, common_motion};
use super::pairs::{Pair, Sample};
use super::solve::{Motion, motion_between};
use crate::coarse::PosePrior;
use crate::tuning::{FAR_OFF, GATE, MISPLACED, PROBES};
use transect_device::{DepthOffsets, Isometry3, Point3, Vector3};

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
    /// The error of the view's depth camera, which its images must lose at the refined pose;
    /// `None` for other sensors, and for a camera without a visible error.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "rms")]
    pub depth_offsets: Option<DepthOffsets>,
}

/// The result of [`refine`](super::refine).
#[derive(Debug, Clone, serde::Serialize)]
pub struct Refinement {
    /// One for each view, in their order.
    pub poses: Vec<RefinedPose>,
    /// How far the given poses were taken to be wrong, of views that do not state their own.
    pub prior: PosePrior,
    /// Change of the squared distances of the pairs that were left out of the estimate, as a share:
    /// -0.5 is half of them. `None` if there was one pair only.
    pub left_out_pairs: Option<f64>,
    /// Median distance of the patches from their sensors, in the model's length unit.
    pub distance: f64,
}

/// Reports tell how large offsets are; the scan that registration writes has their values.
fn rms<S: serde::Serializer>(offsets: &Option<DepthOffsets>, out: S) -> Result<S::Ok, S::Error> {
    out.serialize_some(&offsets.as_ref().map(DepthOffsets::rms))
}

impl Rounds<'_> {
    /// The view that fits the others worst, if it is misplaced: far worse than the others and than
    /// its noise explains, and hardly better than at its given pose.
    pub(super) fn worst_view(&self) -> Option<usize> {
        let before = medians(&self.before, self.given.len());
        let after = medians(&self.pairs, self.given.len());
        let typical = median(after.iter().flatten().copied())?;
        let views = before.iter().zip(&after).enumerate();
        let misplaced = views.filter_map(|(k, (before, after))| {
            let after = (*after)?;
            let worse = after > MISPLACED * typical && after > GATE * self.noise(k);
            (worse && after > 0.5 * (*before)?).then_some((k, after))
        });
        misplaced.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
    }

    pub(super) fn finish(mut self, misplaced: &[usize]) -> Refinement {
        let left_out_pairs = self.left_out();
        let unpaired = |k: usize| self.pairs.iter().all(|p| p.a != k && p.b != k);
        let alone: Vec<bool> = (0..self.given.len()).map(unpaired).collect();
        let keeps = left_out_pairs.is_some_and(|change| change >= 0.0);
        if keeps {
            self.poses = self.given.clone();
        } else if self.scene.views.iter().all(|view| view.prior().is_none()) {
            // Where views state how exact their poses are, the most exact ones hold the whole.
            self.take_out_common_motion(&alone);
        }
        let turned: Vec<f64> = self.motions().iter().map(|m| m.fixed_rows::<3>(3).norm()).collect();
        let typical = median(turned.iter().copied()).unwrap_or(0.0);
        let before = medians(&self.before, self.given.len());
        let after = if keeps { before.clone() } else { medians(&self.pairs, self.given.len()) };
        let apart = median(after.iter().flatten().copied()).unwrap_or(0.0);
        // What images and poses are uncertain by moves no view far off.
        let far_off = |k: usize| {
            let moved = self.surface_moves(&motion_between(&self.given[k], &self.poses[k]));
            turned[k] > FAR_OFF * typical && moved > GATE * apart.hypot(self.uncertainty(k))
        };
        let outcome = |k: usize| match () {
            () if misplaced.contains(&k) => PoseOutcome::Misplaced,
            () if alone[k] => PoseOutcome::Alone,
            () if keeps => PoseOutcome::Kept,
            () if far_off(k) => PoseOutcome::BroughtBack,
            () => PoseOutcome::Refined,
        };
        let offsets = |k: usize| self.cameras.of_view(k).filter(|_| !keeps);
        let pose = |k: usize| RefinedPose {
            depth_offsets: offsets(k),
            ..self.refined_pose(k, outcome(k), before[k], after[k])
        };
        let poses = (0..self.given.len()).map(pose).collect();
        Refinement { poses, prior: self.prior, left_out_pairs, distance: self.distance }
    }

    /// Moves all views together, so that their surfaces stay at the given place as a whole.
    fn take_out_common_motion(&mut self, alone: &[bool]) {
        let places = |k: usize, pose: &Isometry3| -> Vec<Point3> {
            self.scene.samples[k].iter().take(PROBES).map(|s| pose * s.in_sensor).collect()
        };
        let paired = (0..alone.len()).filter(|&k| !alone[k]);
        let views: Vec<OfView> = paired
            .map(|k| OfView { from: places(k, &self.poses[k]), to: places(k, &self.given[k]) })
            .collect();
        let back = common_motion(&views);
        for (pose, _) in self.poses.iter_mut().zip(alone).filter(|(_, alone)| !**alone) {
            *pose = back * *pose;
        }
    }

    /// How far a motion moves the surface that a view sees at the scene's typical distance.
    fn surface_moves(&self, motion: &Motion) -> f64 {
        motion.fixed_rows::<3>(0).norm() + motion.fixed_rows::<3>(3).norm() * self.distance
    }

    /// Standard deviation of the place of a view's surface against the other views.
    fn uncertainty(&self, k: usize) -> f64 {
        let variances = self.variances_alone.get(k);
        let motion = variances.map_or(0.0, |v| self.surface_moves(&v.map(f64::sqrt)));
        motion.hypot(self.noise(k))
    }

    /// Median noise of a view's patches.
    fn noise(&self, k: usize) -> f64 {
        median(self.scene.samples[k].iter().map(|s| s.sigma)).unwrap_or(0.0)
    }

    fn refined_pose(
        &self,
        k: usize,
        outcome: PoseOutcome,
        residual_before: Option<f64>,
        residual_after: Option<f64>,
    ) -> RefinedPose {
        let (given, pose) = (self.given[k], self.poses[k]);
        let middle = middle(&self.scene.samples[k]);
        let variance = self.variances.get(k).copied().unwrap_or_else(Motion::zeros);
        let sigma = |first: usize| (variance.rows(first, 3).sum() / 3.0).sqrt();
        RefinedPose {
            view: self.scene.views[k].name().to_owned(),
            world_from_sensor: pose,
            outcome,
            rotation: motion_between(&given, &pose).fixed_rows::<3>(3).norm(),
            translation: (given * middle - pose * middle).norm(),
            sigma: PosePrior { rotation: sigma(3), translation: sigma(0) },
            residual_before,
            residual_after,
            depth_offsets: None,
        }
    }
}

fn middle(samples: &[Sample]) -> Point3 {
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
    distances.into_iter().map(median).collect()
}

/// The upper one of two middle values; `None` of none.
pub(super) fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut list: Vec<f64> = values.into_iter().collect();
    let middle = list.len() / 2;
    (!list.is_empty()).then(|| *list.select_nth_unstable_by(middle, f64::total_cmp).1)
}

impl RefinedPose {
    /// Whether the refined pose differs from the given one.
    pub fn has_moved(&self) -> bool {
        matches!(self.outcome, PoseOutcome::Refined | PoseOutcome::BroughtBack)
    }
}
