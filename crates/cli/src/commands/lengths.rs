//! Lengths on the command line.

use crate::failure::Failure;
use transect_geometry::{Length, LengthUnit};

/// The length of an option, if the option is given. `option` is its name without dashes.
pub fn length(option: &str, text: Option<&String>) -> Result<Option<Length>, Failure> {
    let parse = |text: &String| text.parse();
    text.map(parse).transpose().map_err(|e| Failure::Usage(format!("--{option}: {e}")))
}

/// The same in a model's unit, for lengths of 0 or more.
pub fn distance(
    option: &str,
    text: Option<&String>,
    unit: LengthUnit,
) -> Result<Option<f64>, Failure> {
    let distance = length(option, text)?.map(|length| length.in_unit(unit));
    if let (Some(text), true) = (text, distance < Some(0.0)) {
        let problem = format!("{text} is below 0; expected a length of 0 or more");
        return Err(Failure::Usage(format!("--{option}: {problem}")));
    }
    Ok(distance)
}
