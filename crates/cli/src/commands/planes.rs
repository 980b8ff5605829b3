//! Options that several commands share: where the section planes are, and accepted input.

use super::lengths::length;
use super::named;
use crate::failure::Failure;
use clap::Args;
use std::path::PathBuf;
use transect_workflow::{Check, GuideSettings, PlaneSettings};

/// Where the section planes are: plane k is at normal · p = offset + k · interval.
#[derive(Debug, Args)]
#[command(
    next_help_heading = "Section planes (lengths with a unit, such as 1mm; a bare number is in the scan's unit)"
)]
pub struct PlaneArguments {
    /// Normal of the planes in the world, as X,Y,Z of any length [default: the scan's own, else
    /// suggested from its points].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    normal: Option<String>,
    /// Curve that the planes are perpendicular to, instead of a normal: .csv, .geojson or .dxf; see
    /// docs/guides.md.
    #[arg(long, value_name = "FILE", conflicts_with = "normal")]
    guide: Option<PathBuf>,
    // clap ignores that an option requires the guide where --normal excludes the guide. Hence the
    // guide's options exclude --normal, too.
    /// What the guide's points are: corners, which are rounded by arcs, or points of a cubic
    /// spline.
    #[arg(long = "guide-kind", action = clap::ArgAction::Set, default_value = "spline",
        value_parser = named([("polyline", true), ("spline", false)]), value_name = "KIND",
        requires = "guide", conflicts_with = "normal")]
    is_polyline: bool,
    /// Largest radius of a polyline's corners [default: as large as there is room for].
    #[arg(long, value_name = "LENGTH", requires = "guide", conflicts_with = "normal")]
    guide_radius: Option<String>,
    /// Distance from the guide that is to be covered; an error if planes cross within it.
    #[arg(long, value_name = "LENGTH", requires = "guide", conflicts_with = "normal")]
    guide_reach: Option<String>,
    /// Distance between neighbouring planes [default: the scan's own, else suggested].
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    interval: Option<String>,
    /// Station of plane 0 [default: the scan's own along its own normal or guide, else suggested
    /// with them, else 0].
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    offset: Option<String>,
}

/// Checks of plausibility that are turned off.
#[derive(Debug, Args)]
pub struct AcceptArguments {
    /// Accept input that a check of plausibility refuses; the check's message has its name.
    #[arg(long, value_name = "CHECK", help_heading = "Running",
        value_parser = named(Check::ALL.map(|check| (check.name(), check))))]
    pub accept: Vec<Check>,
}

impl PlaneArguments {
    /// The settings that the options stand for.
    pub fn settings(&self) -> Result<PlaneSettings, Failure> {
        let mut settings = PlaneSettings::default();
        settings.normal = self.normal.as_deref().map(parse_normal).transpose()?;
        if let Some(path) = &self.guide {
            settings.guide = Some(GuideSettings {
                path: path.clone(),
                polyline: self.is_polyline,
                radius: length("guide-radius", self.guide_radius.as_ref())?,
                reach: length("guide-reach", self.guide_reach.as_ref())?,
            });
        }
        settings.interval = length("interval", self.interval.as_ref())?;
        settings.offset = length("offset", self.offset.as_ref())?;
        Ok(settings)
    }
}

/// Three numbers with commas between them.
pub fn parse_normal(text: &str) -> Result<[f64; 3], Failure> {
    let wrong = || Failure::Usage(format!("--normal {text}: write three numbers, such as 0,0,1"));
    parse_numbers(text).ok_or_else(wrong)
}

/// `N` numbers with commas between them; `None` if they are something else.
pub fn parse_numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers = text.split(',').map(|number| number.trim().parse().ok());
    numbers.collect::<Option<Vec<f64>>>()?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_three_numbers() {
        assert!(matches!(parse_normal("0,-1, 0.5"), Ok([0.0, -1.0, 0.5])));
        for bad in ["", "1,2", "1,2,3,4", "1,x,3"] {
            assert!(matches!(parse_normal(bad), Err(Failure::Usage(_))), "{bad}");
        }
    }
}
