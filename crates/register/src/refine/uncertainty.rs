//! Standard deviations of the refined poses.
//!
//! **Problem.** The covariance of the estimate says too much and too little. It holds the motion
//! that all views share, which is taken out of the poses. It shrinks with the prior, which is an
//! estimate itself: of good poses the prior falls towards zero. And a view that was far off is
//! brought back only in the directions that its surfaces determine.
//!
//! **Steps.**
//! 1. The prior is increased by its own standard deviation (from Fisher's information, with the
//!    variances that the observations alone give).
//! 2. The prior of a view is as large as its own motion about its pivot at least: a view that was
//!    far off may be as far off in the directions that no surface determines.
//! 3. The covariance is that of the motions after the rigid fit to the given poses, which is linear
//!    in them.

use super::Rounds;
use super::motion::Motion;
use super::observations::Sample;
use super::solve::{System, about};
use crate::prior::PosePrior;
use crate::tuning::MOTION_POINTS;
use nalgebra::{Matrix3x6, Matrix6};
use transect_device::{Isometry3, Point3, Vector3};

/// The covariance of each view's motion: of its sensor's place, then of its rotation.
pub(super) type Covariances = Vec<Matrix6<f64>>;

impl Rounds<'_> {
    /// The covariances. `weights` are those of the views in their rigid fit to the given poses;
    /// `None` where the priors alone hold the whole.
    pub(super) fn covariances(&self, weights: Option<&[f64]>) -> Option<Covariances> {
        let system = &self.whole_system()?;
        let fit = weights.map(|weights| self.fit(weights));
        let mut prior = self.prior;
        if !self.stated {
            let loose = scaled(&prior, self.first.rotation / prior.rotation);
            let covariances = self.covariances_with(system, &self.own_or(loose), fit.as_deref())?;
            prior = scaled(
                &loose,
                largest_share(
                    prior.rotation / loose.rotation,
                    |k, c| {
                        let known = self.prior_of(k).is_some();
                        let unit = if c < 3 { loose.translation } else { loose.rotation };
                        let at_pivot = self.pivots.pivot_from_sensor(k).row(c).transpose();
                        let variance = at_pivot.dot(&(covariances.get(k)? * at_pivot));
                        (!known).then(|| variance / unit.powi(2))
                    },
                    covariances.len(),
                ),
            );
        }
        let mut priors = self.own_or(prior);
        for (k, (prior, motion)) in priors.iter_mut().zip(self.motions()).enumerate() {
            let motion = self.pivots.pivot_from_sensor(k) * motion;
            let [shift, turn] = [0, 3].map(|first| motion.fixed_rows::<3>(first).norm());
            let lever = self.distance * self.pivots.lever();
            prior.translation = prior.translation.max(shift).max(turn * lever);
            prior.rotation = prior.rotation.max(turn).max(shift / lever);
        }
        self.covariances_with(system, &priors, fit.as_deref())
    }

    /// For each view, the matrix that takes its motion to its force on the rigid fit: the sum over
    /// its samples of their motions.
    pub(super) fn fit(&self, weights: &[f64]) -> Vec<Matrix6<f64>> {
        let of_view = |(k, weight): (usize, &f64)| {
            let (Some(pose), Some(samples)) = (self.poses.get(k), self.scene.samples.get(k)) else {
                return Matrix6::zeros();
            };
            let moves = samples.iter().take(MOTION_POINTS).map(|sample| {
                let moves = place_from_motion(&(pose.rotation * sample.in_sensor.coords));
                moves.tr_mul(&moves) * *weight
            });
            moves.sum()
        };
        weights.iter().enumerate().map(of_view).collect()
    }

    pub(super) fn covariances_with(
        &self,
        system: &System,
        priors: &[PosePrior],
        fit: Option<&[Matrix6<f64>]>,
    ) -> Option<Covariances> {
        let moved = self.motions();
        let root = system.solve(self.independent, &self.known_before(priors, &moved))?.root();
        // Motions are `root^T` times independent numbers of variance 1.
        let motion = |k: usize| root.fixed_columns::<6>(6 * k).transpose();
        let mut motions: Vec<_> = (0..priors.len()).map(motion).collect();
        if let Some(fit) = fit {
            // How the whole moves each view's sensor.
            let shared = |k: usize| {
                let at = Point3::from(self.poses[k].translation.vector);
                about(&(self.scene.origin - at)).transpose()
            };
            let shared: Vec<Matrix6<f64>> = (0..priors.len()).map(shared).collect();
            let mut matrix = Matrix6::zeros();
            let mut right = nalgebra::Matrix6xX::zeros(root.nrows());
            for ((shared, fit), motion) in shared.iter().zip(fit).zip(&motions) {
                let force = shared.tr_mul(fit);
                matrix += force * shared;
                right += force * motion;
            }
            let common = matrix.cholesky()?.solve(&right);
            for (motion, shared) in motions.iter_mut().zip(&shared) {
                *motion -= shared * &common;
            }
        }
        Some(motions.iter().map(|motion| motion * motion.transpose()).collect())
    }

    /// The prior of each view: its own, or this one.
    pub(super) fn own_or(&self, prior: PosePrior) -> Vec<PosePrior> {
        (0..self.given.len()).map(|k| self.prior_of(k).unwrap_or(prior)).collect()
    }
}

/// The estimated share of a loose prior, increased by the standard deviation of the estimate.
/// `variance` tells the variances of some views under the loose prior, in units of its own.
fn largest_share(share: f64, variance: impl Fn(usize, usize) -> Option<f64>, views: usize) -> f64 {
    let of_views = (0..views).flat_map(|k| (0..6).map(move |c| (k, c)));
    let information: f64 = of_views
        .filter_map(|(k, c)| variance(k, c))
        .map(|v| v.min(1.0 - 1e-9))
        // What the observations alone leave uncertain.
        .map(|v| 0.5 / (share.powi(2) + v / (1.0 - v)).powi(2))
        .sum();
    (share.powi(2) + information.powf(-0.5)).sqrt().min(share.max(1.0))
}

fn scaled(prior: &PosePrior, by: f64) -> PosePrior {
    PosePrior { rotation: by * prior.rotation, translation: by * prior.translation }
}

/// Whether a motion is within what it is uncertain by: on average over its six components.
pub(super) fn is_within(motion: &Motion, covariance: &Matrix6<f64>) -> bool {
    let square = covariance.cholesky().map(|factor| motion.dot(&factor.solve(motion)));
    square.is_some_and(|square| square <= 6.0)
}

/// The covariance of a motion whose errors of place and rotation are independent.
pub(super) fn independent(sigma: &PosePrior) -> Matrix6<f64> {
    let variance = |c: usize| if c < 3 { sigma.translation } else { sigma.rotation }.powi(2);
    Matrix6::from_diagonal(&Motion::from_fn(|c, _| variance(c)))
}

/// Root mean square, over these samples of a view, of the standard deviation of the sample's place
/// along its normal.
pub(super) fn sigma_along_normals(
    samples: &[Sample],
    pose: &Isometry3,
    covariance: &Matrix6<f64>,
) -> Option<f64> {
    let variance = |sample: &Sample| {
        let moves = place_from_motion(&(pose.rotation * sample.in_sensor.coords));
        let along = moves.tr_mul(&(pose.rotation * sample.normal));
        along.dot(&(covariance * along))
    };
    let variances = samples.iter().take(MOTION_POINTS).map(variance);
    let count = variances.len();
    (count > 0).then(|| (variances.sum::<f64>() / count as f64).sqrt())
}

/// How a motion of a sensor moves the place at the end of an arm from it.
fn place_from_motion(arm: &Vector3) -> Matrix3x6<f64> {
    let mut moves = Matrix3x6::identity();
    moves.fixed_view_mut::<3, 3>(0, 3).copy_from(&-arm.cross_matrix());
    moves
}

/// Root mean square over the axes of the standard deviations of rotation and translation.
pub(super) fn sigma(covariance: &Matrix6<f64>) -> PosePrior {
    let of = |first: usize| {
        ((0..3).map(|c| covariance[(first + c, first + c)]).sum::<f64>() / 3.0).sqrt()
    };
    PosePrior { rotation: of(3), translation: of(0) }
}
