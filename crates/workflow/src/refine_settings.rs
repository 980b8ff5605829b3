//! Settings of refinement: of the section planes, and of the poses.

use crate::WorkflowError;
use std::fmt;
use std::str::FromStr;
use transect::register::{PosePrior, RefineOptions};
use transect::{Refinement, Setup};
use transect_geometry::{Length, LengthUnit};

/// Where planes are inserted between neighbouring planes.
///
/// As text: the tolerance, and the smallest interval behind a comma, such as `2mm,5mm`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefineSettings {
    /// Planes are inserted where the curves of neighbouring planes differ by more than this length.
    pub tolerance: Length,
    /// The smallest interval: the interval of the planes, halved a whole number of times. Without
    /// it, a sixteenth of the interval.
    pub smallest: Option<Length>,
}

impl RefineSettings {
    /// The refinement of the planes of a setup.
    ///
    /// # Errors
    /// [`WorkflowError::Setting`] if the tolerance is not positive, or the smallest interval is not
    /// the interval, halved a whole number of times.
    pub(crate) fn refinement(&self, setup: &Setup) -> Result<Refinement, WorkflowError> {
        let (unit, interval) = (setup.unit, setup.planes.interval());
        let tolerance = self.tolerance.in_unit(unit);
        let refinement = match self.smallest {
            None => Refinement::new(tolerance, Refinement::DEFAULT_LEVELS),
            Some(smallest) => Refinement::down_to(tolerance, interval, smallest.in_unit(unit)),
        };
        refinement.map_err(|e| WorkflowError::setting("refine", format!("{e} (in {unit})")))
    }
}

impl FromStr for RefineSettings {
    type Err = WorkflowError;

    fn from_str(text: &str) -> Result<Self, WorkflowError> {
        let length = |text: &str| text.parse().map_err(|e| WorkflowError::setting("refine", e));
        Ok(match text.split_once(',') {
            None => Self { tolerance: length(text)?, smallest: None },
            Some((tolerance, smallest)) => {
                Self { tolerance: length(tolerance)?, smallest: Some(length(smallest)?) }
            }
        })
    }
}

/// How far the given poses may be wrong, as standard deviations. Both are positive.
///
/// As text: degrees, comma, length, such as `0.3,10mm`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PriorSettings {
    rotation_degrees: f64,
    translation: Length,
}

impl PriorSettings {
    /// A standard deviation of the rotation about each axis, in degrees, and one of the translation
    /// along each axis.
    ///
    /// # Errors
    /// [`WorkflowError::Setting`] if the angle is not over 0 and up to 180 degrees, or the length
    /// is not positive.
    pub fn new(rotation_degrees: f64, translation: Length) -> Result<Self, WorkflowError> {
        let settings = Self { rotation_degrees, translation };
        match settings.problem() {
            Some(found) => Err(wrong_prior(&settings.to_string(), found)),
            None => Ok(settings),
        }
    }

    fn problem(&self) -> Option<&'static str> {
        if !(self.rotation_degrees > 0.0 && self.rotation_degrees <= 180.0) {
            return Some("the angle is not between 0 and 180 degrees");
        }
        (!self.translation.is_positive()).then_some("the length is not positive")
    }

    /// The options of the refinement of poses. `unit` is the scan's.
    pub(crate) fn options(prior: Option<Self>, unit: LengthUnit) -> RefineOptions {
        let prior = prior.map(|Self { rotation_degrees, translation }| PosePrior {
            rotation: rotation_degrees.to_radians(),
            translation: translation.in_unit(unit),
        });
        RefineOptions { prior, ..RefineOptions::default() }
    }
}

impl fmt::Display for PriorSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{}", self.rotation_degrees, self.translation)
    }
}

impl FromStr for PriorSettings {
    type Err = WorkflowError;

    fn from_str(text: &str) -> Result<Self, WorkflowError> {
        let wrong = |found| wrong_prior(text, found);
        let (degrees, length) = text.split_once(',').ok_or_else(|| wrong("there is no comma"))?;
        let degrees = degrees.trim().parse().map_err(|_| wrong("the angle is no number"))?;
        let length = length.parse().map_err(|e| WorkflowError::setting("prior", e))?;
        let settings = Self { rotation_degrees: degrees, translation: length };
        settings.problem().map_or(Ok(settings), |found| Err(wrong(found)))
    }
}

fn wrong_prior(text: &str, found: &str) -> WorkflowError {
    let problem = format!(
        "{text}: {found}; write the standard deviations of the poses as DEGREES,LENGTH, both \
         positive, such as 0.3,10mm"
    );
    WorkflowError::setting("prior", problem)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_prior_is_an_angle_and_a_length() {
        let prior = "0.5, 10mm".parse().unwrap();
        let prior = PriorSettings::options(Some(prior), LengthUnit::Metre).prior.unwrap();
        assert!((prior.rotation - 0.5_f64.to_radians()).abs() < 1e-15);
        assert!((prior.translation - 0.01).abs() < 1e-15);
        for (text, wanted) in [
            ("1", "there is no comma"),
            ("-1,2", "between 0 and 180 degrees"),
            ("0,2", "between 0 and 180 degrees"),
            ("NaN,2", "between 0 and 180 degrees"),
            ("x,2", "the angle is no number"),
            ("1,0", "the length is not positive"),
            ("1,-2mm", "the length is not positive"),
            ("1,2 parsec", "parsec"),
            ("1,2,3", "2,3"),
        ] {
            let error = text.parse::<PriorSettings>().unwrap_err().to_string();
            assert!(error.starts_with("prior: ") && error.contains(wanted), "{text}: {error}");
        }
        let error = PriorSettings::new(200.0, "10mm".parse().unwrap()).unwrap_err().to_string();
        assert!(error.starts_with("prior: 200,10mm: the angle is not between"), "{error}");
    }

    #[test]
    fn a_refinement_is_a_tolerance_and_a_smallest_interval() {
        let length = |text: &str| text.parse::<Length>().unwrap();
        let settings = |text: &str| text.parse::<RefineSettings>();
        let alone = RefineSettings { tolerance: length("2mm"), smallest: None };
        assert_eq!(settings("2mm").unwrap(), alone);
        let both = RefineSettings { smallest: Some(length("5")), ..alone };
        assert_eq!(settings("2mm, 5").unwrap(), both);
        let error = settings("2mm,").unwrap_err().to_string();
        assert_eq!(error, "refine: \"\" is not a length; write a number and a unit, such as 1mm");
    }
}
