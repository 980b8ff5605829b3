//! Lengths in settings: texts with a unit, or bare numbers in the scan's unit.

use crate::WorkflowError;
use transect_geometry::LengthUnit;

/// A length in the model's unit from the text of a setting.
///
/// # Errors
/// [`WorkflowError::Setting`] if the text is no length.
pub fn parse_length(
    unit: LengthUnit,
    setting: &'static str,
    text: &str,
) -> Result<f64, WorkflowError> {
    unit.parse_length(text).map_err(|e| WorkflowError::setting(setting, e))
}

/// A length of 0 or more in the model's unit from the text of a setting.
///
/// # Errors
/// [`WorkflowError::Setting`] if the text is no length, or the length is below 0.
pub fn parse_distance(
    unit: LengthUnit,
    setting: &'static str,
    text: &str,
) -> Result<f64, WorkflowError> {
    let length = parse_length(unit, setting, text)?;
    if length < 0.0 {
        let problem = format!("{text} is below 0; expected a length of 0 or more");
        return Err(WorkflowError::setting(setting, problem));
    }
    Ok(length)
}
