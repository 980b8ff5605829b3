//! Where curves of one plane cross: places that no boundary of a solid can have.
//!
//! **Problem.** The boundary of a solid neither crosses nor touches itself. Curves from
//! measurements may. Wanted: all pairs of units that meet.
//!
//! **Steps.** An R-tree of boxes around runs of units is joined with itself. Each pair of units in
//! two boxes that overlap is tested by their own boxes, then by the signs of four triangles.
//!
//! **Cost.** O(n log n) for n units, as far as few boxes overlap.

use crate::{Curve, CurveUnit, Envelope};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// Units that share a box. Measured on a whole run: with one, finding crossings takes 2.5 times as
/// long. Doubled, each pair of boxes has four times as many pairs of units.
const RUN: usize = 8;

/// A unit of one of several curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct UnitPlace {
    /// The curve's place among the curves.
    pub curve: usize,
    /// The unit's place on the curve: unit k leads from node k to the next node.
    pub unit: usize,
}

/// The pairs of units that cross or touch, each once, in the order of the curves. Units of one
/// curve that share a node do not count. Nodes that follow each other in one place count as one.
///
/// ```
/// use transect_geometry::{Curve, Node, Point2, crossings};
///
/// let curve = |places: [(f64, f64); 4]| {
///     let nodes = places.map(|(x, y)| Node::at(Point2::new(x, y)));
///     Curve::new(nodes.to_vec(), false)
/// };
/// let loops = curve([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, -1.0)])?;
/// let found = crossings(&[loops]);
/// assert_eq!(found.len(), 1);
/// assert_eq!((found[0].0.unit, found[0].1.unit), (0, 2));
/// # Ok::<(), transect_geometry::CurveError>(())
/// ```
pub fn crossings<'a>(curves: impl IntoIterator<Item = &'a Curve>) -> Vec<(UnitPlace, UnitPlace)> {
    let curves: Vec<&Curve> = curves.into_iter().collect();
    let places = curves.iter().enumerate().flat_map(|(curve, c)| {
        c.units().enumerate().map(move |(unit, u)| (UnitPlace { curve, unit }, u))
    });
    let units: Vec<(UnitPlace, CurveUnit)> = places.collect();
    let boxes: Vec<Envelope> = units.iter().map(|(_, unit)| unit.envelope()).collect();
    let entry = |(k, run): (usize, &[Envelope])| {
        let around = run.iter().skip(1).fold(run[0], |around, unit| around.merged(unit));
        let around = AABB::from_corners(around.min.into(), around.max.into());
        GeomWithData::new(Rectangle::from_aabb(around), k * RUN)
    };
    let tree: RTree<GeomWithData<Rectangle<[f64; 2]>, usize>> =
        RTree::bulk_load(boxes.chunks(RUN).enumerate().map(entry).collect());
    let runs = tree.intersection_candidates_with_other_tree(&tree);
    let steps: Vec<Vec<usize>> = curves.iter().map(|curve| steps(curve)).collect();
    let are_neighbours = |a: UnitPlace, b: UnitPlace| {
        a.curve == b.curve && are_neighbours(&steps[a.curve], curves[a.curve].is_closed(), a, b)
    };
    let mut found = Vec::new();
    for (a, b) in runs.map(|(a, b)| (a.data, b.data)).filter(|(a, b)| a <= b) {
        for a in a..(a + RUN).min(units.len()) {
            for b in b.max(a + 1)..(b + RUN).min(units.len()) {
                let ((at_a, unit_a), (at_b, unit_b)) = (&units[a], &units[b]);
                let may_meet = boxes[a].intersects(&boxes[b]);
                if may_meet && !are_neighbours(*at_a, *at_b) && meet(unit_a, unit_b) {
                    found.push((*at_a, *at_b));
                }
            }
        }
    }
    found.sort_unstable();
    found
}

/// For each unit of a curve the number of units before it that have a length, and that of all.
fn steps(curve: &Curve) -> Vec<usize> {
    let lengths = curve.units().map(|unit| usize::from(unit.start != unit.end));
    let mut sum = 0;
    let ends = lengths.map(|step| {
        sum += step;
        sum
    });
    std::iter::once(0).chain(ends).collect()
}

/// Whether two units of a curve, `a` before `b`, follow each other, apart from units without length
/// between them.
fn are_neighbours(steps: &[usize], closed: bool, a: UnitPlace, b: UnitPlace) -> bool {
    let wraps = closed && steps[a.unit] == 0 && steps.last() == Some(&steps[b.unit + 1]);
    steps[b.unit] == steps[a.unit + 1] || wraps
}

/// Whether two units whose boxes overlap have a common point.
fn meet(a: &CurveUnit, b: &CurveUnit) -> bool {
    let parts = |unit: &CurveUnit, other: &CurveUnit| {
        let (start, end) = (unit.line_value(&other.start), unit.line_value(&other.end));
        !(start > 0.0 && end > 0.0 || start < 0.0 && end < 0.0)
    };
    parts(a, b) && parts(b, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Node, Point2};
    use proptest::prelude::*;

    /// The slow twin: every pair of units.
    fn all_pairs(curves: &[Curve]) -> Vec<(UnitPlace, UnitPlace)> {
        let mut units = Vec::new();
        for (curve, c) in curves.iter().enumerate() {
            units.extend(c.units().enumerate().map(|(unit, u)| (UnitPlace { curve, unit }, u)));
        }
        let mut found = Vec::new();
        for (k, (at_a, a)) in units.iter().enumerate() {
            for (at_b, b) in &units[k + 1..] {
                let ranges = |f: fn(&Point2) -> f64| {
                    let (low_a, high_a) = (f(&a.start).min(f(&a.end)), f(&a.start).max(f(&a.end)));
                    let (low_b, high_b) = (f(&b.start).min(f(&b.end)), f(&b.start).max(f(&b.end)));
                    low_a <= high_b && low_b <= high_a
                };
                let boxes = ranges(|p| p.x) && ranges(|p| p.y);
                let of_one = at_a.curve == at_b.curve;
                if boxes && !(of_one && follow(&curves[at_a.curve], *at_a, *at_b)) && meet(a, b) {
                    found.push((*at_a, *at_b));
                }
            }
        }
        found
    }

    /// Whether all units between two of a curve are without length, on either way round.
    fn follow(curve: &Curve, a: UnitPlace, b: UnitPlace) -> bool {
        let is_point: Vec<bool> = curve.units().map(|unit| unit.start == unit.end).collect();
        let between = is_point[a.unit + 1..b.unit].iter().all(|is_point| *is_point);
        let outside = [&is_point[..a.unit], &is_point[b.unit + 1..]].concat();
        between || curve.is_closed() && outside.iter().all(|is_point| *is_point)
    }

    #[test]
    fn units_on_either_side_of_a_repeated_node_are_neighbours() {
        let curve = |places: &[(f64, f64)], closed| {
            let nodes = places.iter().map(|&(x, y)| Node::at(Point2::new(x, y))).collect();
            Curve::new(nodes, closed).unwrap()
        };
        let line = curve(&[(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (1.0, 0.0), (2.0, 0.0)], false);
        assert_eq!(crossings(&[line]), []);
        let ring = [(0.0, 0.0), (0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0), (0.0, 0.0)];
        assert_eq!(crossings(&[curve(&ring, true)]), []);
        // The place of the repeated node is met again.
        let back = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 0.0)];
        assert!(!crossings(&[curve(&back, false)]).is_empty());
    }

    proptest! {
        #[test]
        fn the_tree_finds_what_all_pairs_find(
            curves in prop::collection::vec(
                (prop::collection::vec((-9_i8..9, -9_i8..9), 2..9), any::<bool>()), 0..5),
        ) {
            let curves: Vec<Curve> = curves.into_iter().filter_map(|(places, closed)| {
                let node = |(x, y)| Node::at(Point2::new(f64::from(x), f64::from(y)));
                Curve::new(places.into_iter().map(node).collect(), closed).ok()
            }).collect();
            prop_assert_eq!(crossings(&curves), all_pairs(&curves));
        }
    }

    #[test]
    fn curves_that_touch_or_lie_on_each_other_count() {
        let line = |a: (f64, f64), b: (f64, f64)| {
            let nodes = [a, b].map(|(x, y)| Node::at(Point2::new(x, y)));
            Curve::new(nodes.to_vec(), false).unwrap()
        };
        let base = line((0.0, 0.0), (4.0, 0.0));
        let count = |other: Curve| crossings(&[base.clone(), other]).len();
        assert_eq!(count(line((1.0, -1.0), (1.0, 1.0))), 1, "across");
        assert_eq!(count(line((1.0, 0.0), (1.0, 1.0))), 1, "a fork");
        assert_eq!(count(line((3.0, 0.0), (9.0, 0.0))), 1, "on each other");
        assert_eq!(count(line((5.0, 0.0), (9.0, 0.0))), 0, "beyond the end");
        assert_eq!(count(line((1.0, 0.1), (3.0, 0.1))), 0, "beside");
    }
}
