//! Local fits in a curve's own direction: the robust line for the first place, and the parts it
//! shares with the parabola for the final place.

/// A curve near x = 0: `y = place + slope x + bend x² + cubic x³ + quartic x⁴`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Fit {
    pub place: f64,
    pub slope: f64,
    pub bend: f64,
    /// Third and fourth order of an arc; zeros for lines and parabolas.
    pub cubic: f64,
    pub quartic: f64,
    /// Standard deviation of `place` from the samples' random errors.
    pub place_sigma: f64,
    /// Standard deviation of `bend`.
    pub bend_sigma: f64,
}

impl Fit {
    /// The curve at x.
    pub fn at(&self, x: f64) -> f64 {
        self.place + x * (self.slope + x * (self.bend + x * (self.cubic + x * self.quartic)))
    }

    /// Bound on how far the curve leaves its place within a reach.
    pub fn deepest(&self, reach: f64) -> f64 {
        let [slope, bend, cubic, quartic] =
            [self.slope, self.bend, self.cubic, self.quartic].map(f64::abs);
        reach * (slope + reach * (bend + reach * (cubic + reach * quartic)))
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
    pub fn new(x: f64, y: f64, weight: f64, reach: f64) -> Self {
        Self { x, y, weight, near: kernel(x / reach) }
    }
}

/// A robust weighted line. Samples farther from it than `across` do not count. `None` without
/// samples.
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
    if correlation > 0.0 { falling(2.0 * apart.abs() / correlation) } else { 0.0 }
}

/// exp(-z) for z >= 0, within 0.001 of it: the eighth power of one over four terms of the series.
fn falling(z: f64) -> f64 {
    let y = 0.125 * z;
    let root = 1.0 / (1.0 + y * (1.0 + y * (0.5 + y * (1.0 / 6.0))));
    let square = root * root;
    (square * square) * (square * square)
}

/// Falls from 1 at 0 to 0 at ±1 (tricube).
fn kernel(u: f64) -> f64 {
    let u = u.abs();
    if u < 1.0 { (1.0 - u * u * u).powi(3) } else { 0.0 }
}

/// Tukey's biweight: 0 beyond 1.
fn biweight(u: f64) -> f64 {
    let u = u * u;
    if u < 1.0 { (1.0 - u) * (1.0 - u) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_errors_fall_exponentially() {
        for k in 0..200 {
            let apart = 0.05 * f64::from(k);
            assert!((shared(apart, 2.0) - (-apart).exp()).abs() < 1e-3, "{apart}");
        }
        assert_eq!(shared(0.0, 2.0), 1.0);
        assert_eq!(shared(f64::INFINITY, 2.0), 0.0);
    }

    #[test]
    fn a_line_is_found_exactly_and_a_stray_sample_ignored() {
        let sample = |k: i32| {
            let x = 0.25 * f64::from(k);
            let stray = if k == 3 { 5.0 } else { 0.0 };
            LineSample::new(x, 0.5 * x - 1.0 + stray, 1.0, 3.0)
        };
        let samples: Vec<_> = (1..12).map(sample).collect();
        let line = line(&samples, 1.5).unwrap();
        assert!((line.slope - 0.5).abs() < 1e-9 && (line.place + 1.0).abs() < 1e-9, "{line:?}");
    }
}
