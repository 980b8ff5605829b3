//! The most probable motions of all views and offsets of all cameras, given what pairs say and how
//! far poses may be wrong.
//!
//! **Errors of normals.** The change of a distance with a motion is that along the patch's normal.
//! A normal that errs by σ also seems to determine the directions across it, by σ² of what it says
//! along itself. Where neighbouring pixels share their noise σ is 0.1 to 0.3 rad, and the sum over
//! all patches outweighs how far poses may be wrong. So that part is taken off what each pair says
//! (`doubt`), with the σ by which both views' normals differ. Measured on 13 simulated kitchens,
//! most with such noise: without it, five sound cameras were told to have a wrong scale or focal
//! length; with it one, at four times the usual noise.

use super::camera::{Cameras, UNKNOWNS};
use super::drift::Drift;
use super::motion::{Motion, sizes};
use super::pairs::Portion;
use super::pivot::Pivots;
use crate::prior::PosePrior;
use nalgebra::{
    Cholesky, DMatrix, DMatrixView, DVector, Dyn, Matrix3, Matrix6, Matrix6xX, Vector6,
};
use transect_device::{Point3, Vector3};

/// The linear system of all motions, and of the offsets of all cameras after them.
#[derive(Debug, Clone)]
pub struct System {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    /// Sum of the weighted squares where nothing moves.
    square: f64,
}

/// The solution of a system.
pub struct Solution {
    /// The motions of all views, and the changes of all cameras' offsets.
    pub unknowns: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
}

/// The place of what pairs say: motions turn about the sensors, gradients of pairs about `origin`.
pub struct Ground<'a> {
    pub sensors: &'a [Point3],
    pub origin: Point3,
    pub cameras: &'a Cameras,
}

impl System {
    /// The system of the observations of pairs.
    pub fn of(portions: &[Portion<'_>], ground: &Ground<'_>) -> Self {
        let n = 6 * ground.sensors.len() + ground.cameras.unknowns();
        let (matrix, right) = (DMatrix::zeros(n, n), DVector::zeros(n));
        let mut system = Self { matrix, right, square: 0.0 };
        let cameras = ground.cameras.unknowns();
        let mut half = DMatrix::zeros(cameras, cameras);
        for portion in portions {
            system.add(portion, ground, &mut half);
        }
        let first = n - cameras;
        let both = &half + half.transpose();
        system.matrix.view_mut((first, first), (cameras, cameras)).copy_from(&both);
        system
    }

    /// Adds what a portion says, but for the matrix of the cameras' offsets: `half` gathers one
    /// half of it, and the other half is its transpose.
    fn add(&mut self, portion: &Portion<'_>, ground: &Ground<'_>, half: &mut DMatrix<f64>) {
        let pair = portion.pair;
        let (mut information, mut force) = (Matrix6::zeros(), Vector6::zeros());
        let mut directions = Directions::default();
        let cameras = ground.cameras.unknowns();
        let mut crossed = Matrix6xX::zeros(cameras);
        let first = 6 * ground.sensors.len();
        for o in portion.observations() {
            let weight = pair.weight(o) * o.share;
            if weight == 0.0 {
                continue;
            }
            let weighted = o.gradient * weight;
            information += weighted * o.gradient.transpose();
            force += weighted * o.distance;
            directions.add(&o.arm, weight);
            self.square += weight * o.distance.powi(2);
            let (terms, count) = pair.camera_terms(o, ground.cameras);
            let terms = terms.get(..count).unwrap_or(&[]);
            for (k, (i, slope)) in terms.iter().enumerate() {
                let mut to = crossed.fixed_columns_mut::<1>(*i);
                to += weighted * *slope;
                self.right[first + i] -= weight * slope * o.distance;
                let mut to = half.column_mut(*i);
                to[*i] += 0.5 * weight * slope * slope;
                for (j, other) in terms.iter().take(k) {
                    to[*j] += weight * slope * other;
                }
            }
        }
        if let Some(Doubt { taken, share, spare }) = doubt(&information, &directions, pair.turned) {
            let spared = spare * &crossed;
            half.gemm(-0.5, &spared.transpose(), &spared, 1.0);
            let mut to = self.right.rows_mut(first, cameras);
            to += spared.tr_mul(&(spare * force));
            // Small parts are taken off, so that the rest is exact where normals nearly are.
            information -= taken;
            crossed -= share * &crossed;
            force -= share * force;
        }
        let at = |view: usize| about(&(ground.sensors[view] - ground.origin));
        let ends = [(pair.a, at(pair.a), 1.0), (pair.b, at(pair.b), -1.0)];
        for (i, at_i, sign_i) in &ends {
            for (j, at_j, sign_j) in &ends {
                let mut to = self.matrix.fixed_view_mut::<6, 6>(6 * i, 6 * j);
                to += at_i * information * at_j.transpose() * (sign_i * sign_j);
            }
            let mut to = self.right.fixed_rows_mut::<6>(6 * i);
            to -= at_i * force * *sign_i;
            let mut to = self.matrix.view_mut((first, 6 * i), (cameras, 6));
            to += (at_i * &crossed * *sign_i).transpose();
        }
    }

    /// The sum of all parts; `None` without parts.
    pub fn sum(parts: &[Self]) -> Option<Self> {
        let (first, others) = parts.split_first()?;
        let mut sum = first.clone();
        for other in others {
            sum.matrix += &other.matrix;
            sum.right += &other.right;
            sum.square += other.square;
        }
        Some(sum)
    }

    /// The rest without a part.
    pub fn without(&self, part: &Self) -> Self {
        let (matrix, right) = (&self.matrix - &part.matrix, &self.right - &part.right);
        Self { matrix, right, square: self.square - part.square }
    }

    /// The weighted squares after motions and changes of offsets.
    pub fn square_after(&self, unknowns: &DVector<f64>) -> f64 {
        // The part above the diagonal is not filled for motions beside offsets.
        let m = self.matrix.lower_triangle();
        let (lower, diagonal) = (unknowns.dot(&(&m * unknowns)), m.diagonal());
        let on = diagonal.component_mul(unknowns).dot(unknowns);
        self.square - 2.0 * self.right.dot(unknowns) + 2.0 * lower - on
    }

    /// Variances of the motion of a view if everything else stays where it is. They leave out the
    /// motion that all views share.
    pub fn variances_alone(&self, view: usize, independent: f64, before: &Before<'_>) -> Motion {
        let own = self.matrix.fixed_view::<6, 6>(6 * view, 6 * view) * independent;
        let information = own + before.in_units(view).tr_mul(&before.in_units(view));
        information.try_inverse().map_or_else(Motion::zeros, |inverse| inverse.diagonal())
    }

    /// The motions and offsets that balance the pairs, of which a share is independent, with what
    /// was known before. `None` if the numbers are not finite.
    pub fn solve(&self, independent: f64, before: &Before<'_>) -> Option<Solution> {
        let (mut matrix, mut right) = (&self.matrix * independent, &self.right * independent);
        let pivoted: Vec<_> = (0..before.moved.len()).map(|k| before.in_units(k)).collect();
        for (i, of_i) in pivoted.iter().enumerate() {
            for (j, (of_j, moved)) in pivoted.iter().zip(before.moved).enumerate() {
                let precision = of_i.tr_mul(of_j) * before.drift.precision()[(i, j)];
                let mut to = matrix.fixed_view_mut::<6, 6>(6 * i, 6 * j);
                to += precision;
                let mut to = right.fixed_rows_mut::<6>(6 * i);
                to -= precision * moved;
            }
        }
        for (k, camera) in before.cameras.list.iter().enumerate() {
            let first = 6 * before.moved.len() + UNKNOWNS * k;
            let precision = camera.precision();
            let mut to = matrix.view_mut((first, first), (UNKNOWNS, UNKNOWNS));
            to += &precision;
            let mut to = right.rows_mut(first, UNKNOWNS);
            to -= precision * &camera.errors;
        }
        // Rounding can make the matrix indefinite in a direction that only a loose prior holds. The
        // diagonal grows by the bound of the rounding errors, in shares of itself.
        let rounding = 1.0 + matrix.nrows() as f64 * f64::EPSILON;
        (0..matrix.nrows()).for_each(|k| matrix[(k, k)] *= rounding);
        let factor = matrix.cholesky()?;
        let unknowns = factor.solve(&right);
        unknowns.iter().all(|c| c.is_finite()).then_some(Solution { unknowns, factor })
    }
}

/// The prior knowledge: how far the poses and cameras may be wrong, which
/// pulls each view back by what it has `moved` so far, and how much views err alike.
pub struct Before<'a> {
    pub priors: &'a [PosePrior],
    pub moved: &'a [Motion],
    pub drift: &'a Drift,
    pub pivots: &'a Pivots,
    pub cameras: &'a Cameras,
}

impl Before<'_> {
    /// Takes the motion of a view to that about its pivot, in standard deviations.
    pub fn in_units(&self, view: usize) -> Matrix6<f64> {
        let units = Motion::from(sizes(&self.priors[view]).map(f64::recip));
        Matrix6::from_diagonal(&units) * self.pivots.pivot_from_sensor(view)
    }

    /// The unknowns that take everything back to where it was given.
    pub fn back(&self) -> DVector<f64> {
        let motions = self.moved.iter().flat_map(|m| m.iter());
        let offsets = self.cameras.list.iter().flat_map(|camera| camera.errors.iter());
        DVector::from_vec(motions.chain(offsets).map(|v| -v).collect())
    }
}

impl Solution {
    /// The motion of a view.
    pub fn motion(&self, view: usize) -> Motion {
        self.unknowns.fixed_rows::<6>(6 * view).into_owned()
    }

    /// The inverse of the lower triangular factor `L`: `(L L^T)^-1` is the covariance of all
    /// unknowns.
    pub fn root(&self) -> DMatrix<f64> {
        inverse_of_lower(self.factor.l_dirty().as_view())
    }
}

/// The inverse of a lower triangular matrix, of which the part above the diagonal is not read.
///
/// By halves, so that nearly all of the work is products of matrices, which nalgebra does several
/// times as quickly as substitution.
fn inverse_of_lower(lower: DMatrixView<'_, f64>) -> DMatrix<f64> {
    let n = lower.nrows();
    let half = n / 2;
    let mut inverse = DMatrix::identity(n, n);
    if n < HALVED {
        lower.solve_lower_triangular_mut(&mut inverse);
        return inverse;
    }
    let part = |from: usize, size: usize| lower.view((from, from), (size, size));
    let (first, second) =
        rayon::join(|| inverse_of_lower(part(0, half)), || inverse_of_lower(part(half, n - half)));
    let beside = &second * lower.view((half, 0), (n - half, half)) * &first;
    inverse.view_mut((half, 0), (n - half, half)).copy_from(&-beside);
    inverse.view_mut((0, 0), (half, half)).copy_from(&first);
    inverse.view_mut((half, half), (n - half, n - half)).copy_from(&second);
    inverse
}

/// Rows from which a matrix is inverted by halves. No unit. Chosen by hand: products of smaller
/// parts gain little. Doubled, more of the work is substitution.
const HALVED: usize = 64;

/// Variances of the motions of some views, from the [`Solution::root`].
pub fn variances(root: &DMatrix<f64>, views: usize) -> Vec<Motion> {
    let variance = |row: usize| root.column(row).norm_squared();
    (0..views).map(|k| Motion::from_fn(|c, _| variance(6 * k + c))).collect()
}

/// Least root of what a pair tells about a direction, over what errors of normals seem to tell, by
/// which is divided. No unit. Theory: rounding errors grow with its inverse, and without a limit
/// the system of two views has no solution. Doubled, cameras seem to be known a little better.
const NOTHING: f64 = 0.1;

/// Variance of normals below which they count as exact, in rad²; 0.2°. Chosen by hand: they seem to
/// tell a hundred-thousandth of what is told. Measured on noise-free views of a part: normals have
/// 3e-12, and without this limit rounding leaves no solution. Doubled, nothing changes there.
const EXACT_NORMALS: f64 = 1e-5;

/// The part of what a pair says that the errors of its normals take.
struct Doubt {
    /// That part of the information.
    taken: Matrix6<f64>,
    /// Takes a force to that part.
    share: Matrix6<f64>,
    /// The root of the inverse of the information with that of the errors added to it: its
    /// transpose times it is that inverse.
    spare: Matrix6<f64>,
}

/// What observations would say if each of them determined all three directions: sums of weights,
/// of the arms times them, and of the arms' products.
#[derive(Debug, Default)]
struct Directions {
    weight: f64,
    arm: Vector3,
    square: Matrix3<f64>,
}

impl Directions {
    fn add(&mut self, arm: &[f32; 3], weight: f64) {
        let arm = Vector3::from(arm.map(f64::from));
        self.weight += weight;
        self.arm += arm * weight;
        self.square += arm * arm.transpose() * weight;
    }

    fn information(&self) -> Matrix6<f64> {
        let mut all = Matrix6::zeros();
        let cross = self.arm.cross_matrix();
        all.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(self.weight);
        all.fixed_view_mut::<3, 3>(0, 3).copy_from(&-cross);
        all.fixed_view_mut::<3, 3>(3, 0).copy_from(&cross);
        let turns = Matrix3::identity() * self.square.trace() - self.square;
        all.fixed_view_mut::<3, 3>(3, 3).copy_from(&turns);
        all
    }
}

/// The doubt about what a pair says, from the variance of its normals; `None` where they are exact.
///
/// Normals that err by σ seem to determine every direction across them, by σ² of what surfaces of
/// that direction would determine. That much is taken off what they say.
fn doubt(information: &Matrix6<f64>, directions: &Directions, turned: f64) -> Option<Doubt> {
    if turned < EXACT_NORMALS {
        return None;
    }
    let false_part = (directions.information() - information) * turned;
    let root = false_part.cholesky()?.l();
    let inverse = root.try_inverse()?;
    let told = (inverse * information * inverse.transpose()).symmetric_eigen();
    // Directions that are told by no more than errors of normals say nothing.
    let taken = told.eigenvalues.map(|told| told.min(1.0));
    let shares = told.eigenvalues.map(|told| told.max(1.0).recip());
    let spares = told.eigenvalues.map(|told| told.max(told.sqrt()).max(NOTHING).recip());
    let vectors = told.eigenvectors;
    let spread = |by: &Vector6<f64>| vectors * Matrix6::from_diagonal(by) * vectors.transpose();
    Some(Doubt {
        taken: root * spread(&taken) * root.transpose(),
        share: root * spread(&shares) * inverse,
        spare: spread(&spares) * inverse,
    })
}

/// Turns a gradient about the origin into one about a point at `offset` from it. Its transpose
/// turns motions the other way.
pub fn about(offset: &Vector3) -> Matrix6<f64> {
    let mut shift = Matrix6::identity();
    let cross = -offset.cross_matrix();
    shift.fixed_view_mut::<3, 3>(3, 0).copy_from(&cross);
    shift
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scrambled::scrambled;

    /// Patches of a floor and of a wall, whose normals err by `sigma` about each axis: the sum of
    /// what they say, and of what all directions would.
    fn patches(sigma: f64) -> (Matrix6<f64>, Directions) {
        // From -1 to 1, with a variance of 1/3.
        let random = |k: u32, n: u32| f64::from(scrambled(16 * k + n)) / 2f64.powi(31) - 1.0;
        let (mut information, mut directions) = (Matrix6::zeros(), Directions::default());
        for k in 0..4000 {
            let arm = Vector3::new(random(k, 1), random(k, 2), random(k, 3));
            let error = Vector3::new(random(k, 4), random(k, 5), random(k, 6));
            let error = error * (sigma * 3f64.sqrt());
            let sound = if k % 3 == 0 { Vector3::x() } else { Vector3::z() };
            let normal = (sound + error - sound * sound.dot(&error)).normalize();
            let turn = arm.cross(&normal);
            let gradient = Vector6::new(normal.x, normal.y, normal.z, turn.x, turn.y, turn.z);
            information += gradient * gradient.transpose();
            directions.add(&arm.map(|c| c as f32).into(), 1.0);
        }
        (information, directions)
    }

    #[test]
    fn what_errors_of_normals_seem_to_tell_is_taken_off() {
        let (exact, directions) = patches(0.0);
        assert!(doubt(&exact, &directions, 1e-11).is_none());
        assert!(exact[(1, 1)] < 1e-9, "nothing tells a shift along y");
        for sigma in [0.05, 0.2] {
            let (seen, directions) = patches(sigma);
            let seems = seen[(1, 1)] / (4000.0 * sigma.powi(2));
            assert!((0.9..1.1).contains(&seems), "{seems}");
            let doubt = doubt(&seen, &directions, sigma.powi(2)).unwrap();
            let told = seen - doubt.taken;
            assert!((doubt.taken - doubt.share * seen).amax() < 1e-6 * seen.amax());
            let left = told[(1, 1)] / seen[(1, 1)];
            assert!(left < 0.2, "{left}");
            for (axis, kept) in [(0, 0.8), (2, 0.9)] {
                assert!(told[(axis, axis)] > kept * exact[(axis, axis)], "axis {axis}: {told}");
            }
            // The rest of the information belongs to errors of their own.
            let spared = seen - seen * doubt.spare.tr_mul(&doubt.spare) * seen;
            assert!((told - spared).amax() < 1e-4 * seen.amax());
        }
    }

    #[test]
    fn a_matrix_inverted_by_halves_is_that_of_substitution() {
        for n in [0, 1, HALVED - 1, HALVED, 2 * HALVED + 3] {
            let wave = |i: usize, j: usize| 0.1 * (1.3 * (i * n + j) as f64).sin();
            // What is above the diagonal is not read.
            let matrix = DMatrix::from_fn(n, n, |i, j| if i == j { 2.0 } else { wave(i, j) });
            let mut expected = DMatrix::identity(n, n);
            assert!(matrix.lower_triangle().solve_lower_triangular_mut(&mut expected));
            let found = inverse_of_lower(matrix.as_view());
            assert!((found - expected).iter().all(|off| off.abs() < 1e-12), "{n}");
        }
    }

    #[test]
    fn exact_pairs_beside_a_loose_prior_are_solved() {
        let views = 12;
        let mut matrix = DMatrix::<f64>::zeros(6 * views, 6 * views);
        // Each pair holds its relative motion alone. Nothing holds the motion that all share.
        for (a, b) in (0..views).flat_map(|a| (0..a).map(move |b| (a, b))) {
            let wave = |i: usize, j: usize| (1.3 * (i + 7 * j + 11 * a + 5 * b) as f64).sin();
            let root = Matrix6::from_fn(wave);
            let information = root * root.transpose() * 1e22;
            for (i, j, sign) in [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)] {
                let mut to = matrix.fixed_view_mut::<6, 6>(6 * i, 6 * j);
                to += information * sign;
            }
        }
        let right = DVector::zeros(6 * views);
        let system = System { matrix, right, square: 0.0 };
        let before = Before {
            priors: &vec![PosePrior { rotation: 0.05, translation: 0.2 }; views],
            moved: &vec![Motion::zeros(); views],
            drift: &Drift::of(views),
            pivots: &Pivots::of_arms(&[]),
            cameras: &Cameras::of(&[], 1.0),
        };
        let solution = system.solve(1.0, &before).expect("a solution");
        assert!(solution.unknowns.amax() == 0.0);
    }
}
