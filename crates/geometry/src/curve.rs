//! Oriented curves of nodes on a section plane (dissertation, sections 2.4 and 2.5.2).

use crate::{CurveUnit, Envelope, Foot, Point2, Side};
use serde::{Deserialize, Serialize};

/// A contour point: a vertex of a curve with what is known about it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Node {
    /// Where it is, in plane coordinates and the model's length unit.
    pub position: Point2,
    /// Standard deviation of the position across the curve, in the model's length unit.
    pub sigma: f32,
    /// Spacing of the samples along the curve here (one pixel's footprint), in the length unit.
    pub footprint: f32,
    /// How much it counts in an average: 1 for one observation in full view, less at rims; a fused
    /// node has the sum of its observations. No unit.
    pub weight: f32,
    /// How many views observed it; 0 marks ground that was bridged, not seen.
    pub views: u32,
}

impl Node {
    /// A node of one view with weight 1 and nothing known about its accuracy.
    pub fn at(position: Point2) -> Self {
        Self { position, sigma: 0.0, footprint: 0.0, weight: 1.0, views: 1 }
    }
}

/// Why nodes do not make a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CurveError {
    /// Fewer than two nodes for an open curve, or three for a closed one.
    #[error("{nodes} nodes cannot make {} curve", if *closed { "a closed" } else { "an open" })]
    TooFewNodes {
        /// How many there were.
        nodes: usize,
        /// Whether the curve was to be closed.
        closed: bool,
    },
    /// A coordinate is NaN or infinite.
    #[error("node {0} has a coordinate that is not a number")]
    NotFinite(usize),
}

/// An oriented polyline on a section plane, open or closed, with the solid on its left.
///
/// A closed curve does not repeat its first node at the end. Guaranteed: at least two nodes
/// (three when closed) and finite positions. Not checked: self-intersection, repeated positions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    nodes: Vec<Node>,
    closed: bool,
}

impl Curve {
    /// A curve through the nodes in order.
    ///
    /// # Errors
    /// [`CurveError`] if there are too few nodes, or one is not finite.
    pub fn new(nodes: Vec<Node>, closed: bool) -> Result<Self, CurveError> {
        if nodes.len() < 2 + usize::from(closed) {
            return Err(CurveError::TooFewNodes { nodes: nodes.len(), closed });
        }
        let finite = |n: &Node| n.position.x.is_finite() && n.position.y.is_finite();
        match nodes.iter().position(|n| !finite(n)) {
            Some(bad) => Err(CurveError::NotFinite(bad)),
            None => Ok(Self { nodes, closed }),
        }
    }

    /// The nodes in the direction of the curve.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The nodes, giving up the curve.
    pub fn into_nodes(self) -> Vec<Node> {
        self.nodes
    }

    /// Whether the last node is followed by the first.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// The curve units in order; a closed curve has one more, back to its first node.
    pub fn units(&self) -> impl ExactSizeIterator<Item = CurveUnit> + '_ {
        let n = self.nodes.len();
        let count = if self.closed { n } else { n - 1 };
        (0..count).map(move |i| CurveUnit {
            start: self.nodes[i].position,
            end: self.nodes[(i + 1) % n].position,
        })
    }

    /// Length in the model's length unit.
    pub fn length(&self) -> f64 {
        self.units().map(|u| u.vector().norm()).sum()
    }

    /// Area enclosed by a closed curve: positive around solid, negative around a hole; `None` if open.
    ///
    /// # Units
    /// The square of the model's length unit.
    pub fn signed_area(&self) -> Option<f64> {
        let anchor = self.nodes.first()?.position;
        let doubled = |u: CurveUnit| (u.start - anchor).perp(&(u.end - anchor));
        self.closed.then(|| 0.5 * self.units().map(doubled).sum::<f64>())
    }

    /// The rectangle around all nodes.
    pub fn envelope(&self) -> Envelope {
        let start = Envelope { min: self.nodes[0].position, max: self.nodes[0].position };
        Envelope::around(self.nodes.iter().map(|n| &n.position)).unwrap_or(start)
    }

    /// The same curve walked the other way round, its solid therefore on the other side.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self { nodes: self.nodes.iter().rev().copied().collect(), closed: self.closed }
    }

    /// The point of the curve nearest to `p`; the first one if several are equally near.
    pub fn foot(&self, p: &Point2) -> Foot {
        let start = self.nodes[0].position;
        let far = Foot { unit: 0, parameter: 0.0, point: start, distance: f64::INFINITY };
        self.units().enumerate().fold(far, |best, (unit, u)| {
            let parameter = u.parameter(p).clamp(0.0, 1.0);
            let point = u.at(parameter);
            let distance = (p - point).norm();
            if distance < best.distance { Foot { unit, parameter, point, distance } } else { best }
        })
    }

    /// The side of the curve at one of its feet on which a point lies.
    ///
    /// `None` where the curve cannot tell: the foot is an open end and the point lies beyond it. At
    /// a corner the two adjoining units decide together, as for a solid angle in 3D.
    pub fn side_at(&self, foot: &Foot, p: &Point2) -> Option<Side> {
        let unit = self.units().nth(foot.unit)?;
        let neighbour = match foot.parameter {
            t if t <= 0.0 => self.unit_before(foot.unit),
            t if t >= 1.0 => self.unit_after(foot.unit),
            _ => return Some(unit.side(p)),
        };
        let at_end_exactly = || (unit.parameter(p) - foot.parameter).abs() < 1e-12;
        let Some(neighbour) = neighbour else {
            return at_end_exactly().then(|| unit.side(p));
        };
        // The corner's direction is the sum of the two unit directions; when the curve turns back
        // on itself there, the sum vanishes and the first unit has to decide alone.
        let direction = unit.vector().normalize() + neighbour.vector().normalize();
        let across = direction.perp(&(p - foot.point));
        let decided = direction.norm() > 1e-12 && across != 0.0;
        if !decided {
            return Some(unit.side(p));
        }
        Some(if across < 0.0 { Side::Outside } else { Side::Inside })
    }

    fn unit_before(&self, unit: usize) -> Option<CurveUnit> {
        let count = self.units().len();
        match (unit, self.closed) {
            (0, false) => None,
            (0, true) => self.units().nth(count - 1),
            _ => self.units().nth(unit - 1),
        }
    }

    fn unit_after(&self, unit: usize) -> Option<CurveUnit> {
        let count = self.units().len();
        match (unit + 1 == count, self.closed) {
            (true, false) => None,
            (true, true) => self.units().next(),
            _ => self.units().nth(unit + 1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polyline(points: &[(f64, f64)], closed: bool) -> Curve {
        let nodes = points.iter().map(|&(x, y)| Node::at(Point2::new(x, y))).collect();
        Curve::new(nodes, closed).unwrap()
    }

    fn square() -> Curve {
        polyline(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)], true)
    }

    #[test]
    fn counter_clockwise_square_has_positive_area_and_its_inside_on_the_left() {
        let s = square();
        assert_eq!(s.signed_area(), Some(4.0));
        assert_eq!(s.reversed().signed_area(), Some(-4.0));
        assert_eq!(s.length(), 8.0);
        let inside = Point2::new(1.9, 1.0);
        assert_eq!(s.side_at(&s.foot(&inside), &inside), Some(Side::Inside));
    }

    #[test]
    fn far_coordinates_keep_the_area() {
        let (x, y) = (5.0e5, 5.4e6);
        let far = polyline(&[(x, y), (x + 2.0, y), (x + 2.0, y + 2.0), (x, y + 2.0)], true);
        assert!((far.signed_area().unwrap() - 4.0).abs() < 1e-9);
    }

    #[test]
    fn corners_tell_outside_from_inside() {
        let s = square();
        for (p, side) in [
            (Point2::new(3.0, 3.0), Side::Outside),
            (Point2::new(-1.0, -0.5), Side::Outside),
            (Point2::new(0.5, 0.4), Side::Inside),
        ] {
            assert_eq!(s.side_at(&s.foot(&p), &p), Some(side), "{p}");
        }
    }

    #[test]
    fn beyond_an_open_end_nothing_is_known() {
        let c = polyline(&[(0.0, 0.0), (1.0, 0.0)], false);
        let beyond = Point2::new(2.0, 0.5);
        assert_eq!(c.side_at(&c.foot(&beyond), &beyond), None);
        let beside = Point2::new(0.5, 0.5);
        assert_eq!(c.side_at(&c.foot(&beside), &beside), Some(Side::Inside));
        assert_eq!(c.signed_area(), None);
    }

    #[test]
    fn too_few_or_wild_nodes_are_refused() {
        let one = vec![Node::at(Point2::origin())];
        let text = Curve::new(one, false).unwrap_err().to_string();
        assert_eq!(text, "1 nodes cannot make an open curve");
        let wild = vec![Node::at(Point2::origin()), Node::at(Point2::new(f64::NAN, 0.0))];
        assert_eq!(Curve::new(wild, false), Err(CurveError::NotFinite(1)));
    }
}
