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
pub(super) struct Pair {
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
        let (head_on, oblique, oblique_variance) = sums.solve();
        if head_on < 0.0 {
            let oblique = sums.oblique_alone();
            return (Self { head_on: 0.0, oblique }, 1.0);
        }
        let trust = 1.0 - oblique_variance / (oblique * oblique);
        if oblique > 0.0 && trust > 0.0 {
            return (Self { head_on: 0.5 * head_on, oblique }, trust);
        }
        (Self { head_on: 0.5 * sums.level(0.0), oblique: 0.0 }, 0.0)
    }

    /// The same with the level that goes with its part by the incidence.
    fn head_on_for(self, pairs: &[Pair]) -> Self {
        Self { head_on: 0.5 * self.sums(pairs).level(self.oblique), ..self }
    }
}

/// Weighted sums for a straight line.
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

    /// Level and slope of the line, and the variance of the slope where each sample's is twice the inverse
    /// of its weight; level alone where all samples are in one place.
    fn solve(&self) -> (f64, f64, f64) {
        let spread = self.xx * self.w - self.x * self.x;
        if spread.is_nan() || spread <= 1e-9 * self.xx * self.w {
            return (self.level(0.0), 0.0, f64::INFINITY);
        }
        let slope = (self.xy * self.w - self.x * self.y) / spread;
        ((self.y - slope * self.x) / self.w, slope, 2.0 * self.w / spread)
    }

    /// The level that goes with a slope, at least 0.
    fn level(&self, slope: f64) -> f64 {
        if self.w > 0.0 { ((self.y - slope * self.x) / self.w).max(0.0) } else { 0.0 }
    }

    /// The slope of a line through 0, at least 0.
    fn oblique_alone(&self) -> f64 {
        if self.xx > 0.0 { (self.xy / self.xx).max(0.0) } else { 0.0 }
    }
}
