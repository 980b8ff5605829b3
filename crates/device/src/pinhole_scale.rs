//! The length that each pixel of a depth camera holds.

use crate::{Point3, RangeImage, Vector3, View};
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
    pub fn per_value(self, direction: Vector3) -> Vector3 {
        match self {
            Self::Depth => direction / direction.z,
            Self::RayLength => direction / direction.norm(),
        }
    }

    /// The value of a point.
    pub fn value(self, p: &Point3) -> f64 {
        match self {
            Self::Depth => p.z,
            Self::RayLength => p.coords.norm(),
        }
    }

    /// The view of an image that holds this length and was read as the other one. `None` unless the
    /// sensor of the view is a camera whose images hold the other one.
    pub fn reread(self, view: &View) -> Option<View> {
        let (frame, image) = (view.frame(), view.image());
        frame.pinhole_scale().filter(|scale| *scale != self)?;
        let value = |pixel| {
            let value = f64::from(image.get(pixel)?);
            // A point at this value lies too far out, or too near, by a factor along its ray.
            Some((value * value / self.value(&frame.point(pixel, value)?)) as f32)
        };
        let size = image.size();
        let values = size.all_pixels().map(|pixel| value(pixel).unwrap_or(f32::NAN)).collect();
        view.with_image(RangeImage::from_values(size, values).ok()?).ok()
    }
}

impl fmt::Display for PinholeScale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
