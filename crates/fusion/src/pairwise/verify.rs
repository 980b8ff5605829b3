//! Whether an estimated overlap is one, and which curve is the basis (dissertation 5.5.1).
//!
//! **Problem.** Envelopes and patterns say that two curves may overlap. Before they are merged, a
//! point of one must be seen to lie beside the other.
//!
//! **Idea.** If the orthogonal projection of the first point of one curve lies within a unit of the
//! other, the point must be near enough. Then the first is the *distant* curve and the second the
//! *basis* curve (Figure 5.8).
//!
//! **Steps.**
//! 1. Take one curve as basis. In the frame of each of its units, from the first on, the first
//!    point of the other must have 0 ≤ x ≤ x_end and |y| no larger than the threshold.
//! 2. If no unit holds it, exchange the two curves and look again.
//! 3. If that fails too, there is no overlap. Curves whose ends merely touch are not merged.
//!
//! **Departures from the source.** |y| in place of y (errata). The sections are the enclosed parts
//! which [`classify`](crate::pattern::classify) found, in place of all that lies in the common
//! rectangle, which may hold ground before the overlap. A unit must also run the point's way, or
//! the opposite side of a thin sheet would hold it. If noise keeps both first points off, the next
//! ones are tried.
//!
//! **Cost.** A few points against the units of the overlap.

use super::strand::Strand;
use transect_geometry::{CurveUnit, Node, Point2, Vector2};

/// Points tried from the beginning of each curve: noise keeps one or two off, not this many.
const FIRST_POINTS: usize = 8;

/// When a unit holds a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// The farthest a point may be from a unit, in the length unit.
    pub threshold: f64,
    /// Smallest cosine between a point's way and that of its unit.
    pub least_cosine: f64,
}

/// The frame of a curve unit: its start is the origin, its direction the x axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct UnitFrame {
    pub origin: Point2,
    pub along: Vector2,
    /// Where the unit ends on its x axis; 0 if its two nodes are at one place.
    pub x_end: f64,
}

impl UnitFrame {
    pub fn new(unit: &CurveUnit) -> Self {
        let along = unit.vector().try_normalize(0.0).unwrap_or_default();
        Self { origin: unit.start, along, x_end: along.dot(&unit.vector()) }
    }

    /// A point in the frame of the unit; y is positive on its left.
    pub fn local(&self, p: &Point2) -> (f64, f64) {
        let d = p - self.origin;
        (self.along.dot(&d), self.along.perp(&d))
    }

    /// A place given in the frame of the unit.
    pub fn place(&self, x: f64, y: f64) -> Point2 {
        self.origin + self.along * x + Vector2::new(-self.along.y, self.along.x) * y
    }
}

/// Where the averaging begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Start {
    /// Which of the two strands is the basis curve: 0 or 1.
    pub basis: usize,
    /// The unit of the basis curve that holds the point.
    pub unit: usize,
    /// The point of the distant curve.
    pub point: usize,
}

/// The unit and the point with which two strands begin to overlap; `None` if they do not.
pub(super) fn verify(strands: [&Strand; 2], limits: &Limits) -> Option<Start> {
    (0..FIRST_POINTS).find_map(|k| {
        [0, 1].into_iter().find_map(|basis| {
            let distant = strands[1 - basis];
            let point = distant.enclosed.clone().nth(k)?;
            let mut units = strands[basis].units();
            let unit = units.find(|&unit| holds(strands[basis], unit, distant, point, limits))?;
            Some(Start { basis, unit, point })
        })
    })
}

/// Whether a unit of the basis curve holds a point of the distant curve.
pub(super) fn holds(
    basis: &Strand,
    unit: usize,
    distant: &Strand,
    point: usize,
    limits: &Limits,
) -> bool {
    let held = |unit: CurveUnit, node: &Node| {
        let frame = UnitFrame::new(&unit);
        let (x, y) = frame.local(&node.position);
        let beside = (0.0..=frame.x_end).contains(&x) && y.abs() <= limits.threshold;
        beside && frame.x_end > 0.0 && distant.runs_along(point, &frame.along, limits.least_cosine)
    };
    basis.unit(unit).zip(distant.nodes.get(point)).is_some_and(|(unit, node)| held(unit, node))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::CurveRange;
    use transect_geometry::Curve;

    const LIMITS: Limits = Limits { threshold: 0.1, least_cosine: 0.5 };

    /// The whole of a curve as the section that is looked at.
    fn section(points: &[(f64, f64)]) -> Strand {
        let nodes = points.iter().map(|&(x, y)| Node::at(Point2::new(x, y))).collect();
        let curve = Curve::new(nodes, false).unwrap();
        Strand::new(&curve, &CurveRange { from: 0.0, to: curve.length() })
    }

    #[test]
    fn the_curve_that_holds_the_others_first_point_is_the_basis() {
        let long = section(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0)]);
        let later = section(&[(1.5, 0.05), (2.5, 0.05), (3.5, 0.05)]);
        let expected = Start { basis: 0, unit: 1, point: 0 };
        assert_eq!(verify([&long, &later], &LIMITS), Some(expected));
        assert_eq!(verify([&later, &long], &LIMITS), Some(Start { basis: 1, ..expected }));
    }

    #[test]
    fn the_distance_counts_on_either_side() {
        let basis = section(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]);
        for (y, found) in [(0.09, true), (-0.09, true), (0.11, false), (-5.0, false)] {
            let distant = section(&[(0.5, y), (1.5, y)]);
            assert_eq!(verify([&basis, &distant], &LIMITS).is_some(), found, "{y}");
        }
    }

    #[test]
    fn touching_ends_and_opposite_directions_are_no_overlap() {
        let basis = section(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]);
        let behind = section(&[(2.01, 0.0), (3.0, 0.0)]);
        let opposite = section(&[(1.5, 0.05), (0.5, 0.05)]);
        assert_eq!(verify([&basis, &behind], &LIMITS), None);
        assert_eq!(verify([&basis, &opposite], &LIMITS), None);
    }

    #[test]
    fn a_noisy_beginning_does_not_hide_an_overlap() {
        let basis = section(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]);
        let noisy = section(&[(-0.3, -0.05), (0.5, 0.02), (1.5, 0.05)]);
        let ahead = section(&[(0.1, 0.5), (0.9, 0.05), (1.5, 0.0)]);
        let found = Some(Start { basis: 1, unit: 0, point: 0 });
        assert_eq!(verify([&basis, &noisy], &LIMITS), found);
        let found = Some(Start { basis: 0, unit: 0, point: 1 });
        assert_eq!(verify([&basis, &ahead], &LIMITS), found);
    }
}
