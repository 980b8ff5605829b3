//! The plane options that several commands take.

use crate::failure::Failure;
use clap::Args;
use transect_exchange::Scan;
use transect_geometry::{LengthUnit, PlaneFamily, StraightGuide, Vector3};

/// Where the section planes are: plane k is at normal · p = offset + k · interval.
#[derive(Debug, Args)]
#[command(
    next_help_heading = "Section planes (lengths with a unit, such as 1mm; a bare number is in the scan's unit)"
)]
pub struct PlaneArguments {
    /// Normal of the planes in the world, as X,Y,Z of any length [default: the scan's own, else 0,0,1].
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    normal: Option<String>,
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
        let normal = match &self.normal {
            Some(text) => parse_vector(text)?,
            None => own.map_or(Vector3::z(), |p| Vector3::from(p.normal)),
        };
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
        let family =
            StraightGuide::along(normal).and_then(|g| PlaneFamily::new(g, offset, interval));
        family.map_err(|e| Failure::Usage(e.to_string()))
    }
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
