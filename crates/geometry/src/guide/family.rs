//! Equally spaced section planes along a guide.

use super::{CurvedGuide, Guide, GuideError, StraightGuide};
use crate::{PlaneFrame, Point3};
use serde::{Deserialize, Serialize};

/// Number of a section plane; plane `k` is at station `offset + k · interval`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct PlaneIndex(pub i64);

impl std::fmt::Display for PlaneIndex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

/// Equally spaced section planes perpendicular to a guide.
///
/// Along a straight guide, plane `k` is `direction · p = offset + k · interval` with a unit
/// direction (errata to 3.4.1), and all planes share one orientation of their in-plane axes. Along
/// a curved one, plane `k` is perpendicular to the curve at station `offset + k · interval` from
/// its first point; axes are carried along it without turning ([`CurvedGuide::frame`]).
///
/// ```
/// use transect_geometry::{PlaneFamily, PlaneIndex, Point3, StraightGuide, Vector3};
///
/// // Horizontal planes every 0.5 m, the first one 0.1 m above the origin.
/// let planes = PlaneFamily::new(StraightGuide::along(Vector3::z())?, 0.1, 0.5)?;
/// assert_eq!(planes.station(PlaneIndex(3)), 1.6);
/// let point = Point3::new(7.0, -2.0, 1.6);
/// assert!((planes.level(&point) - 3.0).abs() < 1e-12);
/// let frame = planes.frame(PlaneIndex(3));
/// assert_eq!(frame.plane_from_world(&point).coords.as_slice(), [7.0, -2.0]);
/// # Ok::<(), transect_geometry::GuideError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct PlaneFamily {
    guide: Guide,
    /// Station of plane 0, in the model's length unit.
    offset: f64,
    /// Distance from each plane to the next along the guide, in the model's length unit.
    interval: f64,
}

/// A family as a file states it.
#[derive(Deserialize)]
#[serde(rename = "PlaneFamily")]
struct Unchecked {
    guide: Guide,
    offset: f64,
    interval: f64,
}

impl TryFrom<Unchecked> for PlaneFamily {
    type Error = GuideError;

    fn try_from(Unchecked { guide, offset, interval }: Unchecked) -> Result<Self, GuideError> {
        Self::new(guide, offset, interval)
    }
}

/// Least part of an interval by which a point on a plane may be off it through rounding. Chosen by
/// hand, above the rounding of the division and far below any measurement. Doubled, nothing
/// changes.
const LEAST_ROUNDING: f64 = 1e-9;

/// Largest part of an interval that counts as rounding. Chosen by hand: from half an interval on,
/// rounding decides which plane is the nearest. Doubled, this limit is reached.
const MOST_ROUNDING: f64 = 0.25;

/// Rounding of a station as a share of the coordinates that it is computed from. No unit. Theory:
/// the products and sums of a dot product and of `offset + k · interval` are eight roundings of up
/// to half a unit of the last place (`f64::EPSILON`) each; twice that is allowed. Doubled, points
/// that are off a plane by 2e-8 m count as on it on national grids; nothing else changes.
const ROUNDINGS: f64 = 8.0 * f64::EPSILON;

impl PlaneFamily {
    /// Planes every `interval` along the guide, plane 0 at station `offset`.
    ///
    /// # Errors
    /// [`GuideError::BadInterval`] unless `interval` is positive and finite,
    /// [`GuideError::BadOffset`] unless `offset` is finite.
    pub fn new(guide: impl Into<Guide>, offset: f64, interval: f64) -> Result<Self, GuideError> {
        if !(interval.is_finite() && interval > 0.0) {
            return Err(GuideError::BadInterval(interval));
        }
        if !offset.is_finite() {
            return Err(GuideError::BadOffset(offset));
        }
        Ok(Self { guide: guide.into(), offset, interval })
    }

    /// The guide that the planes are perpendicular to.
    pub fn guide(&self) -> &Guide {
        &self.guide
    }

    /// Distance between neighbouring planes along the guide, in the model's length unit.
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

    /// Level of a point: its station over that of plane 0, in intervals. Plane `k` is crossed at
    /// level `k`. NaN for points without a station, see [`Guide::station`].
    pub fn level(&self, in_world: &Point3) -> f64 {
        (self.guide.station(in_world).unwrap_or(f64::NAN) - self.offset) / self.interval
    }

    /// The local frame of a plane; its origin is where the guide meets the plane.
    ///
    /// A curved guide continues straight beyond its ends; [`PlaneFamily::ends`] gives its planes.
    pub fn frame(&self, plane: PlaneIndex) -> PlaneFrame {
        let station = self.station(plane);
        match &self.guide {
            Guide::Straight(guide) => straight_frame(guide, station),
            Guide::Curved(guide) => guide.frame(station),
        }
    }

    /// Part of an interval by which a point on a plane may be off it through rounding: at least
    /// 1e-9, at most 0.25. It grows with the size of the coordinates over the interval.
    ///
    /// `size` is the largest absolute value that the level is computed from, such as a coordinate
    /// or a station, in the model's length unit.
    pub fn rounding(&self, size: f64) -> f64 {
        let share = ROUNDINGS * (size + self.offset.abs()) / self.interval;
        share.clamp(LEAST_ROUNDING, MOST_ROUNDING)
    }

    /// First plane whose station is at least `station`, to within [`PlaneFamily::rounding`].
    pub fn first_at_or_above(&self, station: f64) -> PlaneIndex {
        self.first_from(station, station.abs())
    }

    /// As [`PlaneFamily::first_at_or_above`], for a station that is computed from values up to
    /// `size`.
    fn first_from(&self, station: f64, size: f64) -> PlaneIndex {
        PlaneIndex(((station - self.offset) / self.interval - self.rounding(size)).ceil() as i64)
    }

    /// First and last plane on a curved guide. The second is below the first if no plane lies
    /// between its ends. `None` for a straight guide, which has no ends.
    pub fn ends(&self) -> Option<(PlaneIndex, PlaneIndex)> {
        let guide: &CurvedGuide = self.guide.curved()?;
        // The guide's length rounds as its coordinates do.
        let size = guide.size().max(guide.length());
        let first = self.first_from(0.0, size);
        // The mirror image of the first plane, so that both ends are treated alike.
        let last = (guide.length() - self.offset) / self.interval + self.rounding(size);
        Some((first, PlaneIndex(last.floor() as i64)))
    }
}

fn straight_frame(guide: &StraightGuide, station: f64) -> PlaneFrame {
    let normal = guide.direction();
    let origin = Point3::from(normal * station);
    // The guide's direction has unit length, so the frame always exists.
    PlaneFrame::new(Point3::origin(), normal).unwrap_or(PlaneFrame::WORLD).moved_to(origin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector3;

    #[test]
    fn planes_lie_where_the_manifest_says() {
        let guide = StraightGuide::along(Vector3::new(0.0, 2.0, 0.0)).unwrap();
        let planes = PlaneFamily::new(guide, 0.05, 0.1).unwrap();
        let frame = planes.frame(PlaneIndex(3));
        assert!((frame.origin() - Point3::new(0.0, 0.35, 0.0)).norm() < 1e-15);
        assert!((planes.level(&Point3::new(7.0, 0.35, -2.0)) - 3.0).abs() < 1e-12);
        assert_eq!(planes.first_at_or_above(0.35), PlaneIndex(3));
        assert_eq!(planes.first_at_or_above(0.351), PlaneIndex(4));
        assert_eq!(planes.ends(), None);
    }

    #[test]
    fn a_curved_guide_has_planes_between_its_ends() {
        let ends = [Point3::new(1.0, 0.0, 0.0), Point3::new(1.0, 2.0, 0.0)];
        let guide = CurvedGuide::polyline(ends.to_vec(), None).unwrap();
        let planes = PlaneFamily::new(guide, 0.1, 0.1).unwrap();
        assert_eq!(planes.ends(), Some((PlaneIndex(-1), PlaneIndex(19))));
        let frame = planes.frame(PlaneIndex(4));
        assert!((frame.origin() - Point3::new(1.0, 0.5, 0.0)).norm() < 1e-12);
        assert!((frame.normal() - Vector3::y()).norm() < 1e-12);
        assert!((planes.level(&Point3::new(1.3, 0.5, -2.0)) - 4.0).abs() < 1e-12);
        assert!(planes.level(&Point3::new(1.3, 2.5, -2.0)).is_nan());
    }

    #[test]
    fn planes_far_from_the_origin_are_found_by_their_stations() {
        // Northings of a national grid: half a unit of the last place is 1e-8 intervals.
        let guide = StraightGuide::along(Vector3::y()).unwrap();
        for offset in [0.0, 5.4e6, 5.4e6 + 0.1] {
            let planes = PlaneFamily::new(guide, offset, 0.05).unwrap();
            let from = ((5.4e6 - offset) / 0.05) as i64;
            for k in (from..from + 2_000).map(PlaneIndex) {
                assert_eq!(planes.first_at_or_above(planes.station(k)), k, "offset {offset}");
                let above = planes.station(k) + 1e-6;
                assert_eq!(planes.first_at_or_above(above).0, k.0 + 1, "offset {offset}");
            }
        }
    }

    #[test]
    fn a_guide_far_from_the_origin_keeps_its_last_plane() {
        // A guide of 10 m in many directions, whose length rounds with its coordinates.
        for k in 0..200 {
            let angle = 0.03 * f64::from(k);
            let start = Point3::new(500_000.1, 5_400_000.3, 80.0);
            let end = start + 10.0 * Vector3::new(angle.cos(), angle.sin(), 0.0);
            let guide = CurvedGuide::polyline(vec![start, end], None).unwrap();
            let planes = PlaneFamily::new(guide, 0.0, 0.05).unwrap();
            assert_eq!(planes.ends(), Some((PlaneIndex(0), PlaneIndex(200))), "{angle}");
        }
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
