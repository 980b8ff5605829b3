//! Maximum-enclosure envelopes (dissertation, section 5.3.1).

use crate::Point2;
use serde::{Deserialize, Serialize};

/// The axis-aligned rectangle around a curve, or around all curves of a plane.
///
/// Corners in plane coordinates, in the model's length unit; both are part of the rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Envelope {
    /// Corner of the smallest coordinates.
    pub min: Point2,
    /// Corner of the largest coordinates.
    pub max: Point2,
}

impl Envelope {
    /// The smallest envelope around some points; `None` without points.
    pub fn around<'a>(points: impl IntoIterator<Item = &'a Point2>) -> Option<Self> {
        let mut points = points.into_iter();
        let first = *points.next()?;
        let start = Self { min: first, max: first };
        Some(points.fold(start, |e, p| Self { min: e.min.inf(p), max: e.max.sup(p) }))
    }

    /// The smallest envelope around both.
    #[must_use]
    pub fn merged(&self, other: &Self) -> Self {
        Self { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// The envelope pushed outwards by a tolerance on all four sides.
    #[must_use]
    pub fn grown(&self, tolerance: f64) -> Self {
        let by = crate::Vector2::repeat(tolerance);
        Self { min: self.min - by, max: self.max + by }
    }

    /// Whether the two rectangles share a point; touching counts.
    pub fn intersects(&self, other: &Self) -> bool {
        self.intersection(other).is_some()
    }

    /// The common rectangle, which limits the search for overlaps (section 5.3.2).
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let both = Self { min: self.min.sup(&other.min), max: self.max.inf(&other.max) };
        (both.min.x <= both.max.x && both.min.y <= both.max.y).then_some(both)
    }

    /// Whether the rectangle holds the point; its border counts.
    pub fn contains(&self, p: &Point2) -> bool {
        self.min.x <= p.x && p.x <= self.max.x && self.min.y <= p.y && p.y <= self.max.y
    }

    /// Width and height.
    pub fn size(&self) -> crate::Vector2 {
        self.max - self.min
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Envelope {
        Envelope { min: Point2::new(x0, y0), max: Point2::new(x1, y1) }
    }

    #[test]
    fn common_rectangle_of_the_three_patterns() {
        // Corner overlap, side overlap, and one within the other (Figure 5.3).
        let h1 = rectangle(0.0, 0.0, 4.0, 4.0);
        assert_eq!(
            h1.intersection(&rectangle(3.0, 3.0, 6.0, 6.0)),
            Some(rectangle(3.0, 3.0, 4.0, 4.0))
        );
        assert_eq!(
            h1.intersection(&rectangle(3.0, 1.0, 6.0, 2.0)),
            Some(rectangle(3.0, 1.0, 4.0, 2.0))
        );
        let inner = rectangle(1.0, 1.0, 2.0, 2.0);
        assert_eq!(h1.intersection(&inner), Some(inner));
        assert!(!h1.intersects(&rectangle(4.1, 0.0, 5.0, 1.0)));
        assert!(h1.grown(0.1).intersects(&rectangle(4.1, 0.0, 5.0, 1.0)));
    }

    #[test]
    fn envelope_is_the_tightest_around_points() {
        let points = [Point2::new(1.0, -2.0), Point2::new(-3.0, 5.0), Point2::new(0.0, 0.0)];
        assert_eq!(Envelope::around(&points), Some(rectangle(-3.0, -2.0, 1.0, 5.0)));
        assert_eq!(Envelope::around(&[]), None);
    }
}
