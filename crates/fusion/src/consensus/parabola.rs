//! A robust parabola in windows that grow.
//!
//! **Problem.** The final place of a node asks for the same fit in up to six nested windows, with the
//! standard deviation of the fit from errors that neighbouring samples share.
//!
//! **Idea.** All of a least-squares fit follows from sums over samples, and so does its error: it is a
//! quadratic form in the coefficients. A wider window adds samples on both sides and to the sums, so
//! that six windows cost as much as the widest alone.
//!
//! **Steps.**
//! 1. Samples in order along the curve; those in the window add to the sums.
//! 2. The parabola of the sums.
//! 3. What an arc of that bend and slope has of third and fourth order is taken off the samples, by sums
//!    again, and the parabola of the rest added to it.
//! 4. If no residual exceeds half the threshold, that is the fit. Else once more, with weights that fall from 1
//!    at half the threshold to 0 at all of it. They leave 1 with no step and no bend, so that a sample on its
//!    way out changes the fit gradually.
//!
//! **Shared errors.** The correlation of two samples is the product of those of the neighbours between
//! them (an exponential law). So what all samples of a window share with its outermost one is a single
//! number on each side, which the next sample takes over.

use super::fit::{Fit, shared};

/// One cluster in a local frame along (x) and across (y) a curve.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sample {
    pub x: f64,
    pub y: f64,
    pub weight: f64,
    /// Standard deviation of y.
    pub sigma: f64,
    /// Variance along the curve of the places it is the mean of; 0 for a single place. The mean of
    /// places on a bend lies inside the bend, by this much times the bend.
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

/// Half-width of the middle of a window, as a share of its reach.
const MIDDLE: f64 = 1e-3;

/// Share of the threshold up to which samples have their whole weight.
const FLAT: f64 = 0.5;

/// Curvature times reach, in radians, from which on a fit follows no more of an arc.
const LARGEST_TURN: f64 = 0.9;

/// Samples along a curve, and the sums over those of a window that grows.
#[derive(Debug, Default)]
pub(super) struct Windows {
    /// Sorted by x.
    samples: Vec<Sample>,
    /// First in the window, and first beyond it.
    from: usize,
    to: usize,
    sums: Sums,
    /// Largest distance across in the window.
    farthest: f64,
    pub arcs: bool,
    pub robust: bool,
    /// Those of a window that is narrower across.
    inside: Vec<Sample>,
}

impl Windows {
    /// Takes samples sorted by x. Lengths are summed in the unit given, that of the narrowest window.
    pub fn begin(&mut self, samples: impl Iterator<Item = Sample>, unit: f64) {
        self.samples.clear();
        self.samples.extend(samples);
        self.from = self.samples.partition_point(|s| s.x < 0.0);
        self.to = self.from;
        self.sums = Sums::new(unit);
        self.farthest = 0.0;
    }

    /// The parabola through the samples with `|x| <= reach` and `|y| <= across`; those farther from it
    /// than `threshold` do not count. The reach never shrinks.
    ///
    /// `None` unless samples lie on both sides and determine it.
    pub fn fit(&mut self, reach: f64, across: f64, threshold: f64) -> Option<Fit> {
        self.grow(reach);
        let along = self.samples.get(self.from..self.to)?;
        if self.farthest <= across {
            return fit(
                along,
                (&self.sums, self.farthest),
                (reach, self.arcs, self.robust),
                threshold,
            );
        }
        self.inside.clear();
        self.inside.extend(along.iter().filter(|s| s.y.abs() <= across));
        let weighted = self.inside.iter().map(|s| (s, s.weight));
        fit(
            &self.inside,
            (&Sums::of(weighted, self.sums.unit), across),
            (reach, self.arcs, self.robust),
            threshold,
        )
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

/// The parabola of samples with these sums, none of them farther across than given.
fn fit(
    samples: &[Sample],
    (sums, farthest): (&Sums, f64),
    (reach, arcs, robust): (f64, bool, bool),
    threshold: f64,
) -> Option<Fit> {
    if !lies_on_both_sides(samples, reach) {
        return None;
    }
    let plain = sums.solve(reach, arcs)?;
    if !robust {
        return Some(plain);
    }
    let most = FLAT * threshold;
    // As a rule no sample can be so far off, whichever it is.
    let deepest = plain.deepest(reach);
    if farthest + plain.place.abs() + deepest <= most
        || samples.iter().all(|s| residual(&plain, s).abs() <= most)
    {
        return Some(plain);
    }
    let weighted = samples.iter().map(|s| (s, s.weight * trust(residual(&plain, s) / threshold)));
    Sums::of(weighted, sums.unit).solve(reach, arcs)
}

/// Third and fourth order of an arc of this slope and bend, as far as the bend is known.
fn beyond_parabola(fit: &Fit, reach: f64) -> (f64, f64) {
    let most = 0.5 * LARGEST_TURN / reach;
    let bend = fit.bend.clamp(-most, most);
    let (signal, noise) = (bend * bend, fit.bend_sigma * fit.bend_sigma);
    let bend = if noise > 0.0 { bend * signal / (signal + noise) } else { bend };
    (2.0 * bend * bend * fit.slope, bend.powi(3))
}

/// Distance of a sample from a fit.
fn residual(fit: &Fit, s: &Sample) -> f64 {
    s.y - fit.at(s.x)
}

/// Whether two samples lie behind the middle and two ahead of it: one there is on neither side,
/// whatever rounding makes of its place.
fn lies_on_both_sides(samples: &[Sample], reach: f64) -> bool {
    match samples {
        [_, behind, ..] if samples.len() >= 4 => {
            let ahead = &samples[samples.len() - 2];
            behind.x < -MIDDLE * reach && ahead.x > MIDDLE * reach
        }
        _ => false,
    }
}

/// Tukey's biweight, but 1 up to [`FLAT`].
fn trust(u: f64) -> f64 {
    let u = (u.abs() - FLAT).max(0.0) / (1.0 - FLAT);
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
    /// Places and correlation lengths of the outermost samples.
    first: (f64, f64),
    last: (f64, f64),
    /// Whether there are any: places so near to each other that their order is not kept do not tell.
    begun: bool,
}

/// Rows of a matrix's cofactors, and one over its determinant.
type Inverse = ([[f64; 3]; 3], f64);

impl Sums {
    fn new(unit: f64) -> Self {
        // No sample shares an error with one at infinity.
        let (first, last) = ((f64::INFINITY, 0.0), (f64::NEG_INFINITY, 0.0));
        Self { unit, per_unit: 1.0 / unit, first, last, ..Self::default() }
    }

    /// Of samples sorted by x, and their weights.
    fn of<'a>(samples: impl Iterator<Item = (&'a Sample, f64)>, unit: f64) -> Self {
        let mut sums = Self::new(unit);
        samples.for_each(|(s, weight)| sums.add_ahead(s, weight));
        sums
    }

    fn add_ahead(&mut self, s: &Sample, weight: f64) {
        let (here, error) = ((s.x, s.correlation), self.add(s, weight));
        let shared = shared(s.x - self.last.0, 0.5 * (s.correlation + self.last.1));
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
        let (here, error) = ((s.x, s.correlation), self.add(s, weight));
        let shared = shared(self.first.0 - s.x, 0.5 * (s.correlation + self.first.1));
        self.through *= shared;
        self.behind = add_error(&mut self.errors, self.behind.map(|v| v * shared), error);
        if !self.begun {
            (self.last, self.ahead, self.through, self.begun) = (here, error, 1.0, true);
        } else {
            for (sum, e) in self.ahead.iter_mut().zip(error) {
                *sum += self.through * e;
            }
        }
        self.first = here;
    }

    /// Adds a sample to the moments; returns its error in each of those on the right.
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

    /// The arc of the samples, with the standard deviations of its place and bend from random errors, if they
    /// determine one in a window of this reach.
    fn solve(&self, reach: f64, arcs: bool) -> Option<Fit> {
        let inverse = self.inverse(reach)?;
        let ([place, _, bend], of) = &inverse;
        let sigma = |row: &[f64; 3]| self.variance(row).max(0.0).sqrt() * of;
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
        // Well determined as seen in the window's own unit, in which u is up to 1.
        if determinant * (self.unit / reach).powi(6) <= 1e-9 * a * a * a || determinant.is_nan() {
            return None;
        }
        Some(([place, slope, bend], 1.0 / determinant))
    }

    /// The parabola for moments on the right.
    fn parabola(&self, (rows, of): &Inverse, right: &[f64; 3]) -> Fit {
        let scale = self.per_unit;
        let [place, slope, bend] = rows.each_ref().map(|row| dot(row, right) * of);
        Fit { place, slope: slope * scale, bend: bend * scale * scale, ..Fit::default() }
    }

    /// The arc instead of the parabola: what it has of higher order is taken off the samples. Each round
    /// leaves a quarter of the error or less.
    fn follow_arc(&self, parabola: Fit, inverse: &Inverse, reach: f64) -> Fit {
        const ROUNDS: usize = 2;
        const MATTERS: f64 = 1e-3;
        let [.., s3, s4, s5, s6] = self.left;
        let mut fit = parabola;
        // No window sees more of the fourth order than its value at both ends.
        let (cubic, quartic) = beyond_parabola(&fit, reach);
        if (cubic.abs() + quartic.abs() * reach) * reach.powi(3) <= MATTERS * fit.place_sigma {
            return parabola;
        }
        for _ in 0..ROUNDS {
            let (cubic, quartic) = beyond_parabola(&fit, reach);
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

/// Adds to covariances an error and what it has in common with others; returns the sum of both.
fn add_error(covariances: &mut [f64; 6], common: [f64; 3], error: [f64; 3]) -> [f64; 3] {
    let both = [common[0] + error[0], common[1] + error[1], common[2] + error[2]];
    // e e' + e c' + c e' = (e + c) (e + c)' - c c'
    let (new, old) = (products(&both), products(&common));
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
