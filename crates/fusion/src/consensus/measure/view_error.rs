//! The systematic errors of views: the part of the spread between views that the nodes' own errors
//! do not explain (random effects model).
//!
//! **Problem.** Pixel noise averages out along a curve. Errors of calibration, pose and blur do
//! not, since neighbouring nodes share them, and views have to be weighed by these. Real scanners
//! err more where they see a surface obliquely: the laser's stripe and the pixel's patch get
//! longer. Pixel noise suggests the opposite, as an error along the ray counts less across an
//! oblique surface.
//!
//! **Idea.** Variance components by least squares. The variance across the curve is `h + o t²`,
//! with `t` the tangent of the incidence. Two nodes of two views beside each other lie a distance
//! `d` apart with `E d² = σ₁² + σ₂² + 2 h + o (t₁² + t₂²)`, which is linear in `h` and `o`.
//!
//! **Steps.**
//! 1. Start: the whole spread is independent of the incidence.
//! 2. Least squares, weighted by the last estimate: the square of a normal error has a standard
//!    deviation in proportion to its variance. Pairs more than three standard deviations apart are
//!    outliers or of different surfaces, and do not count.
//! 3. The part that grows with the incidence counts as far as it exceeds its own error (shrinkage
//!    of James and Stein, 1961). Otherwise chance would give weights to views that err alike at any
//!    incidence.
//!
//! **Source.** Not in the dissertation, whose averages weigh all views alike (5.5.2). Weights that
//! fall with the incidence go back to Turk and Levoy (1994); here they are measured.

use super::super::tuning::view_error::*;

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

/// Variance of a view's systematic error across the curve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct ViewError {
    /// Variance where the surface is seen head-on.
    pub head_on: f64,
    /// Increase per squared tangent of the incidence.
    pub oblique: f64,
}

/// An estimate, and the share of its oblique part that exceeds the part's own error.
struct Estimate {
    error: ViewError,
    trust: f64,
}

impl ViewError {
    /// Variance at an incidence of this squared tangent.
    pub fn variance(&self, squared_tangent: f64) -> f64 {
        self.head_on + self.oblique * squared_tangent
    }

    /// The error from pairs of nodes; `between_views` is the standard deviation of one view.
    pub fn of(pairs: &[Pair], between_views: f64) -> Self {
        let error = Self { head_on: between_views * between_views, oblique: 0.0 };
        let mut last = Estimate { error, trust: 0.0 };
        for _ in 0..ROUNDS {
            last = last.error.improved(pairs);
        }
        let Estimate { error, trust } = last;
        let shrunk = Self { head_on: error.head_on, oblique: error.oblique * trust };
        // The part that shrinking removed counts at any incidence.
        shrunk.head_on_for(pairs)
    }

    /// Variance of the distance between the nodes of a pair.
    fn expected(&self, pair: &Pair) -> f64 {
        pair.variance + 2.0 * self.head_on + self.oblique * pair.squared_tangents
    }

    fn sums(&self, pairs: &[Pair]) -> Sums {
        let mut sums = Sums::default();
        for pair in pairs {
            let expected = self.expected(pair);
            let squared = pair.distance * pair.distance;
            if expected > 0.0 && squared <= SQUARED_CUT * expected {
                let unexplained = squared / VARIANCE_LEFT_BY_CUT - pair.variance;
                sums.add(pair.squared_tangents, unexplained, 1.0 / (expected * expected));
            }
        }
        sums
    }

    /// The next estimate.
    fn improved(&self, pairs: &[Pair]) -> Estimate {
        let sums = self.sums(pairs);
        let line = sums.line();
        // A variance cannot be negative.
        let (head_on, oblique) =
            if line.level < 0.0 { (0.0, sums.line_through_0()) } else { (line.level, line.slope) };
        let trust = 1.0 - oblique.variance / (oblique.value * oblique.value);
        if oblique.value > 0.0 && trust > 0.0 {
            Estimate { error: Self { head_on: 0.5 * head_on, oblique: oblique.value }, trust }
        } else {
            let error = Self { head_on: 0.5 * sums.level(0.0), oblique: 0.0 };
            Estimate { error, trust: 0.0 }
        }
    }

    /// The same oblique part with the level that fits it.
    fn head_on_for(self, pairs: &[Pair]) -> Self {
        Self { head_on: 0.5 * self.sums(pairs).level(self.oblique), ..self }
    }
}

#[derive(Debug, Clone, Copy)]
struct Line {
    level: f64,
    slope: Slope,
}

#[derive(Debug, Clone, Copy)]
struct Slope {
    value: f64,
    variance: f64,
}

/// Weighted sums for a straight line. The weight of a sample is one over its squared expectation;
/// the square of a normal error has twice that as its variance.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    w: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
}

impl Sums {
    fn add(&mut self, x: f64, y: f64, w: f64) {
        self.w += w;
        self.x += w * x;
        self.y += w * y;
        self.xx += w * x * x;
        self.xy += w * x * y;
    }

    /// The line; only a level where all samples have one place.
    fn line(&self) -> Line {
        let spread = self.xx * self.w - self.x * self.x;
        if spread.is_nan() || spread <= LEAST_SPREAD * self.xx * self.w {
            let slope = Slope { value: 0.0, variance: f64::INFINITY };
            return Line { level: self.level(0.0), slope };
        }
        let value = (self.xy * self.w - self.x * self.y) / spread;
        let slope = Slope { value, variance: VARIANCE_OF_SQUARE * self.w / spread };
        Line { level: (self.y - value * self.x) / self.w, slope }
    }

    /// The level that fits a slope, at least 0.
    fn level(&self, slope: f64) -> f64 {
        if self.w > 0.0 { ((self.y - slope * self.x) / self.w).max(0.0) } else { 0.0 }
    }

    fn line_through_0(&self) -> Slope {
        if self.xx > 0.0 {
            Slope { value: self.xy / self.xx, variance: VARIANCE_OF_SQUARE / self.xx }
        } else {
            Slope { value: 0.0, variance: f64::INFINITY }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distances drawn as the quantiles of a normal error, in an order unrelated to the incidences.
    fn pairs(own: f64, variance_at: impl Fn(f64) -> f64) -> Vec<Pair> {
        let count = 400_u32;
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
            let error = quantile((f64::from(k) + 0.5) / f64::from(count));
            let t = |k: u32| f64::from(k % 31) / 10.0;
            let (a, b) = (t(k * 17), t(k * 29 + 5));
            let variance = 2.0 * own * own + variance_at(a) + variance_at(b);
            Pair {
                distance: (error * variance.sqrt()).abs(),
                variance: 2.0 * own * own,
                squared_tangents: a * a + b * b,
            }
        };
        (0..count).map(pair).collect()
    }

    #[test]
    fn what_grows_with_the_incidence_is_told_from_what_does_not() {
        for (head_on, oblique) in [(0.04, 0.0), (0.04, 0.04), (0.0, 0.03), (0.04, 0.01)] {
            let found = ViewError::of(&pairs(0.1, |t| head_on + oblique * t * t), 0.3);
            assert!((found.head_on - head_on).abs() < 0.012, "{head_on} {oblique}: {found:?}");
            assert!((found.oblique - oblique).abs() < 0.2 * oblique + 0.002, "{found:?}");
        }
    }

    #[test]
    fn own_errors_explain_what_they_can() {
        let found = ViewError::of(&pairs(0.1, |_| 0.0), 0.1);
        assert!(found.variance(0.0) < 0.001 && found.variance(9.0) < 0.004, "{found:?}");
    }

    #[test]
    fn surfaces_beside_each_other_do_not_count() {
        let mut pairs = pairs(0.1, |t| 0.01 + 0.01 * t * t);
        let clean = ViewError::of(&pairs, 0.2);
        pairs.iter_mut().step_by(20).for_each(|p| p.distance = 3.0);
        let found = ViewError::of(&pairs, 0.2);
        assert!(found.variance(1.0) < 1.3 * clean.variance(1.0), "{clean:?} {found:?}");
    }

    #[test]
    fn one_incidence_says_nothing_about_others() {
        let mut pairs = pairs(0.1, |_| 0.02);
        pairs.iter_mut().for_each(|p| p.squared_tangents = 2.0);
        let found = ViewError::of(&pairs, 0.2);
        assert!(found.oblique == 0.0 && (found.head_on - 0.02).abs() < 0.004, "{found:?}");
        assert_eq!(ViewError::of(&[], 0.2), ViewError::default(), "and no pair nothing at all");
    }
}
