//! Robust local fits in a curve's own direction: a line for a first place, a parabola for the last.

use nalgebra::{Matrix3, Vector3};

/// One observation in a local frame along (x) and across (y) a curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub x: f64,
    pub y: f64,
    pub weight: f64,
    /// Standard deviation of y.
    pub sigma: f64,
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
        s.y - (self.place + self.slope * s.x + self.bend * s.x * s.x)
    }
}

/// A robust weighted line through samples with `|x| <= reach`, with weights that fall to the reach.
///
/// Samples farther from it than `across` do not count. `None` without samples.
pub(super) fn line(samples: &[Sample], reach: f64, across: f64) -> Option<Fit> {
    let mut fit = weighted_line(samples, |s| kernel(s.x / reach))?;
    for _ in 0..2 {
        let last = fit;
        let weight = |s: &Sample| kernel(s.x / reach) * biweight(last.residual(s) / across);
        fit = weighted_line(samples, weight).unwrap_or(last);
    }
    Some(fit)
}

fn weighted_line(samples: &[Sample], weight: impl Fn(&Sample) -> f64) -> Option<Fit> {
    let (mut w, mut wx, mut wy, mut wxx, mut wxy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for s in samples {
        let k = s.weight * weight(s);
        (w, wx, wy) = (w + k, wx + k * s.x, wy + k * s.y);
        (wxx, wxy) = (wxx + k * s.x * s.x, wxy + k * s.x * s.y);
    }
    if w <= 0.0 {
        return None;
    }
    let variance = wxx - wx * wx / w;
    // All samples at one x have a place but no slope.
    let slope = if variance > 1e-12 * wxx { (wxy - wx * wy / w) / variance } else { 0.0 };
    Some(Fit { place: (wy - slope * wx) / w, slope, ..Fit::default() })
}

/// A robust weighted parabola through samples with `|x| <= reach`.
///
/// `None` unless samples lie on both sides and determine it.
pub(super) fn parabola(samples: &[Sample], reach: f64, across: f64) -> Option<Fit> {
    let mut fit = weighted_parabola(samples, reach, |_| 1.0)?;
    for _ in 0..2 {
        let last = fit;
        let robust = |s: &Sample| biweight(last.residual(s) / across);
        fit = weighted_parabola(samples, reach, robust).unwrap_or(last);
    }
    Some(fit)
}

fn weighted_parabola(
    samples: &[Sample],
    reach: f64,
    robust: impl Fn(&Sample) -> f64,
) -> Option<Fit> {
    // Moments in x / reach keep the matrix well scaled.
    let mut m = [0.0; 5];
    let mut right = Vector3::zeros();
    let mut noise = [0.0; 5];
    let (mut behind, mut ahead) = (0, 0);
    for s in samples.iter().filter(|s| s.x.abs() <= reach) {
        let x = s.x / reach;
        let w = s.weight * robust(s);
        let spread = w * s.sigma;
        let mut power = 1.0;
        for k in 0..5 {
            m[k] += w * power;
            noise[k] += spread * spread * power;
            if k < 3 {
                right[k] += w * s.y * power;
            }
            power *= x;
        }
        behind += usize::from(x < 0.0);
        ahead += usize::from(x > 0.0);
    }
    if behind < 2 || ahead < 2 {
        return None;
    }
    let moments = |m: &[f64; 5]| Matrix3::new(m[0], m[1], m[2], m[1], m[2], m[3], m[2], m[3], m[4]);
    let normal = moments(&m);
    let determined = normal.determinant() > 1e-9 * m[0] * m[0] * m[0];
    let inverse = normal.try_inverse().filter(|_| determined)?;
    let solution = inverse * right;
    let covariance = inverse * moments(&noise) * inverse;
    Some(Fit {
        place: solution[0],
        slope: solution[1] / reach,
        bend: solution[2] / (reach * reach),
        place_sigma: covariance[(0, 0)].max(0.0).sqrt(),
        bend_sigma: covariance[(2, 2)].max(0.0).sqrt() / (reach * reach),
    })
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
        (-8..=8).map(|k| Sample { x: at(k), y: f(at(k)), weight: 1.0, sigma: 0.1 }).collect()
    }

    #[test]
    fn a_parabola_is_found_exactly_and_a_stray_sample_ignored() {
        let mut s = samples(|x| 0.3 - 0.2 * x + 0.1 * x * x);
        s[3].y += 5.0;
        let fit = parabola(&s, 2.0, 1.0).unwrap();
        assert!((fit.place - 0.3).abs() < 1e-9, "{fit:?}");
        assert!((fit.slope + 0.2).abs() < 1e-9 && (fit.bend - 0.1).abs() < 1e-9, "{fit:?}");
    }

    #[test]
    fn the_predicted_spread_of_a_mean_of_line_samples_is_right() {
        // A parabola through n even samples has 9/4 the variance of their mean at its middle.
        let fit = parabola(&samples(|_| 0.0), 2.0, 1.0).unwrap();
        let expected = 0.1 * (2.25 / 17.0_f64).sqrt();
        assert!((fit.place_sigma / expected - 1.0).abs() < 0.05, "{fit:?}");
    }

    #[test]
    fn one_sided_samples_do_not_make_a_parabola() {
        let right: Vec<_> = samples(|x| x).into_iter().filter(|s| s.x > 0.0).collect();
        assert_eq!(parabola(&right, 2.0, 1.0), None);
        let line = line(&right, 3.0, 1.0).unwrap();
        assert!((line.slope - 1.0).abs() < 1e-9);
    }
}
