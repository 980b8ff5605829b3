//! Curve units: the segments between neighbouring nodes (dissertation, sections 2.5.2 and 5.5.1).

use crate::{Envelope, Point2, Vector2};

/// On which side of a curve a point is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Left of the curve's direction: inside the solid.
    Inside,
    /// Right of the curve's direction: outside the solid.
    Outside,
}

/// The segment from one node of a curve to the next, in plane coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveUnit {
    /// Where the unit begins.
    pub start: Point2,
    /// Where the unit ends.
    pub end: Point2,
}

impl CurveUnit {
    /// The displacement from start to end.
    pub fn vector(&self) -> Vector2 {
        self.end - self.start
    }

    /// The smallest rectangle around the unit.
    pub fn envelope(&self) -> Envelope {
        Envelope { min: self.start.inf(&self.end), max: self.start.sup(&self.end) }
    }

    /// The left side of the line equation of section 2.5.2: positive right of start → end.
    ///
    /// `(y₂ − y₁) x + (x₁ − x₂) y + (x₂ y₁ − x₁ y₂)`, written with differences so that world-sized
    /// coordinates keep their precision. Its unit is an area: twice the triangle of the points.
    pub fn line_value(&self, p: &Point2) -> f64 {
        let (u, d) = (self.vector(), p - self.start);
        u.y * d.x - u.x * d.y
    }

    /// The side of the unit's line on which the point is; a point on the line counts as inside.
    pub fn side(&self, p: &Point2) -> Side {
        if self.line_value(p) > 0.0 { Side::Outside } else { Side::Inside }
    }

    /// Position of a point's orthogonal projection along the unit: 0 at start, 1 at end, unclamped.
    ///
    /// A unit without length puts every point at 0.
    pub fn parameter(&self, p: &Point2) -> f64 {
        let u = self.vector();
        let length_squared = u.norm_squared();
        if length_squared > 0.0 { u.dot(&(p - self.start)) / length_squared } else { 0.0 }
    }

    /// The point of the unit at a parameter.
    pub fn at(&self, t: f64) -> Point2 {
        self.start + self.vector() * t
    }

    /// Distance from a point to the unit, in the coordinates' unit.
    pub fn distance(&self, p: &Point2) -> f64 {
        (p - self.at(self.parameter(p).clamp(0.0, 1.0))).norm()
    }
}

/// The point of a curve nearest to a query point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    /// Index of the curve unit that holds it; on a closed curve the last unit returns to node 0.
    pub unit: usize,
    /// Position along that unit, from 0 at its start to 1 at its end.
    pub parameter: f64,
    /// The nearest point itself, in plane coordinates.
    pub point: Point2,
    /// Distance from the query point, in the coordinates' unit.
    pub distance: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_line_equation_is_positive_on_the_right() {
        let unit = CurveUnit { start: Point2::new(1.0, 1.0), end: Point2::new(4.0, 2.0) };
        let printed = |x: f64, y: f64| {
            let (a, b) = (unit.start, unit.end);
            (b.y - a.y) * x + (a.x - b.x) * y + (b.x * a.y - a.x * b.y)
        };
        for p in [Point2::new(3.0, -1.0), Point2::new(0.0, 7.0), Point2::new(2.5, 1.4)] {
            assert!((unit.line_value(&p) - printed(p.x, p.y)).abs() < 1e-12);
        }
        assert_eq!(unit.side(&Point2::new(3.0, 0.0)), Side::Outside);
        assert_eq!(unit.side(&Point2::new(3.0, 3.0)), Side::Inside);
    }

    #[test]
    fn distance_is_to_the_segment_not_to_its_line() {
        let unit = CurveUnit { start: Point2::origin(), end: Point2::new(2.0, 0.0) };
        assert_eq!(unit.distance(&Point2::new(1.0, 3.0)), 3.0);
        assert_eq!(unit.distance(&Point2::new(5.0, 4.0)), 5.0);
        let point = CurveUnit { start: Point2::origin(), end: Point2::origin() };
        assert_eq!(point.distance(&Point2::new(3.0, 4.0)), 5.0);
    }
}
