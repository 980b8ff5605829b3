//! The result of a refinement: what moved, how far, and what that is worth.

use super::Rounds;
use super::common_motion::{OfView, common_motion};
use super::left_out::LeftOut;
use super::motion::{Motion, motion_between};
use super::observations::{Pieces, Sample, State};
use super::pairs::{Pair, Spread};
use super::solve::System;
use super::uncertainty::{Covariances, independent, is_within, sigma, sigma_along_normals};
use crate::prior::PosePrior;
use crate::tuning::{
    FAR_OFF, FIRST_ROTATION_DEGREES, GATE, MISPLACED, MOTION_POINTS, NEGLIGIBLE, OBSERVATIONS,
    SAMPLING_ROUGH,
};
use nalgebra::Matrix6;
use std::collections::BTreeSet;
use transect_device::{DepthOffsets, Isometry3, Point3, Vector3, median};

/// The outcome for the pose of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PoseOutcome {
    /// It moved.
    Refined,
    /// It was farther off than the prior explains, and the other views brought it back.
    BroughtBack,
    /// It stays as given. Observations that were left out of the estimate do not clearly agree
    /// better, or no view moves by more than its standard deviation. It also stays if only the
    /// poses of some other views are wrong.
    Kept,
    /// It stays as given: no other view sees enough of the same surfaces.
    Alone,
    /// It stays as given, though it contradicts the other views: no nearby pose agrees with them,
    /// or a scale of its lengths explains them better than a motion.
    Misplaced,
}

/// The refined pose of one view.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct RefinedPose {
    /// The name of the view.
    pub view: String,
    /// World coordinates from sensor coordinates; the given pose unless the view moved.
    pub world_from_sensor: Isometry3,
    /// Its outcome.
    pub outcome: PoseOutcome,
    /// Angle between the given pose and the refined one, in radians.
    pub rotation: f64,
    /// Distance that the middle of the view's surface moved, in the model's length unit.
    pub translation: f64,
    /// Standard deviations of the refined pose after the rigid fit of all views to the given ones.
    /// Directions that no other view determines have that of the given pose. `None` for a view that
    /// is alone or misplaced, unless it was stated how far its pose may be wrong. `None` if the
    /// images contradict that ([`PoseRefinement::prior_by_images`]).
    pub sigma: Option<PosePrior>,
    /// By how much the view's surface may be off with this pose: root mean square over the surface
    /// of the standard deviation along its normals, in the model's length unit. `None` where
    /// `sigma` is.
    pub surface_sigma: Option<f64>,
    /// Median distance between the view's surface and those of the other views at the given poses,
    /// in the model's length unit; `None` without overlap. Patches behind a surface do not count.
    pub residual_before: Option<f64>,
    /// The same at the refined poses, from the same pairs of views.
    pub residual_after: Option<f64>,
    /// The error of the view's depth camera, which its images must lose at the refined pose;
    /// `None` for other sensors, and for a camera without a visible error.
    #[serde(flatten, serialize_with = "in_short")]
    pub depth_offsets: Option<DepthOffsets>,
}

/// The result of [`refine`](super::refine).
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PoseRefinement {
    /// One for each view, in their order.
    pub poses: Vec<RefinedPose>,
    /// How far the given poses were taken to be wrong, of views that do not state their own.
    pub prior: PosePrior,
    /// Change of the squared distances of the pairs that were left out of the estimate, as a share:
    /// -0.5 is half of them. Of pairs that alone hold their views, halves are left out. `None` if
    /// no views overlap.
    pub left_out_pairs: Option<f64>,
    /// How far the poses are wrong by the images, if far less was stated of them and holds them.
    /// They stay as given then, and nothing is known of their standard deviations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prior_by_images: Option<PosePrior>,
    /// Median distance of the patches from their sensors, in the model's length unit.
    pub distance: f64,
    /// `fx` and `fy` of a depth camera over the true ones, if the images show that they are wrong.
    /// The given poses and depths stay then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focal_over_true: Option<[f64; 2]>,
}

impl PoseRefinement {
    /// Whether refined views turned by more than poses usually err, by 3°. Where another reading
    /// explains the contradictions, too, such turns bend the poses to what was misread.
    pub fn bends_poses(&self) -> bool {
        let refined = self.poses.iter().filter(|pose| pose.outcome == PoseOutcome::Refined);
        refined.map(|pose| pose.rotation.to_degrees()).any(|turn| turn > FIRST_ROTATION_DEGREES)
    }
}

/// The error of a camera in reports: the root mean square of its offsets, and its depths over
/// the true ones if its scale is wrong. The scan that registration writes has all values.
#[derive(serde::Serialize)]
struct CameraError {
    #[serde(skip_serializing_if = "Option::is_none")]
    depth_offsets: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    depths_over_true: Option<f64>,
}

fn in_short<S: serde::Serializer>(
    offsets: &Option<DepthOffsets>,
    out: S,
) -> Result<S::Ok, S::Error> {
    let scale = offsets.as_ref().map(DepthOffsets::scale);
    let error = CameraError {
        depth_offsets: offsets.as_ref().map(DepthOffsets::rms),
        depths_over_true: scale.filter(|scale| *scale != 1.0).map(f64::recip),
    };
    serde::Serialize::serialize(&error, out)
}

impl Rounds<'_> {
    /// The view that fits the others worst, if it is misplaced: far worse than the others and than
    /// its noise and its pixels explain, and hardly better than at its given pose.
    pub(super) fn worst_view(&self) -> Option<usize> {
        let [before, after] = self.residuals();
        let typical = median(after.iter().flatten().copied())?;
        let views = before.iter().zip(&after).enumerate();
        let misplaced = views.filter_map(|(k, (before, after))| {
            let after = (*after)?;
            let explained = (GATE * self.noise(k)).max(SAMPLING_ROUGH * self.spacing(k));
            let worse = after > MISPLACED * typical && after > explained;
            (worse && after > 0.5 * (*before)?).then_some((k, after))
        });
        misplaced.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
    }

    /// The view that moved farthest of those that are far off. It may have drawn the others with
    /// it, and came to a pose near its given one, which need not be the best.
    pub(super) fn farthest_off(&self) -> Option<usize> {
        let motions = self.motions();
        let moved = |k: &usize| self.surface_moves(&motions[*k]);
        let far_off = self.far_off(|| self.whole_system());
        let views = (0..far_off.len()).filter(|k| far_off[*k]);
        views.max_by(|a, b| moved(a).total_cmp(&moved(b)))
    }

    pub(super) fn finish(mut self, misplaced: &[usize]) -> PoseRefinement {
        let parts = self.systems();
        let left_out = self.left_out(&parts);
        let system = System::sum(&parts);
        let by_images = system.as_ref().and_then(|system| self.prior_by_images(system));
        let alone: Vec<bool> = self.with_pairs().into_iter().map(|met| !met).collect();
        // Where views state how exact their poses are, the most exact ones hold the whole.
        let unstated = self.scene.views.iter().all(|view| view.prior().is_none());
        let weights = unstated.then(|| self.take_out_common_motion(&alone));
        let far_off = self.far_off(|| system);
        let covariances = self.covariances(weights.as_deref());
        let unclear = !left_out.as_ref().is_some_and(LeftOut::is_clear);
        if by_images.is_some() {
            // Errors of cameras explain those of the poses that the prior holds.
            self.focal_over_true = None;
        }
        let unclear = unclear || by_images.is_some();
        let keeps = self.keeps_given(unclear, covariances.as_ref());
        // Views that err alike carry others with them, of which no observation tells.
        let stays: Vec<bool> =
            alone.iter().enumerate().map(|(k, alone)| *alone || self.is_exact(k)).collect();
        for k in (0..self.given.len()).filter(|k| stays[*k]) {
            self.poses[k] = self.given[k];
        }
        let outcome = |k: usize| match () {
            () if misplaced.contains(&k) => PoseOutcome::Misplaced,
            () if alone[k] => PoseOutcome::Alone,
            () if keeps || stays[k] => PoseOutcome::Kept,
            () if far_off[k] => PoseOutcome::BroughtBack,
            () => PoseOutcome::Refined,
        };
        let [before, after] = self.residuals();
        let pose = |k: usize| {
            let (rotation, translation) = self.moved_by(k);
            let error = self.covariance(k, outcome(k), covariances.as_ref());
            let error = error.filter(|_| by_images.is_none());
            RefinedPose {
                view: self.scene.views[k].name().to_owned(),
                world_from_sensor: self.poses[k],
                outcome: outcome(k),
                rotation,
                translation,
                sigma: error.as_ref().map(sigma),
                surface_sigma: error.and_then(|error| self.surface_sigma(k, &error)),
                residual_before: before[k],
                residual_after: after[k],
                depth_offsets: self.cameras.of_view(k),
            }
        };
        let poses = (0..self.given.len()).map(pose).collect();
        PoseRefinement {
            poses,
            prior: self.prior,
            prior_by_images: by_images,
            left_out_pairs: left_out.map(|left_out| left_out.change),
            distance: self.distance,
            focal_over_true: self.focal_over_true,
        }
    }

    /// Puts the views back to their given poses where these stay, and says whether they do.
    fn keeps_given(&mut self, unclear: bool, covariances: Option<&Covariances>) -> bool {
        // Poses and depths would bend to the wrong focal lengths.
        let holds = unclear || self.focal_over_true.is_some();
        if holds {
            self.cameras = self.cameras.without_errors();
        }
        self.drop_negligible_errors();
        let keeps = holds || covariances.is_some_and(|c| self.is_settled(c));
        if keeps {
            self.poses = self.given.clone();
        }
        keeps
    }

    /// Drops the errors of cameras that stay far below the noise.
    fn drop_negligible_errors(&mut self) {
        let noise = median((0..self.given.len()).map(|k| self.noise(k))).unwrap_or(0.0);
        self.cameras = self.cameras.with_errors_from(NEGLIGIBLE * noise, self.distance);
    }

    /// How far the pose of a view may be wrong. What other views tell of their poses says nothing
    /// about a view that does not meet them: it has what was stated.
    fn covariance(
        &self,
        k: usize,
        outcome: PoseOutcome,
        covariances: Option<&Covariances>,
    ) -> Option<Matrix6<f64>> {
        let by_prior = match outcome {
            PoseOutcome::Alone | PoseOutcome::Misplaced => {
                self.scene.views[k].prior().or(self.stated.then_some(self.prior))
            }
            _ => match covariances {
                Some(covariances) => return Some(covariances[k]),
                None => Some(self.priors()[k]),
            },
        };
        by_prior.as_ref().map(independent)
    }

    fn surface_sigma(&self, k: usize, covariance: &Matrix6<f64>) -> Option<f64> {
        sigma_along_normals(&self.scene.samples[k], &self.poses[k], covariance)
    }

    /// Whether no view moves by more than it is uncertain by. Another refinement of refined poses
    /// would move them by the last steps of its rounds.
    fn is_settled(&self, covariances: &Covariances) -> bool {
        self.motions().iter().zip(covariances).all(|(motion, c)| is_within(motion, c))
    }

    /// Which views meet another one.
    pub(super) fn with_pairs(&self) -> Vec<bool> {
        let mut met = vec![false; self.given.len()];
        self.pairs.iter().flat_map(|pair| [pair.a, pair.b]).for_each(|k| met[k] = true);
        met
    }

    /// Which views turned or shifted far more than most, and moved by more than their images and
    /// poses are uncertain by. The system of all pairs takes as long as a round: it is asked for
    /// only where a view moved far.
    pub(super) fn far_off(&self, system: impl FnOnce() -> Option<System>) -> Vec<bool> {
        let motions = self.motions();
        let parts = [0, 3].map(|part| move |motion: &Motion| motion.fixed_rows::<3>(part).norm());
        // A view that meets no other one does not move.
        let met = self.with_pairs();
        let met = || motions.iter().zip(&met).filter_map(|(motion, met)| met.then_some(motion));
        let typical = parts.map(|part| median(met().map(part)).unwrap_or(0.0));
        let is_unusual = |motion: &Motion| {
            parts.iter().zip(typical).any(|(part, typical)| part(motion) > FAR_OFF * typical)
        };
        if !motions.iter().any(is_unusual) {
            return vec![false; motions.len()];
        }
        let system = system();
        let apart = median(medians(&self.pairs, self.given.len()).into_iter().flatten());
        let apart = apart.unwrap_or(0.0);
        let priors = self.priors();
        let known_before = self.known_before(&priors, &motions);
        let is_far_off = |(k, motion): (usize, &Motion)| {
            let alone =
                |system: &System| system.variances_alone(k, self.independent, &known_before);
            let variances = system.as_ref().map_or_else(Motion::zeros, alone);
            let uncertain = self.surface_moves(&variances.map(f64::sqrt)).hypot(self.noise(k));
            let allowed = GATE * apart.hypot(uncertain);
            is_unusual(motion) && self.surface_moves(motion) > allowed
        };
        motions.iter().enumerate().map(is_far_off).collect()
    }

    /// Median distances of each view's patches from the other views' surfaces at the given and at
    /// the present poses: of the same pairs, found within the same reach.
    pub(super) fn residuals(&self) -> [Vec<Option<f64>>; 2] {
        let sound = self.cameras.without_errors();
        let states = [
            State { poses: &self.given, cameras: &sound },
            State { poses: &self.poses, cameras: &self.cameras },
        ];
        let observe = |s| self.observed(s, self.first, OBSERVATIONS / 4, Spread::Narrow);
        let mut pairs = states.map(observe);
        let ends = |pairs: &[Pair]| pairs.iter().map(|p| (p.a, p.b)).collect::<BTreeSet<_>>();
        let both = &ends(&pairs[0]) & &ends(&pairs[1]);
        pairs.iter_mut().for_each(|pairs| pairs.retain(|p| both.contains(&(p.a, p.b))));
        pairs.map(|pairs| medians(&pairs, self.given.len()))
    }

    /// Moves all views together, so that their surfaces stay at the given place as a whole. Returns
    /// the weights of the views.
    fn take_out_common_motion(&mut self, alone: &[bool]) -> Vec<f64> {
        let places = |k: usize, pose: &Isometry3| -> Vec<Point3> {
            self.scene.samples[k].iter().take(MOTION_POINTS).map(|s| pose * s.in_sensor).collect()
        };
        let paired = (0..alone.len()).filter(|&k| !alone[k]);
        let views: Vec<OfView> = paired
            .map(|k| OfView { from: places(k, &self.poses[k]), to: places(k, &self.given[k]) })
            .collect();
        let (back, weights) = common_motion(&views);
        let mut weights = weights.into_iter();
        let mut of_view = |(pose, alone): (&mut Isometry3, &bool)| {
            if *alone {
                return 0.0;
            }
            *pose = back * *pose;
            weights.next().unwrap_or(0.0)
        };
        self.poses.iter_mut().zip(alone).map(&mut of_view).collect()
    }

    /// How far a motion moves the surface that a view sees at the scene's typical distance.
    fn surface_moves(&self, motion: &Motion) -> f64 {
        motion.fixed_rows::<3>(0).norm() + motion.fixed_rows::<3>(3).norm() * self.distance
    }

    /// Median noise of a view's patches.
    fn noise(&self, k: usize) -> f64 {
        median(self.scene.samples[k].iter().map(|s| s.sigma)).unwrap_or(0.0)
    }

    /// Median distance between the samples of a view's patches. Without noise, a patch departs from
    /// a bent surface by up to [`SAMPLING_ROUGH`] of it. Its standard deviation tells less: it is
    /// that of a mean of independent errors. A view may meet the others on bent surfaces alone.
    fn spacing(&self, k: usize) -> f64 {
        let view = self.scene.views[k];
        let sides = view.patches().map(|(_, patch)| 2.0 * patch.radius());
        median(sides).unwrap_or(0.0) / view.step() as f64
    }

    /// Angle, and distance of the middle of a view's surface, between its given and present poses.
    fn moved_by(&self, k: usize) -> (f64, f64) {
        let (given, pose) = (self.given[k], self.poses[k]);
        let middle = middle(&self.scene.samples[k]);
        let turned = motion_between(&given, &pose).fixed_rows::<3>(3).norm();
        (turned, (given * middle - pose * middle).norm())
    }
}

fn middle(samples: &[Sample]) -> Point3 {
    let sum = samples.iter().map(|s| s.in_sensor.coords).sum::<Vector3>();
    Point3::from(sum / samples.len().max(1) as f64)
}

/// Median distance of each view's patches from the surfaces of the others.
///
/// Only patches in front of a surface count. The surface may hide those behind it, as one of two
/// parallel plates hides the other. If two views contradict each other, each pair is compared in
/// both directions, and one view's patches lie in front of the other's surface.
pub(super) fn medians(pairs: &[Pair], views: usize) -> Vec<Option<f64>> {
    let mut distances = vec![Vec::new(); views];
    for pair in pairs.iter().filter(|pair| pair.of == Pieces::Patches) {
        let found = pair.observations.iter().map(|o| o.distance).filter(|d| *d >= 0.0);
        for view in [pair.a, pair.b] {
            if let Some(list) = distances.get_mut(view) {
                list.extend(found.clone());
            }
        }
    }
    distances.into_iter().map(median).collect()
}

impl RefinedPose {
    /// By how much the surface may be off, if `stated` was known with the given pose: that of a
    /// view that stays is as it was.
    pub fn surface_sigma_after(&self, stated: Option<f64>) -> Option<f64> {
        stated.filter(|_| !self.has_moved()).or(self.surface_sigma)
    }

    /// Whether the refined pose differs from the given one.
    pub fn has_moved(&self) -> bool {
        matches!(self.outcome, PoseOutcome::Refined | PoseOutcome::BroughtBack)
    }
}
