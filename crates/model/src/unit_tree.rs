//! Curve units in an R-tree: the box and the distance that a spatial index needs.

use rstar::{AABB, PointDistance, RTreeObject};
use std::ops::Deref;
use transect_geometry::{CurveUnit, Point2};

/// An entry of a spatial index (`rstar::RTree`) that has a curve unit.
#[derive(Debug, Clone, Copy)]
pub struct InTree<T>(pub T);

impl<T> Deref for InTree<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T: AsRef<CurveUnit>> RTreeObject for InTree<T> {
    type Envelope = AABB<[f64; 2]>;

    fn envelope(&self) -> Self::Envelope {
        let unit = self.0.as_ref();
        AABB::from_corners(unit.start.into(), unit.end.into())
    }
}

impl<T: AsRef<CurveUnit>> PointDistance for InTree<T> {
    fn distance_2(&self, point: &[f64; 2]) -> f64 {
        let distance = self.0.as_ref().distance(&Point2::from(*point));
        // Coordinates near the largest f64 overflow into NaN, which the tree could not sort.
        if distance.is_nan() { f64::INFINITY } else { distance * distance }
    }
}
