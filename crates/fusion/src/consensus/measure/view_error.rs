//! The systematic errors of views: the part of the spread between views that the nodes' own errors
//! do not explain (random effects model).
//!
//! **Problem.** Pixel noise averages out along a curve. Errors of calibration, pose and blur do
//! not, since neighbouring nodes share them, and views have to be weighed by these. Scanners err
//! more where they see a surface obliquely: the laser's stripe and the pixel's patch get longer.
//! Pixel noise suggests the opposite, as an error along the ray counts less across an oblique
//! surface. Depth cameras triangulate. Whatever moves their disparity, be it noise, a matching
//! window or the lens, is an error that grows with the square of the depth. There a view's error
//! goes with its noise.
//!
//! **Idea.** Variance components by least squares. The variance across the curve is
//! `l + n σ² + o t²`, with `σ` the node's own standard deviation and `t` the tangent of the
//! incidence. Two nodes of two views beside each other lie a distance `d` apart with
//! `E d² = (1 + n) (σ₁² + σ₂²) + 2 l + o (t₁² + t₂²)`, which is linear in `l`, `n` and `o`.
//! The part `n` is sought only where views are moved onto common courses (`settle.rs`): the noise
//! of a laser scanner says little of its errors.
//!
//! **Steps.**
//! 1. Start: the whole spread is the same everywhere.
//! 2. Least squares, weighted by the last estimate: the square of a normal error has a standard
//!    deviation in proportion to its variance. Pairs more than three standard deviations apart are
//!    outliers or of different surfaces, and do not count. Parts that do not exceed their own
//!    error are left out, as are parts below 0.
//! 3. The parts that grow count as far as they exceed their own errors (shrinkage of James and
//!    Stein, 1961). Otherwise chance would give weights to views that err alike everywhere.
//!
//! **Source.** Not in the dissertation, whose averages weigh all views alike (5.5.2). Weights that
//! fall with the incidence go back to Turk and Levoy (1994); here they are measured.

use super::super::tuning::view_error::*;
use nalgebra::{Matrix3, Vector3};

/// Two nodes of different views beside each other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair {
    /// Distance across the curve.
    pub distance: f64,
    /// Sum of the variances of both by their own errors.
    pub variance: f64,
    /// Sum of the squared tangents of both incidences.
    pub squared_tangents: f64,
}

impl Pair {
    /// The factors of the parts of a [`ViewError`] in the variance of the distance.
    fn counts(&self) -> Vector3<f64> {
        Vector3::new(2.0, self.variance, self.squared_tangents)
    }
}

/// Variance of a view's systematic error across the curve, in three parts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct ViewError {
    /// The part that is the same everywhere.
    pub level: f64,
    /// The part that goes with the node's own variance, in such variances.
    pub with_noise: f64,
    /// Increase per squared tangent of the incidence.
    pub oblique: f64,
}

impl ViewError {
    /// Variance where a node has this standard deviation of its own, at an incidence of this
    /// squared tangent.
    pub fn variance(&self, sigma: f64, squared_tangent: f64) -> f64 {
        self.level + self.with_noise * sigma * sigma + self.oblique * squared_tangent
    }

    /// The error from pairs of nodes; `between_views` is the standard deviation of one view. Parts
    /// that are not `sought` are 0; they are in the order of the fields.
    pub fn of(pairs: &[Pair], between_views: f64, sought: [bool; 3]) -> Self {
        let mut error = Self { level: between_views * between_views, ..Self::default() };
        let mut trust = Vector3::zeros();
        for _ in 0..ROUNDS {
            (error, trust) = error.equations(pairs).solution(sought);
        }
        let [_, with_noise, oblique] = error.parts().component_mul(&trust).into();
        // What shrinking removed counts everywhere.
        let shrunk = Self { with_noise, oblique, ..error };
        Self { level: shrunk.equations(pairs).level(&shrunk), ..shrunk }
    }

    fn parts(&self) -> Vector3<f64> {
        Vector3::new(self.level, self.with_noise, self.oblique)
    }

    /// The normal equations for the next estimate. The square of a normal error has a standard
    /// deviation in proportion to its variance, so a pair's weight is one over the square of this.
    fn equations(&self, pairs: &[Pair]) -> Equations {
        let mut equations = Equations::default();
        for pair in pairs {
            let counts = pair.counts();
            let expected = pair.variance + self.parts().dot(&counts);
            let squared = pair.distance * pair.distance;
            if expected > 0.0 && squared <= SQUARED_CUT * expected {
                let weight = 1.0 / (expected * expected);
                let unexplained = squared / VARIANCE_LEFT_BY_CUT - pair.variance;
                equations.matrix += counts * counts.transpose() * weight;
                equations.vector += counts * (unexplained * weight);
            }
        }
        equations
    }
}

/// Normal equations of the parts of a view's error.
#[derive(Debug, Clone, Copy, Default)]
struct Equations {
    matrix: Matrix3<f64>,
    vector: Vector3<f64>,
}

impl Equations {
    /// The parts, and the share of each that exceeds its own error. Slopes that do not exceed it
    /// are left out one after the other, beginning with the one that says least. A level below 0
    /// is left out last.
    fn solution(&self, mut taken: [bool; 3]) -> (ViewError, Vector3<f64>) {
        loop {
            let (parts, variances) = self.solve(&taken);
            let says = |k: usize| parts[k] / variances[k].sqrt();
            let vague = (1..3).filter(|&k| taken[k] && (says(k).is_nan() || says(k) <= 1.0));
            let vaguest = vague.min_by(|&a, &b| says(a).total_cmp(&says(b)));
            let Some(left_out) = vaguest.or((taken[0] && parts[0] < 0.0).then_some(0)) else {
                let trust = |k: usize| if taken[k] { 1.0 - says(k).powi(-2) } else { 0.0 };
                let [level, with_noise, oblique] = parts.into();
                let error = ViewError { level, with_noise, oblique };
                return (error, Vector3::new(1.0, trust(1), trust(2)));
            };
            taken[left_out] = false;
        }
    }

    /// The parts, and the variance of each, without bounds for a part that no pair tells anything
    /// of. Those that are not taken are 0.
    fn solve(&self, taken: &[bool; 3]) -> (Vector3<f64>, Vector3<f64>) {
        let kept = Vector3::from(taken.map(|taken| f64::from(u8::from(taken))));
        let size = self.matrix.diagonal().map(|d| if d > 0.0 { d.sqrt().recip() } else { 0.0 });
        let scale = size.component_mul(&kept);
        // With ones on the diagonal, and a little more where parts cannot be told apart.
        let scaled = self.matrix.component_mul(&(scale * scale.transpose()));
        let added = scale.map(|s| if s > 0.0 { LEAST_SPREAD } else { 1.0 });
        let matrix = scaled + Matrix3::from_diagonal(&added);
        let Some(inverse) = matrix.cholesky().map(|m| m.inverse()) else {
            return (Vector3::zeros(), Vector3::repeat(f64::INFINITY));
        };
        let parts = (inverse * self.vector.component_mul(&scale)).component_mul(&scale);
        let known = inverse.diagonal().component_mul(&scale).component_mul(&scale);
        let variances = known.map(|v| if v > 0.0 { VARIANCE_OF_SQUARE * v } else { f64::INFINITY });
        (parts, variances)
    }

    /// The level that fits the other parts of an error, at least 0.
    fn level(&self, error: &ViewError) -> f64 {
        let others = Vector3::new(0.0, error.with_noise, error.oblique);
        let level = (self.vector[0] - (self.matrix * others)[0]) / self.matrix[(0, 0)];
        if level > 0.0 { level } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [bool; 3] = [true; 3];

    /// Distances drawn as the quantiles of a normal error, in an order unrelated to incidences and
    /// noises. The variances of the errors of views follow from the squared tangent and from the
    /// variance by noise.
    fn pairs(noise: f64, variance_at: impl Fn(f64, f64) -> f64) -> Vec<Pair> {
        let count = 1601_u32;
        // The inverse of the normal distribution's error function, by bisection on its series.
        let quantile = |p: f64| {
            let cdf = |z: f64| {
                let terms = (0..60).scan(z, |term, k| {
                    let now = *term;
                    *term *= z * z / f64::from(2 * k + 3);
                    Some(now)
                });
                0.5 + terms.sum::<f64>() * (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt()
            };
            let (mut low, mut high) = (-5.0, 5.0);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if cdf(middle) < p { low = middle } else { high = middle }
            }
            low
        };
        let pair = |k: u32| {
            let error = quantile((f64::from(k * 467 % count) + 0.5) / f64::from(count));
            let t = |k: u32| f64::from(k % 31) / 10.0;
            // Depths from 1 to 3, with noise that grows with their squares.
            let own = |k: u32| noise * noise * (1.0 + f64::from(k % 23) / 11.0).powi(4);
            let (a, b) = ((t(k * 17), own(k * 7)), (t(k * 29 + 5), own(k * 13 + 3)));
            let of = |(t, own): (f64, f64)| own + variance_at(t * t, own);
            Pair {
                distance: (error * (of(a) + of(b)).sqrt()).abs(),
                variance: a.1 + b.1,
                squared_tangents: a.0 * a.0 + b.0 * b.0,
            }
        };
        (0..count).map(pair).collect()
    }

    #[test]
    fn each_part_is_told_from_the_others() {
        let parts = [
            (0.04, 0.0, 0.0),
            (0.04, 0.0, 0.04),
            (0.0, 0.0, 0.03),
            (0.04, 0.0, 0.01),
            (0.04, 40.0, 0.0),
            (0.0, 30.0, 0.0),
            (0.02, 50.0, 0.03),
        ];
        for (level, with_noise, oblique) in parts {
            let pairs = pairs(0.01, |t, own| level + with_noise * own + oblique * t);
            let found = ViewError::of(&pairs, 0.3, ALL);
            let text = format!("{level} {with_noise} {oblique}: {found:?}");
            assert!((found.level - level).abs() < 0.012, "{text}");
            assert!((found.with_noise - with_noise).abs() < 0.2 * with_noise + 0.8, "{text}");
            assert!((found.oblique - oblique).abs() < 0.2 * oblique + 0.002, "{text}");
        }
    }

    #[test]
    fn parts_that_are_not_sought_are_not_found() {
        let pairs = pairs(0.03, |t, own| 0.02 + 40.0 * own + 0.03 * t);
        for sought in [[true, false, false], [true, true, false], [true, false, true]] {
            let found = ViewError::of(&pairs, 0.3, sought);
            assert_eq!([found.with_noise > 0.0, found.oblique > 0.0], sought[1..], "{found:?}");
        }
    }

    #[test]
    fn own_errors_explain_what_they_can() {
        let found = ViewError::of(&pairs(0.03, |_, _| 0.0), 0.1, ALL);
        assert!(found.level < 0.0005 && found.oblique < 0.0004, "{found:?}");
        assert!(found.with_noise < 0.2, "{found:?}");
    }

    #[test]
    fn surfaces_beside_each_other_do_not_count() {
        let mut pairs = pairs(0.03, |t, _| 0.01 + 0.01 * t);
        let clean = ViewError::of(&pairs, 0.2, ALL);
        pairs.iter_mut().step_by(20).for_each(|p| p.distance = 3.0);
        let found = ViewError::of(&pairs, 0.2, ALL);
        let variance = |error: &ViewError| error.level + error.oblique;
        assert!(variance(&found) < 1.3 * variance(&clean), "{clean:?} {found:?}");
    }

    #[test]
    fn pairs_that_are_all_alike_say_nothing_about_others() {
        let mut pairs = pairs(0.0003, |_, _| 0.02);
        pairs.iter_mut().for_each(|p| (p.squared_tangents, p.variance) = (2.0, 1e-6));
        let found = ViewError::of(&pairs, 0.2, ALL);
        assert_eq!([found.with_noise, found.oblique], [0.0; 2], "{found:?}");
        assert!((found.level - 0.02).abs() < 0.004, "{found:?}");
        assert_eq!(ViewError::of(&[], 0.2, ALL), ViewError::default(), "and no pair nothing");
    }
}
