//! The length that each pixel of a depth camera holds.

use crate::{Point3, Vector3};
use serde::{Deserialize, Serialize};
use std::fmt;

/// The meaning of a camera's values.
///
/// Nothing in an image tells its meaning: the surfaces that it shares with other views do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PinholeScale {
    /// Depth along the optical axis z.
    #[default]
    Depth,
    /// Distance from the camera, along the ray.
    RayLength,
}

impl PinholeScale {
    /// Every meaning.
    pub const ALL: [Self; 2] = [Self::Depth, Self::RayLength];

    /// The name by which options, reports and `scan.json` call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::RayLength => "ray_length",
        }
    }

    /// The assumption of the meaning about the images, as a sentence without a full stop.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Depth => "the images hold depths along the optical axis, not lengths of rays",
            Self::RayLength => "the images hold lengths of rays, not depths along the optical axis",
        }
    }

    /// The direction scaled so that the value times it is the point.
    #[inline]
    pub fn per_value(self, direction: Vector3) -> Vector3 {
        match self {
            Self::Depth => direction / direction.z,
            Self::RayLength => direction / direction.norm(),
        }
    }

    /// The value of a point.
    #[inline]
    pub fn value(self, p: &Point3) -> f64 {
        match self {
            Self::Depth => p.z,
            Self::RayLength => p.coords.norm(),
        }
    }
}

impl fmt::Display for PinholeScale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
