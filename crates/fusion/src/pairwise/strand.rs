//! A curve laid out from a beginning to an end, so that one of its overlaps lies within.
//!
//! An open curve is its own strand. A closed curve is cut in the middle of what the overlap leaves
//! of it, as Rule 3 allows anywhere. The cut is a node that stands at both ends of the strand and
//! is taken out when the curve closes again.

use crate::pattern::CurveRange;
use crate::sequence::arc_lengths;
use std::ops::Range;
use transect_geometry::{Curve, CurveUnit, EndReason, Node, Vector2};

/// Share of a curve's length within which two arc lengths are one: rounding of the sums.
const ARC_ROUNDING: f64 = 1e-12;

/// The nodes of a curve in order, and the overlap among them.
#[derive(Debug, Clone)]
pub(super) struct Strand {
    /// All nodes; of a closed curve with the cut at both ends.
    pub nodes: Vec<Node>,
    /// The enclosed nodes: those of the overlap.
    pub enclosed: Range<usize>,
    /// Arc length before the overlap, and behind it.
    pub outside: [f64; 2],
    /// Whether the curve is closed.
    pub closed: bool,
    /// Why the curve begins and ends; `None` where it is not known.
    pub ends: [Option<EndReason>; 2],
}

impl Strand {
    /// Lays out a curve around one of its overlaps.
    pub fn new(curve: &Curve, overlap: &CurveRange) -> Self {
        let arc = arc_lengths(curve.units().map(|unit| unit.vector().norm()));
        let length = arc[arc.len() - 1];
        if curve.is_closed() {
            return Self::cut(curve, &arc, overlap, length);
        }
        let rounding = ARC_ROUNDING * length;
        let from = arc.partition_point(|s| *s < overlap.from - rounding);
        let to = arc.partition_point(|s| *s <= overlap.to + rounding);
        Self {
            nodes: curve.nodes().to_vec(),
            enclosed: from..to.max(from),
            outside: [overlap.from, (length - overlap.to).max(0.0)],
            closed: false,
            ends: curve.ends(),
        }
    }

    fn cut(curve: &Curve, arc: &[f64], overlap: &CurveRange, length: f64) -> Self {
        let outside = 0.5 * (length - overlap.length()).max(0.0);
        let at = (overlap.to + outside).rem_euclid(length);
        let count = curve.nodes().len();
        // The first node behind the cut; behind the last one comes node 0.
        let first = arc[..count].partition_point(|s| *s <= at) % count;
        let before = (first + count - 1) % count;
        let cut = between(&curve.nodes()[before], &curve.nodes()[first], at - arc[before]);
        let order = || (first..count).chain(0..first);
        let mut nodes = Vec::with_capacity(count + 2);
        nodes.push(cut);
        nodes.extend(order().map(|k| curve.nodes()[k]));
        nodes.push(cut);
        let rounding = ARC_ROUNDING * length;
        let places: Vec<_> = order().map(|k| (arc[k] - at).rem_euclid(length)).collect();
        // The cut is node 0 of the strand.
        let from = 1 + places.partition_point(|s| *s < outside - rounding);
        let to = 1 + places.partition_point(|s| *s <= length - outside + rounding);
        Self { nodes, enclosed: from..to, outside: [outside; 2], closed: true, ends: [None; 2] }
    }

    /// The unit that begins at a node.
    pub fn unit(&self, k: usize) -> Option<CurveUnit> {
        let (start, end) = (self.nodes.get(k)?, self.nodes.get(k + 1)?);
        Some(CurveUnit { start: start.position, end: end.position })
    }

    /// The units with a part in the overlap, by the nodes where they begin.
    pub fn units(&self) -> Range<usize> {
        let end = self.enclosed.end.min(self.nodes.len().saturating_sub(1));
        self.enclosed.start.saturating_sub(1).min(end)..end
    }

    /// Whether the curve arrives at a node, or leaves it, nearly along a unit direction.
    pub fn runs_along(&self, node: usize, along: &Vector2, least_cosine: f64) -> bool {
        let arriving = node.checked_sub(1).and_then(|k| self.unit(k));
        let ways = [arriving, self.unit(node)].into_iter().flatten();
        let mut directions = ways.filter_map(|unit| unit.vector().try_normalize(0.0));
        directions.any(|direction| direction.dot(along) >= least_cosine)
    }

    /// The nodes of a range without the cut.
    pub fn observed(&self, range: Range<usize>) -> Vec<Node> {
        range.filter(|&k| self.is_observed(k)).filter_map(|k| self.nodes.get(k).copied()).collect()
    }

    /// Whether a node is of the curve, and not the cut.
    pub fn is_observed(&self, k: usize) -> bool {
        !self.closed || (k > 0 && k + 1 < self.nodes.len())
    }
}

/// A node some way along the unit from one node to another.
fn between(from: &Node, to: &Node, way: f64) -> Node {
    let unit = to.position - from.position;
    let along = unit.try_normalize(0.0).unwrap_or_default();
    from.moved_to(from.position + along * way.clamp(0.0, unit.norm()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_geometry::Point2;

    fn curve(points: &[(f64, f64)], closed: bool) -> Curve {
        let nodes = points.iter().map(|&(x, y)| Node::at(Point2::new(x, y))).collect();
        Curve::new(nodes, closed).unwrap()
    }

    #[test]
    fn the_strand_of_an_open_curve_is_the_curve() {
        let line = curve(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0)], false);
        let strand = Strand::new(&line, &CurveRange { from: 0.5, to: 2.0 });
        assert_eq!((strand.enclosed.clone(), strand.units()), (1..3, 0..3));
        assert_eq!(strand.outside, [0.5, 1.0]);
        let within_a_unit = Strand::new(&line, &CurveRange { from: 1.2, to: 1.8 });
        assert_eq!((within_a_unit.enclosed.clone(), within_a_unit.units()), (2..2, 1..2));
    }

    #[test]
    fn a_closed_curve_is_cut_opposite_its_overlap() {
        let square = curve(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)], true);
        // From one unit before node 0 to one unit behind it.
        let strand = Strand::new(&square, &CurveRange { from: 7.0, to: 9.0 });
        let places: Vec<_> = strand.nodes.iter().map(|n| (n.position.x, n.position.y)).collect();
        let (a, b, c, d) = ((0.0, 2.0), (0.0, 0.0), (2.0, 0.0), (2.0, 2.0));
        assert_eq!(places, [d, a, b, c, d, d].map(|p| p));
        assert_eq!((strand.enclosed.clone(), strand.outside), (2..3, [3.0; 2]));
        let whole = Strand::new(&square, &CurveRange { from: 1.0, to: 9.0 });
        assert_eq!(whole.enclosed, 1..5);
        assert_eq!(whole.nodes[0].position, Point2::new(1.0, 0.0));
    }
}
