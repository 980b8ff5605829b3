//! Where neighbouring pixels do not belong to one surface (dissertation, section 3.4.2).

use transect_device::PairGeometry;

/// The scale-free test for a range jump.
///
/// Two neighbours belong to one surface while the range changes by no more than
/// `lateral · tan(maximum incidence) + slack`: a surface seen more obliquely than the maximum
/// incidence cannot be told from the step between two surfaces. The printed test compares
/// `|r_obj − r_pln|` with a threshold in the scene's unit and needs tuning for every scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BreakRule {
    tan_incidence: f32,
    slack: f32,
}

impl BreakRule {
    /// A rule from the largest angle of incidence, in radians, and the range difference that noise
    /// alone explains, in the model's length unit.
    pub fn new(max_incidence_rad: f64, slack: f64) -> Self {
        Self { tan_incidence: max_incidence_rad.tan() as f32, slack: slack as f32 }
    }

    /// Tangent of the largest angle of incidence.
    pub fn tan_incidence(&self) -> f32 {
        self.tan_incidence
    }

    /// Range difference that noise alone explains, in the model's length unit.
    pub fn slack(&self) -> f32 {
        self.slack
    }

    /// Whether the two samples of a pair belong to one surface; false if one is missing.
    pub fn holds(&self, pair: &PairGeometry) -> bool {
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
}
