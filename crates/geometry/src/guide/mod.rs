//! The guide curve that section planes are perpendicular to (dissertation, section 2.4).

mod curved;
mod family;
mod path;
mod path_point;
mod reach;
mod rounded;
mod spline;
mod transport;

pub use curved::{CurvedGuide, GuideKind, MAX_GUIDE_POINTS, NoStation};
pub use family::{PlaneFamily, PlaneIndex};

use crate::{Point3, Vector3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Errors of a guide or a plane family.
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
    /// A curved guide has fewer than two points or more than [`MAX_GUIDE_POINTS`].
    #[error("a guide has {0} points; it needs 2 to {MAX_GUIDE_POINTS}")]
    PointCount(usize),
    /// A coordinate of a guide's point is NaN, infinite or absurdly large.
    #[error(
        "point {point} of the guide (from 0) is at ({}, {}, {}); coordinates must be numbers \
         within 1e150 of 0. Correct the point, or remove it",
        at.x, at.y, at.z
    )]
    NotFinite {
        /// The number of the point, from 0.
        point: usize,
        /// The point, in the model's length unit.
        at: Point3,
    },
    /// A point of a guide is at the place of the one before it, to within rounding.
    #[error(
        "point {point} of the guide (from 0), at ({}, {}, {}), repeats the one before it; remove \
         one of the two",
        at.x, at.y, at.z
    )]
    Repeated {
        /// The number of the point, from 0.
        point: usize,
        /// The point, in the model's length unit.
        at: Point3,
    },
    /// The guide turns back on itself, so that its points have two stations.
    #[error(
        "the guide turns back on itself at point {point} (from 0), at ({}, {}, {}): places there \
         would have two stations. Check the order of its points, and correct or remove this one",
        at.x, at.y, at.z
    )]
    TurnsBack {
        /// The number of the point, from 0.
        point: usize,
        /// The point, in the model's length unit.
        at: Point3,
    },
    /// The guide ends where it begins, so that places near its ends have two stations.
    #[error(
        "the guide ends where it begins, {gap} from its first point: places there would have two \
         stations. Closed guides are not supported; end it earlier, or make two guides of it"
    )]
    Closed {
        /// Distance between its ends, in the model's length unit.
        gap: f64,
    },
    /// The radius for a polyline's corners is not positive.
    #[error("the radius of the guide's corners must be a positive length, got {0}")]
    BadRadius(f64),
    /// Planes cross too near to the guide for the required distance.
    #[error(
        "planes along the guide cross {reach} away from it at station {station}. Up to {usable} \
         (0.9 of that) can be used, and {needed} is needed. Let the guide bend less sharply there, \
         keep its parts farther apart, or ask for a smaller distance"
    )]
    TooCurved {
        /// The station, in the model's length unit.
        station: f64,
        /// Distance from the guide at which planes cross, in the model's length unit.
        reach: f64,
        /// Distance up to which points have stations, in the model's length unit.
        usable: f64,
        /// Required distance, in the model's length unit.
        needed: f64,
    },
}

/// Largest departure from 1 of the length of a direction after it is divided by its length.
/// Theory: six roundings of half a unit each.
const ROUNDING: f64 = 3.0 * f64::EPSILON;

/// Length below which a direction is scaled before its squares are added up, and above whose
/// inverse too. Theory: squares keep all their digits down to 1e-146. Doubled, nothing changes.
const SHORT: f64 = 1e-100;

/// A straight guide: the line through the origin of the world along a unit direction.
///
/// The station of a point is its signed distance along that line, so the plane at station `s` is
/// `direction · p = s`, as in scan manifests.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct StraightGuide {
    direction: Vector3,
}

/// A straight guide as a file states it.
#[derive(Deserialize)]
#[serde(rename = "StraightGuide")]
struct Unchecked {
    direction: Vector3,
}

impl TryFrom<Unchecked> for StraightGuide {
    type Error = GuideError;

    fn try_from(Unchecked { direction }: Unchecked) -> Result<Self, GuideError> {
        Self::along(direction)
    }
}

impl StraightGuide {
    /// The guide along a direction of any positive length. A unit direction stays as it is, bit
    /// for bit, so that planes that were stored are those that are read.
    ///
    /// # Errors
    /// [`GuideError::NoDirection`] if it is zero or not finite.
    pub fn along(direction: Vector3) -> Result<Self, GuideError> {
        let length = direction.norm();
        if (length - 1.0).abs() <= ROUNDING {
            return Ok(Self { direction });
        }
        // The squares of very short and of very long directions are no numbers.
        let is_usual = (SHORT..SHORT.recip()).contains(&length);
        let scaled = if is_usual { direction } else { direction / direction.amax() };
        let length = scaled.norm();
        if length.is_finite() && length > 0.0 {
            Ok(Self { direction: scaled / length })
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

/// A guide of either kind; cloning it is cheap.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Guide {
    /// A line, without ends.
    Straight(StraightGuide),
    /// A curve, with a first and a last station.
    Curved(Arc<CurvedGuide>),
}

impl Guide {
    /// The guide as a line; `None` if it is curved.
    pub fn straight(&self) -> Option<&StraightGuide> {
        match self {
            Self::Straight(guide) => Some(guide),
            Self::Curved(_) => None,
        }
    }

    /// The guide as a curve; `None` if it is a line.
    pub fn curved(&self) -> Option<&Arc<CurvedGuide>> {
        match self {
            Self::Straight(_) => None,
            Self::Curved(guide) => Some(guide),
        }
    }

    /// Arc length along the guide at the point of it nearest to `in_world`; `None` beyond the ends
    /// of a curved guide and farther from it than [`CurvedGuide::usable_distance`].
    pub fn station(&self, in_world: &Point3) -> Option<f64> {
        match self {
            Self::Straight(guide) => Some(guide.station(in_world)),
            Self::Curved(guide) => guide.station(in_world, None).ok(),
        }
    }

    /// Distance from the guide up to which points have stations, in the model's length unit;
    /// infinite for a line.
    pub fn usable_distance(&self) -> f64 {
        self.curved().map_or(f64::INFINITY, |guide| guide.usable_distance())
    }

    /// Unit direction of the guide at a station.
    pub fn direction(&self, station: f64) -> Vector3 {
        match self {
            Self::Straight(guide) => guide.direction(),
            Self::Curved(guide) => guide.frame(station).normal(),
        }
    }
}

impl From<StraightGuide> for Guide {
    fn from(guide: StraightGuide) -> Self {
        Self::Straight(guide)
    }
}

impl From<&Guide> for Guide {
    fn from(guide: &Guide) -> Self {
        guide.clone()
    }
}

impl From<CurvedGuide> for Guide {
    fn from(guide: CurvedGuide) -> Self {
        Self::Curved(Arc::new(guide))
    }
}

impl From<Arc<CurvedGuide>> for Guide {
    fn from(guide: Arc<CurvedGuide>) -> Self {
        Self::Curved(guide)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn directions_of_any_length_are_directions() {
        for length in [5e-324, 1e-200, 1e-3, 1e200, f64::MAX] {
            let guide = StraightGuide::along(Vector3::new(0.0, -length, 0.0)).unwrap();
            assert_eq!(guide.direction(), -Vector3::y(), "{length}");
        }
        let guide = StraightGuide::along(Vector3::new(3e-200, 0.0, 4e-200)).unwrap();
        assert!((guide.direction() - Vector3::new(0.6, 0.0, 0.8)).norm() < 1e-15);
        for wrong in [f64::NAN, f64::INFINITY, 0.0] {
            assert!(StraightGuide::along(Vector3::new(wrong, 0.0, 0.0)).is_err(), "{wrong}");
        }
    }

    proptest! {
        #[test]
        fn a_unit_direction_stays_as_it_is(
            x in -1.0..1.0f64, y in -1.0..1.0f64, z in -1.0..1.0f64, length in 1e-3..1e3f64,
        ) {
            let Ok(guide) = StraightGuide::along(Vector3::new(x, y, z) * length) else {
                return Ok(());
            };
            prop_assert!((guide.direction().norm() - 1.0).abs() < 1e-15);
            prop_assert_eq!(StraightGuide::along(guide.direction()).unwrap(), guide);
        }
    }
}
