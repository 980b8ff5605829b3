//! Robust local fits in a curve's own direction: a line for a first place, a parabola for the last.

/// One observation in a local frame along (x) and across (y) a curve.
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
    /// Place along of the sample that comes before it, and what it shares with that one's error:
    /// known once for all windows with both.
    pub before: f64,
    pub shared: f64,
}

impl Sample {
    /// Correlation of its error with that of a sample at `x`, which comes before it.
    fn shared_from(&self, x: f64) -> f64 {
        if x == self.before { self.shared } else { shared(self.x - x, self.correlation) }
    }

    /// Mean of x² over the places.
    fn square(&self) -> f64 {
        self.x * self.x + self.along_variance
    }
}

/// A curve near x = 0: `y = place + slope x + bend x²`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Fit {
    pub place: f64,
    pub slope: f64,
    pub bend: f64,
    /// Standard deviation of `place` from the samples' random errors.
    pub place_sigma: f64,
    /// Standard deviation of `bend`.
    pub bend_sigma: f64,
}

impl Fit {
    fn residual(&self, s: &Sample) -> f64 {
        s.y - (self.place + self.slope * s.x + self.bend * s.square())
    }
}

/// A sample of a line: its place along and across, and its weight.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineSample {
    pub x: f64,
    pub y: f64,
    pub weight: f64,
    /// Share of the weight by its distance along the curve.
    near: f64,
}

impl LineSample {
    /// A sample with `|x| <= reach`, with a weight that falls to the reach.
    pub fn new((x, y): (f64, f64), weight: f64, reach: f64) -> Self {
        Self { x, y, weight, near: kernel(x / reach) }
    }
}

/// A robust weighted line. Samples farther from it than `across` do not count. `None` without samples.
pub(super) fn line(samples: &[LineSample], across: f64) -> Option<Fit> {
    let rough = weighted_line(samples, |s| s.near)?;
    let residual = |s: &LineSample| s.y - (rough.place + rough.slope * s.x);
    let weight = |s: &LineSample| s.near * biweight(residual(s) / across);
    Some(weighted_line(samples, weight).unwrap_or(rough))
}

fn weighted_line(samples: &[LineSample], weight: impl Fn(&LineSample) -> f64) -> Option<Fit> {
    let (mut w, mut wx, mut wy, mut wxx, mut wxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for s in samples {
        let k = s.weight * weight(s);
        let kx = k * s.x;
        (w, wx, wy) = (w + k, wx + kx, wy + k * s.y);
        (wxx, wxy) = (wxx + kx * s.x, wxy + kx * s.y);
    }
    if w <= 0.0 {
        return None;
    }
    let variance = wxx - wx * wx / w;
    // All samples at one x have a place but no slope.
    let slope = if variance > 1e-12 * wxx { (wxy - wx * wy / w) / variance } else { 0.0 };
    Some(Fit { place: (wy - slope * wx) / w, slope, ..Fit::default() })
}

/// Correlation of the errors of two nodes of one view, `apart` along the curve.
///
/// It falls exponentially, and its integral is the correlation length: the mean over a long stretch
/// has the variance of one independent error per correlation length.
pub(super) fn shared(apart: f64, correlation: f64) -> f64 {
    if correlation > 0.0 { (-2.0 * apart.abs() / correlation).exp() } else { 0.0 }
}

/// Orders samples along the curve, and notes for each what it shares with the one before.
pub(super) fn in_order(samples: &mut [Sample]) {
    samples.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut before = f64::NEG_INFINITY;
    for s in samples {
        (s.before, s.shared) = (before, shared(s.x - before, s.correlation));
        before = s.x;
    }
}

/// A robust weighted parabola through samples with `|x| <= reach`, sorted by [`in_order`].
///
/// `None` unless samples lie on both sides and determine it. What `weights` held is lost.
pub(super) fn parabola(
    samples: &[Sample],
    reach: f64,
    across: f64,
    weights: &mut Vec<f64>,
) -> Option<Fit> {
    let (behind, ahead) = sides(samples, reach);
    if behind < 2 || ahead < 2 {
        return None;
    }
    let rough = Moments::of(samples.iter().map(|s| (s, s.weight)), reach).solve(reach)?;
    weights.clear();
    weights.extend(samples.iter().map(|s| s.weight * biweight(rough.residual(s) / across)));
    let weighted = || samples.iter().zip(weights.iter().copied());
    let moments = Moments::of(weighted(), reach);
    let fit = moments.solve(reach)?;
    let [place, bend] = moments.sigmas(weighted(), reach)?;
    Some(Fit { place_sigma: place, bend_sigma: bend / (reach * reach), ..fit })
}

/// Half-width of the middle of a window, as a share of its reach.
const MIDDLE: f64 = 1e-3;

/// Samples behind and ahead of the middle: one there is on neither side, whatever rounding makes of
/// its place.
fn sides(samples: &[Sample], reach: f64) -> (usize, usize) {
    let behind = samples.partition_point(|s| s.x < -MIDDLE * reach);
    let ahead = samples.len() - samples.partition_point(|s| s.x <= MIDDLE * reach);
    (behind, ahead)
}

/// The normal equations of a parabola in x / reach, which keeps them well scaled.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    /// Sums of weight × 1, u, q, u², uq, q², where q is the mean of u² over the sample's places.
    left: [f64; 6],
    /// Sums of weight × y × 1, u, q.
    right: [f64; 3],
}

impl Moments {
    /// Of samples and their weights.
    fn of<'a>(samples: impl Iterator<Item = (&'a Sample, f64)>, reach: f64) -> Self {
        let scale = 1.0 / reach;
        let mut m = Self::default();
        for (s, w) in samples {
            let (u, q) = (s.x * scale, s.square() * scale * scale);
            let (wu, wq, wy) = (w * u, w * q, w * s.y);
            let (left, right) = (&mut m.left, &mut m.right);
            left[0] += w;
            left[1] += wu;
            left[2] += wq;
            left[3] += wu * u;
            left[4] += wu * q;
            left[5] += wq * q;
            right[0] += wy;
            right[1] += wy * u;
            right[2] += wy * q;
        }
        m
    }

    /// The cofactors of the symmetric matrix, and its determinant if the samples determine a parabola.
    fn cofactors(&self) -> Option<([f64; 6], f64)> {
        let [a, b, c, d, e, f] = self.left;
        let cofactors = [
            d * f - e * e,
            c * e - b * f,
            b * e - c * d,
            a * f - c * c,
            b * c - a * e,
            a * d - b * b,
        ];
        let determinant = a * cofactors[0] + b * cofactors[1] + c * cofactors[2];
        (determinant > 1e-9 * a * a * a).then_some((cofactors, determinant))
    }

    fn solve(&self, reach: f64) -> Option<Fit> {
        let ([a, b, c, d, e, f], determinant) = self.cofactors()?;
        let [r, s, t] = self.right.map(|v| v / determinant);
        Some(Fit {
            place: a * r + b * s + c * t,
            slope: (b * r + d * s + e * t) / reach,
            bend: (c * r + e * s + f * t) / (reach * reach),
            ..Fit::default()
        })
    }

    /// Standard deviations of place and bend (of u²) from the samples' random errors, of which
    /// neighbours share a part.
    ///
    /// Both are sums of sample errors with known coefficients. With an exponential correlation, what
    /// a sample shares with all before it is carried along in one number.
    fn sigmas<'a>(
        &self,
        samples: impl Iterator<Item = (&'a Sample, f64)>,
        reach: f64,
    ) -> Option<[f64; 2]> {
        let ([a, b, c, _, e, f], determinant) = self.cofactors()?;
        let scale = 1.0 / reach;
        let (mut variance, mut carried, mut last) = ([0.0; 2], [0.0; 2], 0.0);
        for (s, weight) in samples {
            let error = weight * s.sigma / determinant;
            let (u, q) = (s.x * scale, s.square() * scale * scale);
            let errors = [error * (a + b * u + c * q), error * (c + e * u + f * q)];
            let kept = s.shared_from(last);
            for k in 0..2 {
                carried[k] *= kept;
                variance[k] += errors[k] * (errors[k] + 2.0 * carried[k]);
                carried[k] += errors[k];
            }
            last = s.x;
        }
        Some(variance.map(|v: f64| v.max(0.0).sqrt()))
    }
}

/// Falls from 1 at 0 to 0 at ±1 (tricube).
fn kernel(u: f64) -> f64 {
    let u = u.abs();
    if u < 1.0 { (1.0 - u * u * u).powi(3) } else { 0.0 }
}

/// Tukey's biweight: what is farther than 1 does not count.
fn biweight(u: f64) -> f64 {
    let u = u * u;
    if u < 1.0 { (1.0 - u) * (1.0 - u) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(f: impl Fn(f64) -> f64) -> Vec<Sample> {
        let at = |k: i32| f64::from(k) * 0.25;
        (-8..=8)
            .map(|k| Sample { x: at(k), y: f(at(k)), weight: 1.0, sigma: 0.1, ..Sample::default() })
            .collect()
    }

    #[test]
    fn a_parabola_is_found_exactly_and_a_stray_sample_ignored() {
        let mut s = samples(|x| 0.3 - 0.2 * x + 0.1 * x * x);
        s[3].y += 5.0;
        let fit = parabola(&s, 2.0, 1.0, &mut Vec::new()).unwrap();
        assert!((fit.place - 0.3).abs() < 1e-9, "{fit:?}");
        assert!((fit.slope + 0.2).abs() < 1e-9 && (fit.bend - 0.1).abs() < 1e-9, "{fit:?}");
    }

    #[test]
    fn means_of_places_on_a_bend_do_not_pull_the_curve_inside() {
        // Each sample stands for places of variance 0.04 along y = x².
        let spread = |s: Sample| Sample { y: s.y + 0.04, along_variance: 0.04, ..s };
        let means: Vec<_> = samples(|x| x * x).into_iter().map(spread).collect();
        let fit = parabola(&means, 2.0, 10.0, &mut Vec::new()).unwrap();
        assert!(fit.place.abs() < 1e-9 && (fit.bend - 1.0).abs() < 1e-9, "{fit:?}");
    }

    #[test]
    fn the_predicted_spread_of_a_mean_of_line_samples_is_right() {
        // A parabola through n even samples has 9/4 the variance of their mean at its middle.
        let fit = parabola(&samples(|_| 0.0), 2.0, 1.0, &mut Vec::new()).unwrap();
        let expected = 0.1 * (2.25 / 17.0_f64).sqrt();
        assert!((fit.place_sigma / expected - 1.0).abs() < 0.05, "{fit:?}");
    }

    #[test]
    fn one_sided_samples_do_not_make_a_parabola() {
        let right: Vec<_> = samples(|x| x).into_iter().filter(|s| s.x > 0.0).collect();
        assert_eq!(parabola(&right, 2.0, 1.0, &mut Vec::new()), None);
        let right: Vec<_> =
            right.iter().map(|s| LineSample::new((s.x, s.y), s.weight, 3.0)).collect();
        let line = line(&right, 1.0).unwrap();
        assert!((line.slope - 1.0).abs() < 1e-9);
    }
}
