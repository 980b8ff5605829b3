//! Nesting of closed curves: a check of their directions.
//!
//! The direction of a curve says on which side the solid is. It comes from the side on which the
//! surface was seen (dissertation, 3.7). The nesting of closed curves that do not cross tells it
//! too: a curve directly within a curve around solid must be a hole, and the other way round. Where
//! direction and nesting disagree, a direction is wrong, a surface between the curves was not seen,
//! or the curves cross.
//!
//! 1. The parent of a curve is the smallest closed curve around it, by the even-odd rule, which
//!    ignores directions.
//! 2. A curve that runs the same way round as its parent is a disagreement.
//!
//! A clockwise curve without a parent is not a disagreement: it is a room seen from within.
//!
//! Cost: for n closed curves with m nodes each, O(n²) comparisons of envelopes, and O(m) for each
//! pair of nested envelopes. Do not use it on curves that cross: one node decides the parent of
//! such a curve.

use crate::{CurveIndex, CurveRecord, Section};
use transect_geometry::{Curve, Point2};

/// The place of a closed curve among the others of its plane.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct NestedCurve {
    /// The curve.
    pub curve: CurveIndex,
    /// The smallest closed curve around it.
    pub parent: Option<CurveIndex>,
    /// Number of closed curves around it.
    pub depth: usize,
    /// Whether it runs around solid (counter-clockwise).
    pub is_outer: bool,
    /// Whether its direction contradicts its parent's.
    pub contradicts_parent: bool,
}

/// A closed curve with its area.
struct Closed<'a> {
    index: CurveIndex,
    record: &'a CurveRecord,
    area: f64,
}

impl Section {
    /// The nesting of the plane's closed curves, in their order.
    pub fn nesting(&self) -> Vec<NestedCurve> {
        let records = self.curve_records().iter().enumerate();
        let closed = records.filter_map(|(index, record)| {
            let area = record.curve().signed_area()?;
            Some(Closed { index: CurveIndex(index), record, area })
        });
        let closed: Vec<_> = closed.collect();
        closed.iter().map(|curve| nested(curve, &closed)).collect()
    }
}

fn nested(curve: &Closed<'_>, all: &[Closed<'_>]) -> NestedCurve {
    let around: Vec<_> = all.iter().filter(|other| lies_within(curve, other)).collect();
    let parent = around.iter().min_by(|a, b| a.area.abs().total_cmp(&b.area.abs()));
    let is_outer = curve.area > 0.0;
    NestedCurve {
        curve: curve.index,
        parent: parent.map(|parent| parent.index),
        depth: around.len(),
        is_outer,
        contradicts_parent: parent.is_some_and(|parent| (parent.area > 0.0) == is_outer),
    }
}

fn lies_within(curve: &Closed<'_>, other: &Closed<'_>) -> bool {
    let (inner, outer) = (curve.record.envelope(), other.record.envelope());
    let smaller = curve.area.abs() < other.area.abs();
    let may = smaller && outer.contains(&inner.min) && outer.contains(&inner.max);
    let node = curve.record.curve().nodes().first();
    may && node.is_some_and(|node| encloses(other.record.curve(), &node.position))
}

/// Whether a ray along +x from the point crosses the curve an odd number of times.
fn encloses(curve: &Curve, p: &Point2) -> bool {
    let crossed = curve.units().filter(|unit| {
        let (a, b) = (unit.start, unit.end);
        let right_of_point = || unit.line_value(p) < 0.0;
        (a.y <= p.y) != (b.y <= p.y) && (right_of_point() == (b.y > a.y))
    });
    crossed.count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{rectangle, rings, strip};
    use proptest::prelude::*;

    fn boxes() -> Vec<Curve> {
        // A wall around a room with a post that has a bore, and another wall beside.
        vec![
            rectangle(4.0, 4.0, 5.0, 5.0),
            rectangle(0.0, 0.0, 9.0, 9.0),
            strip(),
            rectangle(4.2, 4.2, 4.8, 4.8).reversed(),
            rectangle(1.0, 1.0, 8.0, 8.0).reversed(),
            rectangle(20.0, 0.0, 29.0, 9.0),
        ]
    }

    fn tree(curves: Vec<Curve>) -> Vec<(usize, Option<usize>, usize, bool)> {
        let nesting = Section::new(curves).unwrap().nesting();
        let row =
            |n: NestedCurve| (n.curve.0, n.parent.map(|p| p.0), n.depth, n.contradicts_parent);
        nesting.into_iter().map(row).collect()
    }

    #[test]
    fn parents_are_the_smallest_curves_around() {
        let expected = [
            (0, Some(4), 2, false),
            (1, None, 0, false),
            (3, Some(0), 3, false),
            (4, Some(1), 1, false),
            (5, None, 0, false),
        ];
        assert_eq!(tree(boxes()), expected);
    }

    #[test]
    fn a_turned_curve_contradicts_its_parent_and_its_children_it() {
        let mut curves = boxes();
        curves[0] = curves[0].reversed();
        let wrong: Vec<_> = tree(curves).into_iter().filter(|row| row.3).map(|row| row.0).collect();
        assert_eq!(wrong, [0, 3]);
    }

    #[test]
    fn a_room_seen_from_within_is_no_contradiction() {
        let room = Section::new(vec![rectangle(0.0, 0.0, 4.0, 3.0).reversed()]).unwrap().nesting();
        assert_eq!((room[0].is_outer, room[0].contradicts_parent), (false, false));
    }

    proptest! {
        #[test]
        fn rings_nest_as_they_were_made_and_only_turned_curves_contradict(
            curves in rings(), turned in 0..4usize,
        ) {
            let parents = [None, Some(0), None, Some(2)];
            let found = tree(curves.clone());
            for (row, parent) in found.iter().zip(parents) {
                prop_assert_eq!((row.1, row.3), (parent, false));
            }
            let mut curves = curves;
            curves[turned] = curves[turned].reversed();
            let wrong: Vec<_> = tree(curves).iter().filter(|r| r.3).map(|r| r.0).collect();
            prop_assert_eq!(wrong, vec![turned | 1]);
        }
    }
}
