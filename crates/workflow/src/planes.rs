//! The plane options that several commands take.

use crate::failure::Failure;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use transect::{Refinement, Setup};
use transect_exchange::{PlanesEntry, Scan, read_guide};
use transect_geometry::{Guide, GuideKind, LengthUnit, PlaneFamily, StraightGuide, Vector3};

/// What the points of a guide file are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum GuideShape {
    /// Corners of straight pieces, rounded by arcs.
    Polyline,
    /// Points that a cubic spline passes through.
    Spline,
}

/// Where the section planes are: plane k is at normal · p = offset + k · interval.
#[derive(Debug, Args)]
#[command(
    next_help_heading = "Section planes (lengths with a unit, such as 1mm; a bare number is in the scan's unit)"
)]
pub struct PlaneArguments {
    /// Normal of the planes in the world, as X,Y,Z of any length [default: the scan's own, else 0,0,1].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    normal: Option<String>,
    /// Curve that the planes are perpendicular to, instead of a normal: .csv, .geojson or .dxf; see docs/guides.md.
    #[arg(long, value_name = "FILE", conflicts_with = "normal")]
    guide: Option<PathBuf>,
    /// What the guide's points are: corners, which are rounded by arcs, or points of a cubic spline.
    #[arg(long, value_enum, default_value_t = GuideShape::Spline, value_name = "KIND")]
    guide_kind: GuideShape,
    /// Largest radius of a polyline's corners [default: as large as there is room for].
    #[arg(long, value_name = "LENGTH", requires = "guide")]
    guide_radius: Option<String>,
    /// Distance from the guide that is to be covered; an error if planes cross within it.
    #[arg(long, value_name = "LENGTH", requires = "guide")]
    guide_reach: Option<String>,
    /// Distance between neighbouring planes [default: the scan's own].
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    interval: Option<String>,
    /// Station of plane 0 [default: the scan's own, else 0].
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    offset: Option<String>,
}

impl PlaneArguments {
    /// Whether the command line says nothing about planes.
    pub fn say_nothing(&self) -> bool {
        self.normal.is_none() && self.interval.is_none() && self.offset.is_none()
    }

    /// The planes of a scan: what the command line says, else what the scan says.
    pub fn family(&self, scan: &Scan) -> Result<PlaneFamily, Failure> {
        let own = scan.planes.as_ref();
        let guide = self.guide(scan)?;
        let interval = match (&self.interval, own) {
            (Some(text), _) => parse_length(scan.unit, "--interval", text)?,
            (None, Some(own)) => own.interval,
            (None, None) => {
                let reason = "the scan does not say how far apart the planes are; pass --interval, such as --interval 10mm";
                return Err(Failure::Usage(reason.into()));
            }
        };
        let offset = match &self.offset {
            Some(text) => parse_length(scan.unit, "--offset", text)?,
            None => own.map_or(0.0, |p| p.offset),
        };
        PlaneFamily::new(guide, offset, interval).map_err(|e| Failure::Usage(e.to_string()))
    }

    /// The guide: what the command line says, else what the scan says, else upright.
    fn guide(&self, scan: &Scan) -> Result<Guide, Failure> {
        if let Some(path) = &self.guide {
            return self.curve(scan.unit, path);
        }
        let own = scan.planes.as_ref();
        let normal = match (&self.normal, own) {
            (Some(text), _) => parse_vector(text)?,
            (None, Some(PlanesEntry { guide: Some(guide), .. })) => {
                return Ok(guide.clone().into());
            }
            (None, own) => own.map_or(Vector3::z(), |p| Vector3::from(p.normal)),
        };
        let guide = StraightGuide::along(normal).map_err(|e| Failure::Usage(e.to_string()))?;
        Ok(guide.into())
    }

    /// The guide of a file.
    fn curve(&self, unit: LengthUnit, path: &Path) -> Result<Guide, Failure> {
        let length = |argument: &str, text: &Option<String>| {
            text.as_ref().map(|text| parse_length(unit, argument, text)).transpose()
        };
        let radius = length("--guide-radius", &self.guide_radius)?;
        let kind = match self.guide_kind {
            GuideShape::Polyline => GuideKind::Polyline(radius),
            GuideShape::Spline if radius.is_some() => {
                let problem = "--guide-radius is for --guide-kind polyline";
                return Err(Failure::Usage(problem.to_owned()));
            }
            GuideShape::Spline => GuideKind::Spline,
        };
        let guide = read_guide(path, kind)?;
        if let Some(reach) = length("--guide-reach", &self.guide_reach)? {
            guide.require_reach(reach).map_err(|e| Failure::with_file(path, e))?;
        }
        Ok(guide.into())
    }
}

/// A tolerance and, behind a comma, the smallest interval; without it a sixteenth of the interval.
pub fn parse_refinement(setup: &Setup, text: &str) -> Result<Refinement, Failure> {
    let length = |text: &str| parse_length(setup.unit, "--refine", text.trim());
    let refinement = match text.split_once(',') {
        None => Refinement::new(length(text)?, Refinement::DEFAULT_LEVELS),
        Some((tolerance, least)) => {
            Refinement::down_to(length(tolerance)?, setup.planes.interval(), length(least)?)
        }
    };
    refinement.map_err(|e| Failure::Usage(format!("--refine: {e} (in {})", setup.unit)))
}

/// A length in the model's unit from an argument.
pub fn parse_length(unit: LengthUnit, argument: &str, text: &str) -> Result<f64, Failure> {
    unit.parse_length(text).map_err(|e| Failure::Usage(format!("{argument}: {e}")))
}

/// Three numbers with commas between them.
pub fn parse_vector(text: &str) -> Result<Vector3, Failure> {
    let numbers: Vec<f64> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    match (numbers.as_slice(), text.split(',').count()) {
        (&[x, y, z], 3) => Ok(Vector3::new(x, y, z)),
        _ => Err(Failure::Usage(format!("--normal {text}: write three numbers, such as 0,0,1"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_three_numbers() {
        assert!(matches!(parse_vector("0,-1, 0.5"), Ok(v) if v == Vector3::new(0.0, -1.0, 0.5)));
        for bad in ["", "1,2", "1,2,3,4", "1,x,3"] {
            assert!(matches!(parse_vector(bad), Err(Failure::Usage(_))), "{bad}");
        }
    }
}
