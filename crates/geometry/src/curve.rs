//! Oriented curves of nodes on a section plane (dissertation, sections 2.4 and 2.5.2).

use crate::{CurveError, CurveUnit, EndReason, Envelope, Foot, Point2, Side, Vector2};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::num::NonZeroU32;

/// A contour point: a vertex of a curve with its error and origin.
///
/// Made by [`Node::at`] and the `with_…` methods, so that later versions can add fields.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "StoredNode", into = "StoredNode")]
#[non_exhaustive]
pub struct Node {
    /// Where it is, in plane coordinates and the model's length unit.
    pub position: Point2,
    /// Standard deviation of the position across the curve, in the model's length unit; 0 if
    /// unknown.
    pub sigma: f32,
    /// Spacing of the samples along the curve here (one pixel's footprint), in the length unit; 0
    /// if unknown.
    pub footprint: f32,
    /// How much it counts in an average: 1 for one observation; a fused node has the sum of its
    /// observations, of which those near open ends count less. No unit.
    pub weight: f32,
    /// How many views measured it; `None` on bridged ground, which no view measured.
    pub views: Option<NonZeroU32>,
    /// Length along the curve over which nodes share their errors, in the length unit: the window
    /// of smoothing. 0 if errors are independent.
    pub correlation: f32,
    /// Tangent of the angle between the ray and the surface's normal; `None` where it is not known.
    pub tan_incidence: Option<f32>,
    /// Outward unit normal of the surface, in plane coordinates with the plane's normal third;
    /// `None` where it is not known.
    pub normal: Option<Vector3<f32>>,
    /// Whether the curve unit that begins here crosses ground that no view measured.
    pub bridged: bool,
}

impl Node {
    /// A node of one view with weight 1 and without a measured error, incidence or normal.
    pub fn at(position: Point2) -> Self {
        Self {
            position,
            sigma: 0.0,
            footprint: 0.0,
            weight: 1.0,
            views: Some(NonZeroU32::MIN),
            correlation: 0.0,
            tan_incidence: None,
            normal: None,
            bridged: false,
        }
    }

    /// The same node elsewhere in the plane.
    #[must_use]
    pub fn moved_to(self, position: Point2) -> Self {
        Self { position, ..self }
    }

    /// The same node with a standard deviation across the curve, in the length unit.
    #[must_use]
    pub fn with_sigma(self, sigma: f32) -> Self {
        Self { sigma, ..self }
    }

    /// The same node with a sample spacing along the curve, in the length unit.
    #[must_use]
    pub fn with_footprint(self, footprint: f32) -> Self {
        Self { footprint, ..self }
    }

    /// The same node with a weight in averages.
    #[must_use]
    pub fn with_weight(self, weight: f32) -> Self {
        Self { weight, ..self }
    }

    /// The same node measured by a number of views; 0 marks bridged ground.
    #[must_use]
    pub fn with_views(self, views: u32) -> Self {
        Self { views: NonZeroU32::new(views), ..self }
    }

    /// The same node with a length over which neighbours share their errors, in the length unit.
    #[must_use]
    pub fn with_correlation(self, correlation: f32) -> Self {
        Self { correlation, ..self }
    }

    /// The same node with the tangent of its angle of incidence.
    #[must_use]
    pub fn with_tan_incidence(self, tan_incidence: Option<f32>) -> Self {
        Self { tan_incidence, ..self }
    }

    /// The same node with an outward unit normal.
    #[must_use]
    pub fn with_normal(self, normal: Option<Vector3<f32>>) -> Self {
        Self { normal, ..self }
    }

    /// The same node, whose unit to the next node is marked as bridged or as measured.
    #[must_use]
    pub fn with_bridged(self, bridged: bool) -> Self {
        Self { bridged, ..self }
    }

    /// How many views measured it; 0 on bridged ground.
    pub fn view_count(&self) -> u32 {
        self.views.map_or(0, NonZeroU32::get)
    }

    /// Checks that measures are finite and not negative, and that the normal is finite; `node` is
    /// its number.
    fn check(&self, node: usize) -> Result<(), CurveError> {
        let measures = [
            ("sigma", self.sigma),
            ("footprint", self.footprint),
            ("weight", self.weight),
            ("correlation", self.correlation),
            ("tan_incidence", self.tan_incidence.unwrap_or(0.0)),
        ];
        if let Some((attribute, value)) = measures.into_iter().find(|m| !is_measure(m.1)) {
            return Err(CurveError::BadAttribute { node, attribute, value });
        }
        match self.normal.iter().flatten().find(|c| !c.is_finite()) {
            Some(component) => Err(CurveError::BadNormal { node, component: *component }),
            None => Ok(()),
        }
    }
}

fn is_measure(value: f32) -> bool {
    value.is_finite() && value >= 0.0
}

/// A node as files hold it, in the order of the first layout.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StoredNode {
    /// [`Node::position`].
    pub position: Point2,
    /// [`Node::sigma`].
    pub sigma: f32,
    /// [`Node::footprint`].
    pub footprint: f32,
    /// [`Node::weight`].
    pub weight: f32,
    /// [`Node::views`]; 0 if no view measured the node.
    pub views: u32,
    /// [`Node::correlation`].
    pub correlation: f32,
    /// [`Node::tan_incidence`]; 0 if unknown, and the smallest positive number for a ray along the
    /// normal.
    pub tan_incidence: f32,
    /// [`Node::normal`]; 0 if unknown.
    pub normal: Vector3<f32>,
    /// [`Node::bridged`].
    pub bridged: bool,
}

impl From<Node> for StoredNode {
    fn from(node: Node) -> Self {
        let Node { position, sigma, footprint, weight, correlation, bridged, .. } = node;
        let views = node.view_count();
        let tan_incidence = node.tan_incidence.map_or(0.0, |tan| tan.max(f32::MIN_POSITIVE));
        let normal = node.normal.unwrap_or_default();
        Self {
            position,
            sigma,
            footprint,
            weight,
            views,
            correlation,
            tan_incidence,
            normal,
            bridged,
        }
    }
}

impl From<StoredNode> for Node {
    fn from(stored: StoredNode) -> Self {
        let StoredNode { position, sigma, footprint, weight, correlation, bridged, .. } = stored;
        Self {
            position,
            sigma,
            footprint,
            weight,
            views: NonZeroU32::new(stored.views),
            correlation,
            tan_incidence: Some(stored.tan_incidence).filter(|tan| *tan != 0.0),
            normal: Some(stored.normal).filter(|normal| *normal != Vector3::zeros()),
            bridged,
        }
    }
}

/// An oriented polyline on a section plane, open or closed, with the solid on its left.
///
/// A closed curve does not repeat its first node at the end. Guaranteed: at least two nodes (three
/// when closed), finite positions, no negative measure. Not checked: self-intersections, repeated
/// positions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Parts")]
pub struct Curve {
    nodes: Vec<Node>,
    closed: bool,
    ends: [Option<EndReason>; 2],
}

/// A curve as it comes from a file, not yet checked.
#[derive(Deserialize)]
struct Parts {
    nodes: Vec<Node>,
    closed: bool,
    ends: [Option<EndReason>; 2],
}

impl TryFrom<Parts> for Curve {
    type Error = CurveError;

    fn try_from(parts: Parts) -> Result<Self, CurveError> {
        Ok(Self::new(parts.nodes, parts.closed)?.with_ends(parts.ends))
    }
}

impl Curve {
    /// A curve through the nodes in order, with ends of unknown reason.
    ///
    /// The last node of an open curve begins no unit, so its mark of bridged ground is cleared.
    ///
    /// # Errors
    /// [`CurveError`] if there are too few nodes, or a node has invalid numbers.
    pub fn new(mut nodes: Vec<Node>, closed: bool) -> Result<Self, CurveError> {
        if nodes.len() < 2 + usize::from(closed) {
            return Err(CurveError::TooFewNodes { nodes: nodes.len(), closed });
        }
        let finite = |n: &Node| n.position.x.is_finite() && n.position.y.is_finite();
        if let Some(bad) = nodes.iter().position(|n| !finite(n)) {
            return Err(CurveError::NotFinite(bad));
        }
        nodes.iter().enumerate().try_for_each(|(k, node)| node.check(k))?;
        if let (false, Some(last)) = (closed, nodes.last_mut()) {
            last.bridged = false;
        }
        Ok(Self { nodes, closed, ends: [None; 2] })
    }

    /// The same curve with the reasons of its two ends; they are ignored for a closed curve.
    #[must_use]
    pub fn with_ends(self, ends: [Option<EndReason>; 2]) -> Self {
        Self { ends: if self.closed { [None; 2] } else { ends }, ..self }
    }

    /// Why the curve begins and ends; `None` if unknown, and for closed curves.
    pub fn ends(&self) -> [Option<EndReason>; 2] {
        self.ends
    }

    /// The nodes in the direction of the curve.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The nodes; consumes the curve.
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

    /// Area enclosed by a closed curve: positive around solid, negative around a hole; `None` if
    /// open.
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

    /// The same curve in the opposite direction, so with the solid on its other side.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let mut nodes: Vec<Node> = self.nodes.iter().rev().copied().collect();
        // The unit that began at a node now ends there, so its mark moves to the node before.
        let first = nodes.first().is_some_and(|n| n.bridged);
        for k in 1..nodes.len() {
            nodes[k - 1].bridged = nodes[k].bridged;
        }
        if let Some(last) = nodes.last_mut() {
            last.bridged = first;
        }
        let [begin, end] = self.ends;
        Self { nodes, closed: self.closed, ends: [end, begin] }
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
    /// `None` if the foot is an open end and the point lies beyond it. At a corner the two
    /// adjoining units decide together, as for a solid angle in 3D.
    pub fn side_at(&self, foot: &Foot, p: &Point2) -> Option<Side> {
        let unit = self.unit(foot.unit)?;
        let neighbour = match foot.parameter {
            t if t <= 0.0 => self.direction_from(foot.unit, Way::Back),
            t if t >= 1.0 => self.direction_from(foot.unit, Way::On),
            _ => return Some(unit.side(p)),
        };
        let own = unit.vector().try_normalize(0.0);
        let (own, neighbour) = match (own, neighbour) {
            (Some(own), Some(neighbour)) => (own, neighbour),
            // A unit without length is a repeated node: its neighbours decide.
            (None, Some(neighbour)) => (self.direction_from(foot.unit, Way::On)?, neighbour),
            (own, None) => {
                let beside = own.is_some() && (unit.parameter(p) - foot.parameter).abs() < 1e-12;
                return beside.then(|| unit.side(p));
            }
        };
        // The corner's direction is the sum of the two unit directions. If the curve turns back on
        // itself, the sum vanishes and the first unit decides alone.
        let direction = own + neighbour;
        let direction = if direction.norm() > 1e-12 { direction } else { own };
        let outside = direction.perp(&(p - foot.point)) < 0.0;
        Some(if outside { Side::Outside } else { Side::Inside })
    }

    fn unit(&self, k: usize) -> Option<CurveUnit> {
        let last = k + 1 == self.nodes.len();
        let next = if last && self.closed { self.nodes.first() } else { self.nodes.get(k + 1) };
        Some(CurveUnit { start: self.nodes.get(k)?.position, end: next?.position })
    }

    /// Direction of the nearest other unit with a length, before or after unit `k`.
    fn direction_from(&self, k: usize, way: Way) -> Option<Vector2> {
        let count = self.units().len();
        (1..count).find_map(|step| {
            let at = match way {
                Way::Back if self.closed => Some((k + count - step) % count),
                Way::On if self.closed => Some((k + step) % count),
                Way::Back => k.checked_sub(step),
                Way::On => Some(k + step),
            };
            self.unit(at?)?.vector().try_normalize(0.0)
        })
    }
}

/// Which way along a curve.
#[derive(Debug, Clone, Copy)]
enum Way {
    Back,
    On,
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
    fn reversing_takes_marks_and_reasons_along() {
        let seam = |closed: bool, marked: usize| {
            let mut nodes = square().into_nodes();
            nodes[marked].bridged = true;
            Curve::new(nodes, closed).unwrap()
        };
        let bridged = |c: &Curve| -> Vec<(Point2, Point2)> {
            let marked = c.units().zip(c.nodes()).filter(|(_, n)| n.bridged);
            marked.map(|(u, _)| (u.start, u.end)).collect()
        };
        for (closed, marked) in [(false, 0), (false, 2), (true, 0), (true, 3)] {
            let curve = seam(closed, marked);
            let swapped: Vec<_> = bridged(&curve).into_iter().map(|(a, b)| (b, a)).collect();
            assert_eq!(swapped.len(), 1);
            assert_eq!(bridged(&curve.reversed()), swapped, "{closed} {marked}");
            assert_eq!(curve.reversed().reversed(), curve);
        }
        // An open curve has no unit behind its last node.
        assert!(bridged(&seam(false, 3)).is_empty());
        let ends = [Some(EndReason::RangeJump), None];
        assert_eq!(seam(false, 0).with_ends(ends).reversed().ends(), [ends[1], ends[0]]);
        assert_eq!(seam(true, 0).with_ends(ends).ends(), [None; 2]);
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
    fn repeated_nodes_do_not_change_sides() {
        let corners = [(0.0, 0.0), (0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (2.0, 2.0), (0.0, 2.0)];
        let (plain, repeated) = (square(), polyline(&corners, true));
        for (x, y) in [(-1.0, -1.0), (3.0, 3.0), (0.1, 0.2), (1.9, 1.8), (-1.0, 1.0), (3.0, 2.5)] {
            let p = Point2::new(x, y);
            let side = |c: &Curve| c.side_at(&c.foot(&p), &p);
            assert_eq!(side(&repeated), side(&plain), "{p}");
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
        let negative = Node::at(Point2::new(1.0, 0.0)).with_footprint(-1.0);
        let odd = vec![Node::at(Point2::origin()), negative];
        assert_eq!(
            Curve::new(odd, false).unwrap_err().to_string(),
            "the footprint of node 1 is -1; it must be a finite number of at least 0. Correct the \
             node, or leave it out"
        );
        let tilted = Node::at(Point2::origin()).with_normal(Some(Vector3::new(0.0, f32::NAN, 1.0)));
        let tilted = Curve::new(vec![tilted; 2], false).unwrap_err().to_string();
        assert!(tilted.starts_with("the normal of node 0 has the component NaN"), "{tilted}");
    }
}
