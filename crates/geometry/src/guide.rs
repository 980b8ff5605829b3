//! The guide curve and the family of section planes along it (dissertation, section 2.4).

use crate::{PlaneFrame, Point3, Vector3};
use serde::{Deserialize, Serialize};

/// Number of a section plane; plane `k` is at station `offset + k · interval`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct PlaneIndex(pub i64);

impl std::fmt::Display for PlaneIndex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

/// What can be wrong with a guide or a plane family.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GuideError {
    /// The normal is zero, or one of its components is NaN or infinite.
    #[error("the plane normal ({0}, {1}, {2}) has no direction")]
    NoDirection(f64, f64, f64),
    /// The interval is zero, negative, NaN or infinite.
    #[error("the plane interval must be a positive length, got {0}")]
    BadInterval(f64),
    /// The offset is NaN or infinite.
    #[error("the plane offset must be a finite length, got {0}")]
    BadOffset(f64),
}

/// A straight guide: the line through the world's origin along a unit direction.
///
/// The station of a point is its signed distance along that line, so that the plane at station `s`
/// is `direction · p = s`, which is how scan manifests give planes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StraightGuide {
    direction: Vector3,
}

impl StraightGuide {
    /// The guide along a direction of any positive length.
    ///
    /// # Errors
    /// [`GuideError::NoDirection`] if it is zero or not finite.
    pub fn along(direction: Vector3) -> Result<Self, GuideError> {
        let length = direction.norm();
        if length.is_finite() && length > 0.0 {
            Ok(Self { direction: direction / length })
        } else {
            Err(GuideError::NoDirection(direction.x, direction.y, direction.z))
        }
    }

    /// Unit direction of the guide, which is the normal of every section plane.
    pub fn direction(&self) -> Vector3 {
        self.direction
    }

    /// Arc length along the guide at the point of it nearest to `in_world`.
    pub fn station(&self, in_world: &Point3) -> f64 {
        self.direction.dot(&in_world.coords)
    }
}

/// Equally spaced section planes perpendicular to a guide.
///
/// Plane `k` is `direction · p = offset + k · interval` with a unit direction (errata to 3.4.1).
/// All planes of a straight guide share one orientation of their in-plane axes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PlaneFamily {
    guide: StraightGuide,
    /// Station of plane 0, in the model's length unit.
    offset: f64,
    /// Distance from each plane to the next, in the model's length unit.
    interval: f64,
}

impl PlaneFamily {
    /// Planes every `interval` along the guide, plane 0 at station `offset`.
    ///
    /// # Errors
    /// [`GuideError::BadInterval`] unless `interval` is positive and finite,
    /// [`GuideError::BadOffset`] unless `offset` is finite.
    pub fn new(guide: StraightGuide, offset: f64, interval: f64) -> Result<Self, GuideError> {
        if !(interval.is_finite() && interval > 0.0) {
            return Err(GuideError::BadInterval(interval));
        }
        if !offset.is_finite() {
            return Err(GuideError::BadOffset(offset));
        }
        Ok(Self { guide, offset, interval })
    }

    /// The guide that the planes are perpendicular to.
    pub fn guide(&self) -> StraightGuide {
        self.guide
    }

    /// Distance between neighbouring planes, in the model's length unit.
    pub fn interval(&self) -> f64 {
        self.interval
    }

    /// Station of plane 0, in the model's length unit.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// Station of a plane, in the model's length unit.
    pub fn station(&self, plane: PlaneIndex) -> f64 {
        self.offset + plane.0 as f64 * self.interval
    }

    /// Level of a point: its height over plane 0 in intervals. Plane `k` is crossed at level `k`.
    pub fn level(&self, in_world: &Point3) -> f64 {
        (self.guide.station(in_world) - self.offset) / self.interval
    }

    /// The local frame of a plane; its origin is where the guide meets the plane.
    pub fn frame(&self, plane: PlaneIndex) -> PlaneFrame {
        let normal = self.guide.direction;
        let origin = Point3::from(normal * self.station(plane));
        // The guide's direction has unit length by construction, so the frame always exists.
        PlaneFrame::new(Point3::origin(), normal).unwrap_or(PlaneFrame::WORLD).moved_to(origin)
    }

    /// First plane whose station is at least `station`.
    pub fn first_at_or_above(&self, station: f64) -> PlaneIndex {
        // A plane meant to lie at the bound must not be lost to the rounding of the division.
        const ROUNDING: f64 = 1e-9;
        PlaneIndex(((station - self.offset) / self.interval - ROUNDING).ceil() as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_lie_where_the_manifest_says() {
        let guide = StraightGuide::along(Vector3::new(0.0, 2.0, 0.0)).unwrap();
        let planes = PlaneFamily::new(guide, 0.05, 0.1).unwrap();
        let frame = planes.frame(PlaneIndex(3));
        assert!((frame.origin() - Point3::new(0.0, 0.35, 0.0)).norm() < 1e-15);
        assert!((planes.level(&Point3::new(7.0, 0.35, -2.0)) - 3.0).abs() < 1e-12);
        assert_eq!(planes.first_at_or_above(0.35), PlaneIndex(3));
        assert_eq!(planes.first_at_or_above(0.351), PlaneIndex(4));
    }

    #[test]
    fn bad_families_are_refused_with_the_value() {
        let guide = StraightGuide::along(Vector3::z()).unwrap();
        let zero = PlaneFamily::new(guide, 0.0, 0.0).unwrap_err();
        assert_eq!(zero.to_string(), "the plane interval must be a positive length, got 0");
        assert!(PlaneFamily::new(guide, 0.0, -1.0).is_err());
        assert!(PlaneFamily::new(guide, 0.0, f64::NAN).is_err());
        assert!(PlaneFamily::new(guide, f64::INFINITY, 1.0).is_err());
        assert!(StraightGuide::along(Vector3::zeros()).is_err());
    }
}
