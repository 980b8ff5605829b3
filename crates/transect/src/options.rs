//! The allowed values of the methods' options.

use crate::Setup;
use std::f64::consts::{FRAC_PI_2, PI};
use transect_fusion::FusionMethod;
use transect_partial::Method;
use transect_partial::dissertation::JumpTest;

/// An option of a method has a value that it cannot have.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the option {name} is {found}; it must be {}", range.text())]
pub struct OptionError {
    /// The option, as the field of its struct is called.
    pub name: &'static str,
    /// Its value.
    pub found: f64,
    range: Range,
}

/// The values that an option can have.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Range {
    /// The angle of a surface to a ray.
    Incidence,
    /// The angle between two directions.
    Directions,
    /// A positive share.
    Share,
    Positive,
    NotNegative,
}

impl Range {
    fn text(self) -> &'static str {
        match self {
            Self::Incidence => "an angle in radians over 0 and up to π/2 (90°)",
            Self::Directions => "an angle in radians over 0 and up to π (180°)",
            Self::Share => "over 0 and up to 1",
            Self::Positive => "a finite number over 0",
            Self::NotNegative => "a finite number, 0 or more",
        }
    }

    fn holds(self, value: f64) -> bool {
        let highest = match self {
            Self::Incidence => FRAC_PI_2,
            Self::Directions => PI,
            Self::Share => 1.0,
            Self::Positive | Self::NotNegative => f64::MAX,
        };
        let is_above = value > 0.0 || (self == Self::NotNegative && value == 0.0);
        is_above && value <= highest
    }
}

impl Setup {
    /// Checks the options of both methods. [`reconstruct`](crate::reconstruct) and
    /// [`Grower::new`](crate::Grower::new) do so, too.
    ///
    /// # Errors
    /// [`OptionError`] naming the first option whose value would give a wrong model.
    pub fn check_options(&self) -> Result<(), OptionError> {
        let options = self.partial_options().into_iter().chain(self.fusion_options());
        let wrong = options.into_iter().find(|(_, found, range)| !range.holds(*found));
        wrong.map_or(Ok(()), |(name, found, range)| Err(OptionError { name, found, range }))
    }

    fn partial_options(&self) -> Vec<(&'static str, f64, Range)> {
        let jump = |angle, sigmas| {
            vec![
                ("max_incidence_rad", angle, Range::Incidence),
                ("jump_sigmas", sigmas, Range::NotNegative),
            ]
        };
        match &self.partial {
            Method::OnePass(options) => {
                let mut all = jump(options.max_incidence_rad, options.jump_sigmas);
                all.push(("excursion_sigmas", options.excursion_sigmas, Range::NotNegative));
                all.push(("least_sigma_factor", options.least_sigma_factor, Range::Share));
                all
            }
            Method::Dissertation(options) => match options.jump {
                JumpTest::ScaleFree { max_incidence_rad, jump_sigmas } => {
                    jump(max_incidence_rad, jump_sigmas)
                }
                JumpTest::Printed { threshold } => vec![("threshold", threshold, Range::Positive)],
            },
        }
    }

    fn fusion_options(&self) -> Vec<(&'static str, f64, Range)> {
        match &self.fusion {
            FusionMethod::Consensus(options) => vec![
                ("threshold_spreads", options.threshold_spreads, Range::Positive),
                ("direction_limit_rad", options.direction_limit_rad, Range::Directions),
                ("shortest_footprints", options.shortest_footprints, Range::NotNegative),
            ],
            FusionMethod::Pairwise(options) => {
                vec![("threshold_spreads", options.threshold_spreads, Range::Positive)]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_fusion::ConsensusOptions;
    use transect_geometry::{LengthUnit, PlaneFamily, StraightGuide, Vector3};
    use transect_partial::one_pass::OnePassOptions;

    fn setup() -> Setup {
        let guide = StraightGuide::along(Vector3::z()).unwrap();
        Setup::new(LengthUnit::Metre, PlaneFamily::new(guide, 0.0, 0.1).unwrap())
    }

    fn message(setup: &Setup) -> String {
        setup.check_options().map_or_else(|error| error.to_string(), |()| String::new())
    }

    #[test]
    fn options_outside_their_range_are_named() {
        let one_pass = |change: fn(&mut OnePassOptions)| {
            let (mut setup, mut options) = (setup(), OnePassOptions::default());
            change(&mut options);
            setup.partial = Method::OnePass(options);
            message(&setup)
        };
        assert_eq!(one_pass(|_| ()), "");
        assert_eq!(one_pass(|o| (o.jump_sigmas, o.excursion_sigmas) = (0.0, 0.0)), "");
        assert_eq!(
            one_pass(|o| o.max_incidence_rad = 78.0),
            "the option max_incidence_rad is 78; it must be an angle in radians over 0 and up to \
             π/2 (90°)"
        );
        for (found, name) in [
            (one_pass(|o| o.max_incidence_rad = f64::NAN), "max_incidence_rad is NaN"),
            (one_pass(|o| o.jump_sigmas = -1.0), "jump_sigmas is -1"),
            (one_pass(|o| o.excursion_sigmas = f64::INFINITY), "excursion_sigmas is inf"),
            (one_pass(|o| o.least_sigma_factor = 0.0), "least_sigma_factor is 0"),
        ] {
            assert!(found.contains(name), "{found:?} instead of {name}");
        }
    }

    #[test]
    fn options_of_the_other_methods_are_checked_too() {
        let mut of_dissertation = setup();
        let mut options = transect_partial::dissertation::DissertationOptions::default();
        options.jump = JumpTest::Printed { threshold: -0.1 };
        of_dissertation.partial = Method::Dissertation(options);
        assert!(message(&of_dissertation).contains("threshold is -0.1"));
        let mut of_consensus = setup();
        let mut options = ConsensusOptions::default();
        options.direction_limit_rad = 50.0;
        of_consensus.fusion = FusionMethod::Consensus(options);
        assert!(message(&of_consensus).contains("direction_limit_rad is 50"));
        let mut of_pairwise = setup();
        let mut options = transect_fusion::PairwiseOptions::default();
        options.threshold_spreads = f64::NAN;
        of_pairwise.fusion = FusionMethod::Pairwise(options);
        assert!(message(&of_pairwise).contains("threshold_spreads is NaN"));
    }

    #[test]
    fn a_run_with_a_wrong_option_stops_before_its_work() {
        let mut setup = setup();
        let mut options = OnePassOptions::default();
        options.max_incidence_rad = -1.0;
        setup.partial = Method::OnePass(options);
        let error = crate::reconstruct::<transect_device::View>(&[], &setup, &crate::Unwatched);
        let error = error.unwrap_err().to_string();
        assert!(error.contains("max_incidence_rad is -1"), "{error}");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.store");
        let store = transect_model::store::Store::create(path, &setup.store_header()).unwrap();
        let error = crate::Grower::new(&store, &setup).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("max_incidence_rad is -1"), "{error}");
    }
}
