//! The settings of the dissertation's own methods: chapter 3 for one view, 5.4 for two curves.

use crate::WorkflowError;
use std::str::FromStr;
use transect::Setup;
use transect_fusion::FusionMethod;
use transect_fusion::pattern::OverlapTolerance;
use transect_geometry::{Length, LengthUnit};
use transect_partial::Method;
use transect_partial::dissertation::{DirectionRule, DissertationOptions, JumpTest, MOST_PIXELS};
use transect_partial::subpixel::Subpixel;

/// Settings of `dissertation` and of `pairwise`; each is an error with the other method.
///
/// Without a value, the store's holds, else the default.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct MethodSettings {
    /// How the point between two pixels is found (3.6).
    pub subpixel: Option<Subpixel>,
    /// Most missing pixels that a curve is continued across (3.5.1).
    pub gap: Option<usize>,
    /// Thickness in pixels up to which a curve is thinned (3.5.2).
    pub thickness: Option<usize>,
    /// How range jumps are found (3.4.2).
    pub jump: Option<JumpSetting>,
    /// How the direction of a curve is found (3.7).
    pub direction: Option<DirectionRule>,
    /// Distance within which two curves overlap (5.5.1); without it, measured.
    pub threshold: Option<Length>,
}

/// How range jumps are found. As text: `incidence`, or a length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JumpSetting {
    /// By the angle of incidence.
    Incidence,
    /// By the printed test |r_obj − r_pln| < length.
    Printed(Length),
}

impl FromStr for JumpSetting {
    type Err = WorkflowError;

    fn from_str(text: &str) -> Result<Self, WorkflowError> {
        match text {
            "incidence" => Ok(Self::Incidence),
            text => {
                let length = text.parse().map_err(|e| WorkflowError::setting("jump", e))?;
                Ok(Self::Printed(length))
            }
        }
    }
}

impl MethodSettings {
    /// Puts the settings into a setup.
    ///
    /// # Errors
    /// [`WorkflowError::Setting`] if a setting is for another method, or has no usable value.
    pub(crate) fn apply(&self, setup: &mut Setup) -> Result<(), WorkflowError> {
        let unit = setup.unit;
        if let Some(setting) = self.of_chapter_3() {
            let Method::Dissertation(options) = &mut setup.partial else {
                return Err(misplaced(setting, "the setting `method` dissertation", "one_pass"));
            };
            self.apply_to_views(options, unit)?;
        }
        let Some(threshold) = self.threshold else { return Ok(()) };
        let FusionMethod::Pairwise(options) = &mut setup.fusion else {
            return Err(misplaced("threshold", "the setting `fusion` pairwise", "consensus"));
        };
        options.tolerance = Some(tolerance(threshold.in_unit(unit))?);
        Ok(())
    }

    /// The first setting of chapter 3 that is given.
    fn of_chapter_3(&self) -> Option<&'static str> {
        let given = [
            ("subpixel", self.subpixel.is_some()),
            ("gap", self.gap.is_some()),
            ("thickness", self.thickness.is_some()),
            ("jump", self.jump.is_some()),
            ("direction", self.direction.is_some()),
        ];
        given.into_iter().find(|(_, given)| *given).map(|(setting, _)| setting)
    }

    fn apply_to_views(
        &self,
        options: &mut DissertationOptions,
        unit: LengthUnit,
    ) -> Result<(), WorkflowError> {
        options.subpixel = self.subpixel.unwrap_or(options.subpixel);
        options.gap = pixels("gap", self.gap, options.gap)?;
        options.thickness = pixels("thickness", self.thickness, options.thickness)?;
        options.direction = self.direction.unwrap_or(options.direction);
        options.jump = match self.jump {
            None => options.jump,
            Some(JumpSetting::Incidence) => JumpTest::default(),
            Some(JumpSetting::Printed(length)) => {
                JumpTest::Printed { threshold: printed_threshold(length.in_unit(unit))? }
            }
        };
        Ok(())
    }
}

fn pixels(setting: &'static str, given: Option<usize>, own: usize) -> Result<usize, WorkflowError> {
    match given {
        Some(count) if count > MOST_PIXELS => {
            let problem = format!("{count} pixels; at most {MOST_PIXELS} can be set");
            Err(WorkflowError::setting(setting, problem))
        }
        given => Ok(given.unwrap_or(own)),
    }
}

fn printed_threshold(length: f64) -> Result<f64, WorkflowError> {
    let problem = "expected \"incidence\", or a positive length such as 5cm";
    if length > 0.0 { Ok(length) } else { Err(WorkflowError::setting("jump", problem)) }
}

/// Tolerances that follow from a threshold, as [`OverlapTolerance::within`] states them.
fn tolerance(threshold: f64) -> Result<OverlapTolerance, WorkflowError> {
    let problem = "expected a positive length such as 2mm";
    let positive = (threshold > 0.0).then_some(threshold);
    let positive = positive.ok_or_else(|| WorkflowError::setting("threshold", problem))?;
    OverlapTolerance::within(positive).map_err(|e| WorkflowError::setting("threshold", e))
}

fn misplaced(setting: &'static str, wanted: &str, used: &str) -> WorkflowError {
    let problem = format!(
        "this setting belongs to {wanted}, and this run uses {used}; add {wanted}, or leave out \
         the setting `{setting}`"
    );
    WorkflowError::setting(setting, problem)
}
