//! How much the errors of neighbouring poses are alike.
//!
//! **Problem.** The poses of scanners on tripods err one by one. The pose of a camera that is
//! carried drifts: successive views err nearly alike, and distant views do not. A prior of
//! independent errors resists the correction of a drift, because it moves every view.
//!
//! **Idea.** The error of a view has two parts: one of its own, and a random walk along the views
//! in the order of their names. The evidence tells the share of the walk (Harville, 1977), as it
//! tells the size of the errors.
//!
//! **Departure.** The walk is taken about its mean, and the motion that all views share is free: it
//! is taken out in the end. A prior that holds it at zero bends the scan where the walk started at
//! the first view.

use super::motion::Motion;
use crate::prior::PosePrior;
use crate::tuning::{FIRST_SHARE, LEAST_DRIFTING, LEAST_SHARE, SHARED};
use nalgebra::{DMatrix, DVector, Matrix6};

/// The correlations of the errors of all views.
#[derive(Debug, Clone)]
pub struct Drift {
    /// Share of the walk in the variance of an error.
    share: f64,
    /// Covariances of the walk. On average over the views the variance is 1.
    walk: DMatrix<f64>,
    /// 1 for each view that drifts with the others, 0 for one that errs by itself.
    together: DVector<f64>,
    /// The inverse of the correlations.
    precision: DMatrix<f64>,
}

/// Errors of poses about their pivots, as the observations tell them, in units of the prior's
/// standard deviations.
#[derive(Debug, Clone)]
pub struct Errors {
    /// A row for each view, a column for each component of its motion.
    values: DMatrix<f64>,
    /// Covariances of each two views, summed over the components.
    covariance: DMatrix<f64>,
}

/// The evidence of errors about a variance: their squares, and the number that is determined.
#[derive(Debug, Clone, Copy, Default)]
pub struct Evidence {
    pub squares: f64,
    pub known: f64,
}

impl Drift {
    /// Of views in the order of their names: none, until it is released.
    pub fn of(views: usize) -> Self {
        let steps = DMatrix::from_fn(views, views, |i, j| i.min(j) as f64);
        let means = steps.row_mean();
        let about_mean = |i, j| steps[(i, j)] - means[i] - means[j] + means.mean();
        let walk = DMatrix::from_fn(views, views, about_mean);
        let variance = (walk.trace() / views.max(1) as f64).max(f64::MIN_POSITIVE);
        let precision = DMatrix::identity(views, views);
        let together = DVector::from_element(views, 1.0);
        Self { share: 0.0, walk: walk / variance, together, precision }
    }

    /// Takes views out: their errors are independent of those of the others. They have priors of
    /// their own, so a motion that all views share would be another one for them.
    pub fn leave_out(&mut self, views: impl Iterator<Item = usize>) {
        for k in views {
            self.together[k] = 0.0;
            self.walk.row_mut(k).fill(0.0);
            self.walk.column_mut(k).fill(0.0);
        }
    }

    /// Lets the poses drift, after they have settled. The errors of a few views do not tell whether
    /// they do.
    pub fn release(&mut self) {
        if self.walk.nrows() >= LEAST_DRIFTING {
            self.set(FIRST_SHARE);
        }
    }

    /// The inverse of the correlations of all views' errors.
    pub fn precision(&self) -> &DMatrix<f64> {
        &self.precision
    }

    /// The share of the walk in the variance of an error.
    #[cfg(test)]
    pub fn share(&self) -> f64 {
        self.share
    }

    fn set(&mut self, share: f64) {
        let own = DMatrix::from_diagonal(&self.together.map(|t| 1.0 - t * share));
        let shared = &self.together * self.together.transpose() * SHARED;
        let correlations = own + &self.walk * share + shared;
        if let Some(factor) = correlations.cholesky() {
            (self.share, self.precision) = (share, factor.inverse());
        }
    }

    /// Learns the share of the walk from errors.
    pub fn learn(&mut self, errors: &Errors) {
        if self.share == 0.0 {
            return;
        }
        let alone = &self.precision * DMatrix::from_diagonal(&self.together) * (1.0 - self.share);
        let together = &self.precision * &self.walk * self.share;
        let own = (1.0 - self.share) * errors.evidence(&alone, &self.precision).factor();
        let walk = self.share * errors.evidence(&together, &self.precision).factor();
        self.set((walk / (own + walk)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE));
    }

    /// The evidence of the errors of some views about the size of all errors.
    pub fn size(&self, errors: &Errors, is_counted: impl Fn(usize) -> bool) -> Evidence {
        let of_errors = &self.precision * &errors.values;
        let rows = (0..errors.values.nrows()).filter(|row| is_counted(*row));
        rows.fold(Evidence::default(), |sum, row| {
            let unknown = self.precision.row(row).dot(&errors.covariance.row(row));
            Evidence {
                squares: sum.squares + errors.values.row(row).dot(&of_errors.row(row)),
                known: sum.known + errors.values.ncols() as f64 - unknown,
            }
        })
    }
}

impl Errors {
    /// From the motions of all views, and the [`Solution::root`](super::solve::Solution::root).
    /// `in_units` takes the motion of a view to that about its pivot, in standard deviations.
    pub fn new(
        motions: &[Motion],
        root: &DMatrix<f64>,
        in_units: impl Fn(usize) -> Matrix6<f64>,
    ) -> Self {
        let n = motions.len();
        let in_units: Vec<_> = (0..n).map(in_units).collect();
        let values: Vec<Motion> = in_units.iter().zip(motions).map(|(to, m)| to * m).collect();
        let values = DMatrix::from_fn(n, 6, |k, c| values[k][c]);
        let roots = in_units.iter().enumerate();
        let roots = roots.map(|(k, to)| root.fixed_columns::<6>(6 * k) * to.transpose());
        let roots: Vec<_> = roots.collect();
        let of_component = |c: usize| {
            let roots = DMatrix::from_fn(root.nrows(), n, |row, k| roots[k][(row, c)]);
            roots.transpose() * roots
        };
        let covariance = (0..6).map(of_component).fold(DMatrix::zeros(n, n), |sum, of| sum + of);
        Self { values, covariance }
    }

    /// The evidence of the errors about one part of their correlations; `shape` is the precision
    /// times that part.
    fn evidence(&self, shape: &DMatrix<f64>, precision: &DMatrix<f64>) -> Evidence {
        let part = shape * precision;
        let all = self.values.ncols() as f64 * shape.trace();
        Evidence {
            squares: self.values.dot(&(&part * &self.values)),
            known: all - part.dot(&self.covariance),
        }
    }
}

impl Evidence {
    /// How many times as large as assumed the variance is.
    pub fn factor(&self) -> f64 {
        // Half a component at least, so that a variance that explains nothing shrinks step by step.
        (self.squares / self.known.max(0.5)).clamp(1e-6, 1e6)
    }
}

/// How far poses are wrong, from how far they moved (MacKay, 1992: the evidence for a prior).
///
/// A direction that the observations determine well shows the error of its pose. One that they do
/// not determine stays at 0 and shows nothing. The ratio of rotation to translation is that of the
/// pivots' lever and is not learned: along a tunnel no observation limits the translation, but the
/// rotations show that the poses are exact.
pub fn estimated_prior(prior: &PosePrior, evidence: &Evidence) -> PosePrior {
    let factor = evidence.factor().sqrt();
    PosePrior { rotation: factor * prior.rotation, translation: factor * prior.translation }
}
