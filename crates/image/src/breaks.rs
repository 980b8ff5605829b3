//! Where neighbouring pixels do not belong to one surface (dissertation, section 3.4.2).

use std::f64::consts::FRAC_PI_2;
use transect_device::{Neighbour, PairGeometry, View, quantile};

/// Most rows whose pairs are measured. No unit. Chosen by hand: they hold some thousand pairs.
/// Doubled, measuring takes twice the time.
const LINES: usize = 32;

/// Share of the pairs whose distance between rays is plausible. No unit. Chosen by hand: the widest
/// gap between the rows of a 32-row laser scanner is 3 % of the pairs of rows. With 0.96, such a
/// gap is broken.
const PLAUSIBLE: f64 = 0.98;

/// Distance between the rays of a pair, over the plausible one, from which one sample is off its
/// ray. No unit. Chosen by hand: surfaces four times as far away as nearly all others stay whole.
/// Doubled, curves reach out to outliers twice as far away.
const OFF_RAY: f32 = 4.0;

/// The scale-free test for a range jump.
///
/// Two neighbours belong to one surface while the range changes by no more than `lateral ·
/// tan(maximum incidence) + slack`. A surface seen more obliquely than the maximum incidence looks
/// like the step between two surfaces. The printed test compares `|r_obj − r_pln|` with a threshold
/// in the scene's unit and needs tuning for every scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BreakRule {
    tan_incidence: f32,
    slack: f32,
    largest_lateral: f32,
    joins_grazing: bool,
}

impl BreakRule {
    /// Largest angle of incidence by default, in radians. Chosen by hand: more keeps more of the
    /// rims, where real scanners overshoot. Doubled, no pair is broken.
    pub const MAX_INCIDENCE_RAD: f64 = 78_f64.to_radians();

    /// Standard deviations of the range that noise alone explains by default. No unit. Chosen by
    /// hand: the difference of two samples with normal noise exceeds as many in 1 of 200 pairs.
    /// Doubled, range jumps of 4 to 8 standard deviations are taken for one surface.
    pub const JUMP_SIGMAS: f64 = 4.0;

    /// A rule from the largest angle of incidence, in radians, and the range difference that noise
    /// alone explains, in the model's length unit.
    ///
    /// The angle is taken to be within 0 and a right angle. From a right angle on, pairs of pixels
    /// on different rays are never broken. NaN breaks all pairs.
    pub fn new(max_incidence_rad: f64, slack: f64) -> Self {
        // Beyond a right angle the tangent is negative, and every pair would be broken.
        let angle = max_incidence_rad.clamp(0.0, FRAC_PI_2);
        let (tan_incidence, slack) = (angle.tan() as f32, slack as f32);
        let largest_lateral = f32::INFINITY;
        Self { tan_incidence, slack, largest_lateral, joins_grazing: false }
    }

    /// The same rule, which also joins flat surfaces beyond the largest angle:
    /// [`Grazing`](crate::Grazing). A pair by itself does not tell, so [`Self::holds`] does not
    /// change.
    pub fn with_grazing(self) -> Self {
        Self { joins_grazing: true, ..self }
    }

    /// Whether flat surfaces beyond the largest angle are joined.
    pub fn joins_grazing(&self) -> bool {
        self.joins_grazing
    }

    /// The same rule, which also breaks the pairs of a view with a sample off its ray.
    ///
    /// The rays of a point grid follow from its points. An outlier then seems to be on a ray far
    /// from its neighbours' rays, and the first rule allows any range step over that distance.
    /// Sensors with tables of their rays have no such samples.
    pub fn on_rays_of(self, view: &View) -> Self {
        let frame = view.frame();
        let size = view.image().size();
        let mut largest_lateral = 0.0_f32;
        for neighbour in [Neighbour::Left, Neighbour::Up] {
            if frame.ray_products(neighbour).is_some() {
                return self;
            }
            let mut pairs = vec![PairGeometry::MISSING; size.cols];
            let mut laterals = Vec::new();
            for row in (0..size.rows).step_by(size.rows.div_ceil(LINES).max(1)) {
                frame.pair_row(view.image(), row, neighbour, &mut pairs);
                laterals.extend(pairs.iter().map(|p| f64::from(p.lateral)).filter(|l| !l.is_nan()));
            }
            if let Some(lateral) = quantile(laterals, PLAUSIBLE) {
                largest_lateral = largest_lateral.max(OFF_RAY * lateral as f32);
            }
        }
        Self { largest_lateral, ..self }
    }

    /// Tangent of the largest angle of incidence.
    pub fn tan_incidence(&self) -> f32 {
        self.tan_incidence
    }

    /// Range difference that noise alone explains, in the model's length unit.
    pub fn slack(&self) -> f32 {
        self.slack
    }

    /// Whether two neighbouring samples belong to one surface; false if one is missing.
    pub fn holds(&self, pair: &PairGeometry) -> bool {
        self.allows_step(pair) && pair.lateral <= self.largest_lateral
    }

    /// Whether the range step between two samples, which need not be neighbours, is one of a
    /// surface; false if one is missing.
    pub fn allows_step(&self, pair: &PairGeometry) -> bool {
        // A comparison with NaN is false, which is what a missing pixel needs.
        pair.range_step <= self.tan_incidence * pair.lateral + self.slack
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_scales_with_distance_and_allows_for_noise() {
        let rule = BreakRule::new(60_f64.to_radians(), 0.01);
        let holds = |range_step, lateral| rule.holds(&PairGeometry { range_step, lateral });
        assert!(holds(0.17, 0.1) && !holds(0.19, 0.1));
        assert!(holds(1.7, 1.0) && !holds(1.8, 1.0));
        assert!(holds(0.009, 0.0), "noise between samples at one place");
        assert!(!rule.holds(&PairGeometry::MISSING));
    }

    #[test]
    fn angles_beyond_a_right_angle_break_no_pair_and_negative_ones_allow_noise_alone() {
        let holds = |angle: f64, range_step, lateral| {
            BreakRule::new(angle, 0.01).holds(&PairGeometry { range_step, lateral })
        };
        for angle in [FRAC_PI_2, 100_f64.to_radians(), 78.0, f64::INFINITY] {
            assert!(holds(angle, 1e3, 1e-3) && holds(angle, 0.0, 1e-3), "{angle}");
            assert!(!holds(angle, 1.0, 0.0) && holds(angle, 0.009, 0.0), "{angle}: one ray");
        }
        for angle in [0.0, -1.0] {
            assert!(holds(angle, 0.009, 1.0) && !holds(angle, 0.011, 1.0), "{angle}");
        }
        assert!(!holds(f64::NAN, 0.0, 1.0));
    }
}
