//! What a view says about its sensor: one module per sensor whose keys need more than four numbers.

mod light_stripe;
mod lookup_table;
mod pinhole;
#[cfg(test)]
mod tests;

pub use light_stripe::{AnglesEntry, LightStripeEntry, StripeEntry};
pub use lookup_table::{LookupTableEntry, ViewpointsEntry};
pub use pinhole::{LensEntry, PinholeEntry};

use super::keys::Keys;
use crate::ReadError;
use serde::Serialize;
use transect_sensors::{Intrinsics, PinholeScale};

/// The sensors a manifest can name.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "sensor", rename_all = "snake_case")]
#[non_exhaustive]
pub enum SensorEntry {
    /// Two angles, in radians, and a range.
    Spherical {
        /// Azimuth of column 0.
        theta0: f64,
        /// Azimuth from one column to the next.
        dtheta: f64,
        /// Elevation of row 0.
        phi0: f64,
        /// Elevation from one row to the next.
        dphi: f64,
    },
    /// A depth camera.
    Pinhole(PinholeEntry),
    /// A laser sheet turned by a mirror and watched by a camera.
    LightStripe(LightStripeEntry),
    /// A calibrated scanner on a linear axis.
    LookupTable(LookupTableEntry),
    /// An organised grid of points.
    Grid {
        /// Where all rays start, in the sensor frame and the length unit.
        viewpoint: [f64; 3],
    },
}

impl SensorEntry {
    /// A depth camera without lens distortion whose pixels hold depths.
    pub fn pinhole(intrinsics: Intrinsics) -> Self {
        let Intrinsics { fx, fy, cx, cy } = intrinsics;
        let lens = LensEntry::Intrinsics { fx, fy, cx, cy, distortion: None };
        Self::Pinhole(PinholeEntry { lens, holds: PinholeScale::Depth })
    }

    /// The sensor of a view; `notes` takes what nobody asked for inside its keys.
    pub(super) fn read(keys: &Keys<'_>, notes: &mut Vec<String>) -> Result<Self, ReadError> {
        let known = "one of spherical, pinhole, light_stripe, lookup_table, grid";
        let number = |key| keys.required_number(key);
        match keys.text("sensor")? {
            Some("spherical") => Ok(Self::Spherical {
                theta0: number("theta0")?,
                dtheta: number("dtheta")?,
                phi0: number("phi0")?,
                dphi: number("dphi")?,
            }),
            Some("pinhole") => PinholeEntry::read(keys).map(Self::Pinhole),
            Some("light_stripe") => LightStripeEntry::read(keys, notes).map(Self::LightStripe),
            Some("lookup_table") => LookupTableEntry::read(keys).map(Self::LookupTable),
            Some("grid") => Ok(Self::Grid { viewpoint: keys.required_numbers("viewpoint")? }),
            Some(other) => Err(keys.wrong("sensor", &format!("{known}; it is {other:?}"))),
            None => Err(keys.wrong("sensor", known)),
        }
    }
}
