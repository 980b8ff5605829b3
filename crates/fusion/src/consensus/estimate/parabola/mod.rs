//! A robust parabola in windows that grow.
//!
//! **Problem.** The final place of a node needs the same fit in up to six nested windows, and the
//! fit's standard deviation, with errors that neighbouring samples share.
//!
//! **Idea.** A least-squares fit follows from sums over samples, and so does its error, a quadratic
//! form in the coefficients. A wider window adds samples on both sides to the same sums, so six
//! windows cost as much as the widest alone.
//!
//! **Steps.**
//! 1. Samples in order along the curve; those in the window add to the sums.
//! 2. The parabola of the sums.
//! 3. The third and fourth order of an arc of that bend and slope are subtracted from the samples,
//!    again by sums. The parabola of the rest is added to the arc.
//! 4. If no residual exceeds half the threshold, that is the fit. Otherwise it is repeated with
//!    weights that fall from 1 at half the threshold to 0 at all of it. They begin to fall with no
//!    step and no bend, so a sample on its way out changes the fit gradually.
//!
//! **Shared errors.** The correlation of two samples is the product of the correlations of
//! neighbours between them (an exponential law). So the error that all samples of a window share
//! with its outermost one is a single number on each side, which the next sample takes over.

use super::super::options::Steps;
use super::super::tuning::parabola::*;
use super::fit::{Fit, shared};

/// One cluster in a local frame along (x) and across (y) a curve.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sample {
    pub x: f64,
    pub y: f64,
    pub weight: f64,
    /// Standard deviation of y.
    pub sigma: f64,
    /// Variance along the curve of the places of which it is the mean; 0 for a single place. The
    /// mean of places on a bend lies inside the bend, by this variance times the bend.
    pub along_variance: f64,
    /// Length along the curve over which samples share their errors; 0 if each has its own.
    pub correlation: f64,
}

impl Sample {
    /// Mean of x² over the places.
    fn square(&self) -> f64 {
        self.x * self.x + self.along_variance
    }
}

/// Which samples a fit takes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Largest distance along the curve.
    pub reach: f64,
    /// Largest distance across it.
    pub across: f64,
    /// Samples farther than this from the fit do not count.
    pub threshold: f64,
}

/// Samples along a curve, and the sums over those of a window that grows.
#[derive(Debug)]
pub(super) struct Windows {
    steps: Steps,
    /// Sorted by x.
    samples: Vec<Sample>,
    /// First in the window, and first beyond it.
    from: usize,
    to: usize,
    sums: Sums,
    /// Largest distance across in the window.
    farthest: f64,
    /// The samples of a window that is narrower across.
    inside: Vec<Sample>,
}

impl Windows {
    pub fn new(steps: Steps) -> Self {
        let (samples, inside) = (Vec::new(), Vec::new());
        Self { steps, samples, from: 0, to: 0, sums: Sums::default(), farthest: 0.0, inside }
    }

    /// Takes samples sorted by x. Lengths are summed in `unit`, the half-width of the narrowest
    /// window.
    pub fn begin(&mut self, samples: impl Iterator<Item = Sample>, unit: f64) {
        self.samples.clear();
        self.samples.extend(samples);
        self.from = self.samples.partition_point(|s| s.x < 0.0);
        self.to = self.from;
        self.sums = Sums::new(unit);
        self.farthest = 0.0;
    }

    /// The parabola through the samples within the limits, whose reach never shrinks.
    ///
    /// `None` unless samples lie on both sides and determine it.
    pub fn fit(&mut self, limits: &Limits) -> Option<Fit> {
        let Limits { reach, across, .. } = *limits;
        self.grow(reach);
        let along = self.samples.get(self.from..self.to)?;
        if self.farthest <= across {
            return self.fit_of(along, &self.sums, self.farthest, limits);
        }
        self.inside.clear();
        self.inside.extend(along.iter().filter(|s| s.y.abs() <= across));
        let sums = Sums::of(self.inside.iter().map(|s| (s, s.weight)), self.sums.unit);
        self.fit_of(&self.inside, &sums, across, limits)
    }

    /// The parabola of samples with these sums, none of them farther across than `farthest`.
    fn fit_of(
        &self,
        samples: &[Sample],
        sums: &Sums,
        farthest: f64,
        limits: &Limits,
    ) -> Option<Fit> {
        let Limits { reach, threshold, .. } = *limits;
        if !lies_on_both_sides(samples, reach) {
            return None;
        }
        let unweighted = sums.solve(reach, self.steps.arcs)?;
        let most = FULL_TRUST * threshold;
        // Usually this bound shows that no sample is so far off.
        let deepest = unweighted.deepest(reach);
        if !self.steps.robust_fit
            || farthest + unweighted.place.abs() + deepest <= most
            || samples.iter().all(|s| residual(&unweighted, s).abs() <= most)
        {
            return Some(unweighted);
        }
        let trusted = |s: &Sample| s.weight * trust(residual(&unweighted, s) / threshold);
        let weighted = samples.iter().map(|s| (s, trusted(s)));
        Sums::of(weighted, sums.unit).solve(reach, self.steps.arcs)
    }

    fn grow(&mut self, reach: f64) {
        while let Some(s) = self.samples.get(self.to).filter(|s| s.x <= reach) {
            self.sums.add_ahead(s, s.weight);
            self.farthest = self.farthest.max(s.y.abs());
            self.to += 1;
        }
        while let Some(before) = self.from.checked_sub(1) {
            let s = &self.samples[before];
            if s.x < -reach {
                break;
            }
            self.sums.add_behind(s, s.weight);
            self.farthest = self.farthest.max(s.y.abs());
            self.from = before;
        }
    }
}

/// The terms of an arc beyond its parabola.
#[derive(Debug, Clone, Copy)]
struct HigherOrders {
    cubic: f64,
    quartic: f64,
}

/// Third and fourth order of an arc of this slope and bend, as far as the bend is known.
fn beyond_parabola(fit: &Fit, reach: f64) -> HigherOrders {
    let most = 0.5 * LARGEST_ARC / reach;
    let bend = fit.bend.clamp(-most, most);
    let (signal, noise) = (bend * bend, fit.bend_sigma * fit.bend_sigma);
    let bend = if noise > 0.0 { bend * signal / (signal + noise) } else { bend };
    HigherOrders { cubic: 2.0 * bend * bend * fit.slope, quartic: bend.powi(3) }
}

/// Distance of a sample from a fit.
fn residual(fit: &Fit, s: &Sample) -> f64 {
    s.y - fit.at(s.x)
}

/// Whether two samples lie behind the middle and two ahead of it. A sample in the middle is on
/// neither side, whatever rounding does to its place.
fn lies_on_both_sides(samples: &[Sample], reach: f64) -> bool {
    match samples {
        [_, behind, ..] if samples.len() >= 4 => {
            let ahead = &samples[samples.len() - 2];
            behind.x < -MIDDLE_SHARE * reach && ahead.x > MIDDLE_SHARE * reach
        }
        _ => false,
    }
}

/// Tukey's biweight, but 1 up to [`FULL_TRUST`].
fn trust(u: f64) -> f64 {
    let u = (u.abs() - FULL_TRUST).max(0.0) / (1.0 - FULL_TRUST);
    let rest = (1.0 - u * u).max(0.0);
    rest * rest
}

/// The sums of a parabola in u = x / unit, with q for the mean of u² over a sample's places.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    unit: f64,
    per_unit: f64,
    /// Sums of weight × 1, u, q, u², uq, q², uq², q³.
    left: [f64; 8],
    /// Sums of weight × y × 1, u, q.
    right: [f64; 3],
    /// Covariances of the errors of `right`, in the order of `left`.
    errors: [f64; 6],
    /// Errors of `right` as far as the outermost sample on a side shares them.
    behind: [f64; 3],
    ahead: [f64; 3],
    /// Correlation of the outermost samples.
    through: f64,
    /// The outermost samples.
    first: Outermost,
    last: Outermost,
    /// Whether there are any samples.
    begun: bool,
}

/// An outermost sample of a window.
#[derive(Debug, Clone, Copy, Default)]
struct Outermost {
    x: f64,
    correlation: f64,
}

/// The inverse of a matrix: the rows of its cofactors, times one over its determinant.
struct Inverse {
    rows: [[f64; 3]; 3],
    factor: f64,
}

impl Sums {
    fn new(unit: f64) -> Self {
        // No sample shares an error with one at infinity.
        let first = Outermost { x: f64::INFINITY, correlation: 0.0 };
        let last = Outermost { x: f64::NEG_INFINITY, correlation: 0.0 };
        Self { unit, per_unit: 1.0 / unit, first, last, ..Self::default() }
    }

    /// Of samples sorted by x, and their weights.
    fn of<'a>(samples: impl Iterator<Item = (&'a Sample, f64)>, unit: f64) -> Self {
        let mut sums = Self::new(unit);
        samples.for_each(|(s, weight)| sums.add_ahead(s, weight));
        sums
    }

    fn add_ahead(&mut self, s: &Sample, weight: f64) {
        let (here, error) = (Outermost { x: s.x, correlation: s.correlation }, self.add(s, weight));
        let shared = shared(s.x - self.last.x, 0.5 * (s.correlation + self.last.correlation));
        self.through *= shared;
        self.ahead = add_error(&mut self.errors, self.ahead.map(|v| v * shared), error);
        if !self.begun {
            (self.first, self.behind, self.through, self.begun) = (here, error, 1.0, true);
        } else {
            for (sum, e) in self.behind.iter_mut().zip(error) {
                *sum += self.through * e;
            }
        }
        self.last = here;
    }

    fn add_behind(&mut self, s: &Sample, weight: f64) {
        self.turn();
        self.add_ahead(s, weight);
        self.turn();
    }

    /// Exchanges the two sides.
    fn turn(&mut self) {
        std::mem::swap(&mut self.first, &mut self.last);
        std::mem::swap(&mut self.behind, &mut self.ahead);
    }

    /// Adds a sample to the moments; returns its error in each moment on the right.
    fn add(&mut self, s: &Sample, w: f64) -> [f64; 3] {
        let scale = self.per_unit;
        let (u, q) = (s.x * scale, s.square() * scale * scale);
        let (wu, wq) = (w * u, w * q);
        for (sum, new) in
            self.left.iter_mut().zip([w, wu, wq, wu * u, wu * q, wq * q, wu * q * q, wq * q * q])
        {
            *sum += new;
        }
        for (sum, new) in self.right.iter_mut().zip([w, wu, wq]) {
            *sum += new * s.y;
        }
        [w * s.sigma, wu * s.sigma, wq * s.sigma]
    }

    /// The arc of the samples, with the standard deviations of its place and bend from random
    /// errors; `None` if they do not determine one in a window of this reach.
    fn solve(&self, reach: f64, arcs: bool) -> Option<Fit> {
        let inverse = self.inverse(reach)?;
        let [place, _, bend] = &inverse.rows;
        let sigma = |row: &[f64; 3]| self.variance(row).max(0.0).sqrt() * inverse.factor;
        let parabola = Fit {
            place_sigma: sigma(place),
            bend_sigma: sigma(bend) * self.per_unit * self.per_unit,
            ..self.parabola(&inverse, &self.right)
        };
        Some(if arcs { self.follow_arc(parabola, &inverse, reach) } else { parabola })
    }

    /// The matrix's inverse, if samples determine a parabola in a window of this reach.
    fn inverse(&self, reach: f64) -> Option<Inverse> {
        let [a, b, c, d, e, f, ..] = self.left;
        // Cofactors of the symmetric matrix.
        let place = [d * f - e * e, c * e - b * f, b * e - c * d];
        let slope = [place[1], a * f - c * c, b * c - a * e];
        let bend = [place[2], slope[2], a * d - b * b];
        let determinant = a * place[0] + b * place[1] + c * place[2];
        // Determined well enough in the window's own unit, in which u is at most 1.
        if determinant * (self.unit / reach).powi(6) <= 1e-9 * a * a * a || determinant.is_nan() {
            return None;
        }
        Some(Inverse { rows: [place, slope, bend], factor: 1.0 / determinant })
    }

    /// The parabola for moments on the right.
    fn parabola(&self, inverse: &Inverse, right: &[f64; 3]) -> Fit {
        let scale = self.per_unit;
        let [place, slope, bend] =
            inverse.rows.each_ref().map(|row| dot(row, right) * inverse.factor);
        Fit { place, slope: slope * scale, bend: bend * scale * scale, ..Fit::default() }
    }

    /// The arc instead of the parabola: its higher orders are subtracted from the samples. Each
    /// round leaves a quarter of the error or less.
    fn follow_arc(&self, parabola: Fit, inverse: &Inverse, reach: f64) -> Fit {
        const ROUNDS: usize = 2;
        const MATTERS: f64 = 1e-3;
        let [.., s3, s4, s5, s6] = self.left;
        let mut fit = parabola;
        // The effect of the fourth order is at most its value at the window's ends.
        let HigherOrders { cubic, quartic } = beyond_parabola(&fit, reach);
        if (cubic.abs() + quartic.abs() * reach) * reach.powi(3) <= MATTERS * fit.place_sigma {
            return parabola;
        }
        for _ in 0..ROUNDS {
            let HigherOrders { cubic, quartic } = beyond_parabola(&fit, reach);
            let (c, q) = (cubic * self.unit.powi(3), quartic * self.unit.powi(4));
            let [a, b, d] = self.right;
            let right = [a - c * s3 - q * s4, b - c * s4 - q * s5, d - c * s5 - q * s6];
            let Fit { place, slope, bend, .. } = self.parabola(inverse, &right);
            fit = Fit { place, slope, bend, cubic, quartic, ..parabola };
        }
        fit
    }

    /// Variance of a sum of the moments on the right with these factors.
    fn variance(&self, [a, b, c]: &[f64; 3]) -> f64 {
        let [one, u, q, uu, uq, qq] = self.errors;
        a * (a * one + 2.0 * (b * u + c * q)) + b * (b * uu + 2.0 * c * uq) + c * c * qq
    }
}

/// Adds an error and its covariance with a shared error; returns the sum of both errors.
fn add_error(covariances: &mut [f64; 6], shared: [f64; 3], error: [f64; 3]) -> [f64; 3] {
    let both = [shared[0] + error[0], shared[1] + error[1], shared[2] + error[2]];
    // e e' + e s' + s e' = (e + s) (e + s)' - s s'
    let (new, old) = (products(&both), products(&shared));
    for k in 0..6 {
        covariances[k] += new[k] - old[k];
    }
    both
}

/// The products of three numbers with each other, by rows from the diagonal on.
fn products([a, b, c]: &[f64; 3]) -> [f64; 6] {
    [a * a, a * b, a * c, b * b, b * c, c * c]
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests;
