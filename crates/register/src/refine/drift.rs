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
//! **Steps.** The covariances of a walk about its mean are the inverse of the Laplacian of a path.
//! Its eigenvectors are cosines (Strang, The discrete cosine transform, 1999), and those of the
//! views' own errors, too. So both parts are sums over waves along the views. The share is learned
//! until it settles, before the poses change. With one update for each change of the poses it does
//! not settle, and a wrong scale is not found in a simulated kitchen (`SHARE_ROUNDS`).
//!
//! **Departure.** The walk is taken about its mean, and the motion that all views share is free: it
//! is taken out in the end. A prior that holds it at zero bends the scan where the walk started at
//! the first view.

use super::motion::Motion;
use crate::prior::PosePrior;
use crate::tuning::{FIRST_SHARE, LEAST_DRIFTING, LEAST_SHARE, SHARE_ROUNDS, SHARED};
use nalgebra::{DMatrix, DVector, Matrix6};
use std::f64::consts::PI;

/// The correlations of the errors of all views.
#[derive(Debug, Clone)]
pub struct Drift {
    /// Share of the walk in the variance of an error.
    share: f64,
    /// The waves along the views that drift: a column each, from the mean of all views to the
    /// shortest wave. A row is 0 for a view that errs by itself.
    waves: DMatrix<f64>,
    /// The variance of the walk in each wave. On average over the views the variance is 1.
    walk: DVector<f64>,
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

/// Errors of poses, a row for each wave along the views.
struct InWaves {
    /// Their squares, summed over the components.
    squares: DVector<f64>,
    /// Their variances, summed over the components.
    unknown: DVector<f64>,
    /// The number of components.
    components: f64,
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
        let waves = DMatrix::zeros(views, 0);
        let precision = DMatrix::identity(views, views);
        let mut drift = Self { share: 0.0, waves, walk: DVector::zeros(0), precision };
        drift.make_waves(&(0..views).collect::<Vec<_>>());
        drift
    }

    /// Takes views out: their errors are independent of those of the others. They have priors of
    /// their own, so a motion that all views share would be another one for them. The views before
    /// and after one that is taken out count as neighbours.
    pub fn leave_out(&mut self, views: &[usize]) {
        let drifts = |k: &usize| self.waves.row(*k).amax() > 0.0 && !views.contains(k);
        self.make_waves(&(0..self.waves.nrows()).filter(drifts).collect::<Vec<_>>());
        if self.share > 0.0 {
            self.set(self.share);
        }
    }

    /// The waves of some views that follow each other.
    fn make_waves(&mut self, views: &[usize]) {
        let count = views.len() as f64;
        self.waves = DMatrix::zeros(self.waves.nrows(), views.len());
        self.walk = DVector::zeros(views.len());
        for wave in 0..views.len() {
            let half_turns = wave as f64 / count;
            let size = (if wave == 0 { 1.0 } else { 2.0 } / count).sqrt();
            for (place, view) in views.iter().enumerate() {
                let turned = PI * half_turns * (place as f64 + 0.5);
                self.waves[(*view, wave)] = size * turned.cos();
            }
            if wave > 0 {
                self.walk[wave] = (0.5 * PI * half_turns).sin().powi(-2);
            }
        }
        let variance = self.walk.sum() / count.max(1.0);
        self.walk /= variance.max(f64::MIN_POSITIVE);
    }

    /// Lets the poses drift, after they have settled. The errors of a few views do not tell whether
    /// they do.
    pub fn release(&mut self) {
        if self.walk.len() >= LEAST_DRIFTING {
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

    /// The variance of the errors in each wave: of the views' own part, and of the walk.
    fn variances(&self, share: f64) -> DVector<f64> {
        let mut variances = self.walk.map(|of_walk| 1.0 - share + share * of_walk);
        if let Some(of_all) = variances.get_mut(0) {
            *of_all += SHARED * self.walk.len() as f64;
        }
        variances
    }

    fn set(&mut self, share: f64) {
        self.share = share;
        let precision = self.variances(share).map(|v| 1.0 / v - 1.0);
        let (views, waves) = (self.waves.nrows(), &self.waves);
        self.precision = DMatrix::identity(views, views)
            + waves * DMatrix::from_diagonal(&precision) * waves.transpose();
    }

    /// Learns the share of the walk from errors.
    pub fn learn(&mut self, errors: &Errors) {
        if self.share == 0.0 {
            return;
        }
        let waves = errors.in_waves(&self.waves);
        let mut share = self.share;
        for _ in 0..SHARE_ROUNDS {
            let variances = self.variances(share);
            let own = variances.map(|_| 1.0 - share);
            let own = (1.0 - share) * waves.factor(&own, &variances);
            let walk = share * waves.factor(&(&self.walk * share), &variances);
            share = (walk / (own + walk)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE);
        }
        self.set(share);
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

    /// The same errors as sums over waves along the views.
    fn in_waves(&self, waves: &DMatrix<f64>) -> InWaves {
        let values = waves.tr_mul(&self.values);
        InWaves {
            squares: DVector::from_iterator(
                values.nrows(),
                values.row_iter().map(|row| row.norm_squared()),
            ),
            unknown: (waves.tr_mul(&self.covariance) * waves).diagonal(),
            components: self.values.ncols() as f64,
        }
    }
}

impl InWaves {
    /// How many times as large as assumed one part of the variances is.
    fn factor(&self, part: &DVector<f64>, variances: &DVector<f64>) -> f64 {
        let shares = part.component_div(variances);
        let weights = shares.component_div(variances);
        let known = self.components * shares.sum() - weights.dot(&self.unknown);
        Evidence { squares: weights.dot(&self.squares), known }.factor()
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
