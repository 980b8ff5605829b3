//! The most probable motions of all views, given what pairs say and how far poses may be wrong.

use super::pairs::Sums;
use crate::coarse::PosePrior;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix6, Vector6};
use transect_device::{Isometry3, Point3, Vector3};

/// A rigid motion to first order: translation of the sensor, and rotation about it.
pub type Motion = Vector6<f64>;

/// The linear system of all motions.
pub struct System {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
}

/// The solution of a system.
pub struct Solution {
    /// One motion for each view.
    pub motions: Vec<Motion>,
    factor: Cholesky<f64, Dyn>,
}

impl System {
    /// What the pairs say, each with the share of its observations that is independent. Motions
    /// turn about the sensors; pairs' sums about `origin`.
    pub fn new<'a>(
        sensors: &[Point3],
        origin: Point3,
        sums: impl IntoIterator<Item = &'a Sums>,
        independent: f64,
    ) -> Self {
        let n = 6 * sensors.len();
        let shifts: Vec<Matrix6<f64>> = sensors.iter().map(|s| about(&(s - origin))).collect();
        let (mut matrix, mut right) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for s in sums {
            let (Some(at_a), Some(at_b)) = (shifts.get(s.a), shifts.get(s.b)) else { continue };
            let information = s.matrix * independent;
            let mut add = |i: usize, j: usize, block: Matrix6<f64>| {
                let mut view = matrix.fixed_view_mut::<6, 6>(6 * i, 6 * j);
                view += block;
            };
            add(s.a, s.a, at_a * information * at_a.transpose());
            add(s.b, s.b, at_b * information * at_b.transpose());
            add(s.a, s.b, -at_a * information * at_b.transpose());
            add(s.b, s.a, -at_b * information * at_a.transpose());
            let force = s.vector * independent;
            let mut push = |i: usize, force: Vector6<f64>| {
                let mut view = right.fixed_rows_mut::<6>(6 * i);
                view += force;
            };
            push(s.a, -at_a * force);
            push(s.b, at_b * force);
        }
        Self { matrix, right }
    }

    /// The motions that balance the pairs with the views' priors, which pull each view back by what
    /// it has `moved` so far. `None` if the numbers are not finite.
    pub fn solve(&self, priors: &[PosePrior], moved: &[Motion]) -> Option<Solution> {
        let (mut matrix, mut right) = (self.matrix.clone(), self.right.clone());
        for (k, (moved, prior)) in moved.iter().zip(priors).enumerate() {
            let strength = strength(prior);
            for c in 0..6 {
                matrix[(6 * k + c, 6 * k + c)] += strength[c];
                right[6 * k + c] -= strength[c] * moved[c];
            }
        }
        let factor = matrix.cholesky()?;
        let solution = factor.solve(&right);
        let motions = (0..moved.len()).map(|k| solution.fixed_rows::<6>(6 * k).into_owned());
        let motions: Vec<Motion> = motions.collect();
        motions
            .iter()
            .all(|m| m.iter().all(|c| c.is_finite()))
            .then_some(Solution { motions, factor })
    }
}

impl Solution {
    /// Variances of every view's motion.
    pub fn variances(&self) -> Vec<Motion> {
        let inverse = self.factor.inverse();
        let of = |k: usize| Motion::from_fn(|c, _| inverse[(6 * k + c, 6 * k + c)]);
        (0..self.motions.len()).map(of).collect()
    }
}

/// 1 / variance of each component of a motion.
fn strength(prior: &PosePrior) -> [f64; 6] {
    let (t, r) = (prior.translation.powi(-2), prior.rotation.powi(-2));
    [t, t, t, r, r, r]
}

/// Turns a gradient about the origin into one about a point at `offset` from it. Its transpose
/// turns motions the other way.
pub fn about(offset: &Vector3) -> Matrix6<f64> {
    let mut shift = Matrix6::identity();
    let cross = -offset.cross_matrix();
    shift.fixed_view_mut::<3, 3>(3, 0).copy_from(&cross);
    shift
}

/// The pose after a motion.
pub fn moved(world_from_sensor: &Isometry3, motion: &Motion) -> Isometry3 {
    let turn = nalgebra::UnitQuaternion::from_scaled_axis(motion.fixed_rows::<3>(3).into_owned());
    let shift = motion.fixed_rows::<3>(0).into_owned();
    let at = world_from_sensor.translation.vector + shift;
    Isometry3::from_parts(at.into(), turn * world_from_sensor.rotation)
}

/// The motion between two poses.
pub fn motion_between(from: &Isometry3, to: &Isometry3) -> Motion {
    let shift = to.translation.vector - from.translation.vector;
    let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
    Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
}

/// How far poses are wrong, from how far they moved (MacKay, 1992: the evidence for a prior).
///
/// A direction that the observations determine well shows the error of its pose. One that they do
/// not determine stays at 0 and shows nothing; `variances` tell which is which. The ratio of
/// rotation to translation stays: along a tunnel no observation limits the translation, but the
/// rotations show that the poses are exact.
pub fn estimated_prior(prior: &PosePrior, moved: &[Motion], variances: &[Motion]) -> PosePrior {
    let strength = Motion::from(strength(prior));
    let squares: f64 = moved.iter().map(|m| m.component_mul(m).dot(&strength)).sum();
    let unknown: f64 = variances.iter().map(|v| v.dot(&strength)).sum();
    let known = (6 * moved.len()) as f64 - unknown;
    // Half a component at least, so that a prior that explains nothing shrinks step by step.
    let factor = (squares / known.max(0.5)).sqrt().clamp(1e-3, 1e3);
    PosePrior { rotation: factor * prior.rotation, translation: factor * prior.translation }
}
