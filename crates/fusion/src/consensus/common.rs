//! What the nodes of a view err by in common: the part of the spread between views that their own errors
//! do not explain (random effects model).
//!
//! **Problem.** Pixel noise averages out along a curve; calibration, pose and blur do not, and views are
//! to weigh by what is left. Real scanners err the more the more obliquely they see a surface: the laser's
//! stripe and the pixel's patch get longer. Pixel noise says the opposite, as an error along the ray
//! counts the less across an oblique surface.
//!
//! **Idea.** Variance components by least squares. The variance across the curve is `h + o t²`, with `t` the
//! tangent of the incidence. A pair of nodes of two views beside each other lies a distance `d` apart with
//! `E d² = σ₁² + σ₂² + 2 h + o (t₁² + t₂²)`, which is linear in what is wanted.
//!
//! **Steps.**
//! 1. Start: all of the spread is as at any incidence.
//! 2. Least squares with weights from the last estimate, since a square of a normal error has a standard
//!    deviation in proportion to its variance. Pairs farther apart than three standard deviations are of
//!    different surfaces, or outliers, and do not count.
//! 3. What the incidence adds is believed as far as it exceeds its own error (shrinkage of James and Stein,
//!    1961): views that err the same at any incidence are not to get weights from chance.
//!
//! **Source.** None in the dissertation, whose averages take all views alike (5.5.2). Weights that fall with
//! the incidence go back to Turk and Levoy (1994); here they are measured.

/// Two nodes of different views beside each other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair {
    /// Across the curve.
    pub distance: f64,
    /// Sum of the variances of both by their own errors.
    pub variance: f64,
    /// Sum of the squared tangents of both incidences.
    pub squared_tangents: f64,
}

/// Variance that the nodes of one view have in common, across the curve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Common {
    /// Where the surface is seen head-on.
    pub head_on: f64,
    /// More per squared tangent of the incidence.
    pub oblique: f64,
}

/// Variance of the square of a normal error, in squares of the error's variance.
const VARIANCE_OF_SQUARE: f64 = 2.0;

/// Samples whose places differ by less than this, squared and as a share of the places, have one place.
const LEAST_SPREAD: f64 = 1e-9;

/// How often weights follow from the last estimate.
const ROUNDS: usize = 4;

/// Standard deviations beyond which a pair does not count, squared, and the share of the variance of a
/// normal error that is left then.
const SQUARED_CUT: f64 = 9.0;
const LEFT_OF_VARIANCE: f64 = 0.9733;

impl Common {
    /// Variance at an incidence of this squared tangent.
    pub fn variance(&self, squared_tangent: f64) -> f64 {
        self.head_on + self.oblique * squared_tangent
    }

    /// That of pairs between which there is this spread, the standard deviation of one view.
    pub fn of(pairs: &[Pair], between: f64) -> Self {
        let mut common = Self { head_on: between * between, oblique: 0.0 };
        let mut trust = 0.0;
        for _ in 0..ROUNDS {
            (common, trust) = common.improved(pairs);
        }
        let shrunk = Self { head_on: common.head_on, oblique: common.oblique * trust };
        // What is not believed of the oblique is error at any incidence.
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
                let unexplained = squared / LEFT_OF_VARIANCE - pair.variance;
                sums.add(pair.squared_tangents, unexplained, 1.0 / (expected * expected));
            }
        }
        sums
    }

    /// The next estimate, and how far its part by the incidence is to be believed.
    fn improved(&self, pairs: &[Pair]) -> (Self, f64) {
        let sums = self.sums(pairs);
        let line = sums.line();
        // Less than nothing cannot be left.
        let (head_on, oblique) =
            if line.level < 0.0 { (0.0, sums.line_through_0()) } else { (line.level, line.slope) };
        let trust = 1.0 - oblique.variance / (oblique.value * oblique.value);
        if oblique.value > 0.0 && trust > 0.0 {
            (Self { head_on: 0.5 * head_on, oblique: oblique.value }, trust)
        } else {
            (Self { head_on: 0.5 * sums.level(0.0), oblique: 0.0 }, 0.0)
        }
    }

    /// The same with the level that goes with its part by the incidence.
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

/// Weighted sums for a straight line. The weight of a sample is one over the square of what is expected of
/// it, and a square of a normal error has twice that for its variance.
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

    /// The line; a level alone where all samples are in one place.
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

    /// The level that goes with a slope, at least 0.
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

    /// Distances drawn as the quantiles of a normal error, in an order that has nothing to do with incidences.
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
            let found = Common::of(&pairs(0.1, |t| head_on + oblique * t * t), 0.3);
            assert!((found.head_on - head_on).abs() < 0.012, "{head_on} {oblique}: {found:?}");
            assert!((found.oblique - oblique).abs() < 0.2 * oblique + 0.002, "{found:?}");
        }
    }

    #[test]
    fn own_errors_explain_what_they_can() {
        let found = Common::of(&pairs(0.1, |_| 0.0), 0.1);
        assert!(found.variance(0.0) < 0.001 && found.variance(9.0) < 0.004, "{found:?}");
    }

    #[test]
    fn surfaces_beside_each_other_do_not_count() {
        let mut pairs = pairs(0.1, |t| 0.01 + 0.01 * t * t);
        let clean = Common::of(&pairs, 0.2);
        pairs.iter_mut().step_by(20).for_each(|p| p.distance = 3.0);
        let found = Common::of(&pairs, 0.2);
        assert!(found.variance(1.0) < 1.3 * clean.variance(1.0), "{clean:?} {found:?}");
    }

    #[test]
    fn one_incidence_says_nothing_about_others() {
        let mut pairs = pairs(0.1, |_| 0.02);
        pairs.iter_mut().for_each(|p| p.squared_tangents = 2.0);
        let found = Common::of(&pairs, 0.2);
        assert!(found.oblique == 0.0 && (found.head_on - 0.02).abs() < 0.004, "{found:?}");
        assert_eq!(Common::of(&[], 0.2), Common::default(), "and no pair nothing at all");
    }
}
