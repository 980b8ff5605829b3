//! Places on a curve in space, for all curved guides.

use crate::{Point3, Vector3};

/// Position and directions of a curve at a station.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PathPoint {
    pub point: Point3,
    /// Unit tangent.
    pub tangent: Vector3,
    /// Change of the tangent per length: towards the centre of curvature, one over its radius long.
    pub bend: Vector3,
}

/// The place of a curve whose perpendicular planes cross nearest to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tightest {
    /// Distance from the curve at which planes cross; infinite if they do not.
    pub radius: f64,
    pub station: f64,
}

impl Tightest {
    /// Of a curve that does not bend.
    pub const NOWHERE: Self = Self { radius: f64::INFINITY, station: 0.0 };

    /// The tighter of two places; the first of equals.
    pub fn or(self, other: Self) -> Self {
        if other.radius < self.radius { other } else { self }
    }
}
