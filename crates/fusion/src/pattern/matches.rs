//! Where the nodes of one curve lie on another (dissertation 5.5.1).

use super::OverlapTolerance;
use crate::envelopes::UnitIndex;
use crate::sequence::arc_lengths;
use transect_geometry::{Curve, Point2, Vector2};

/// A curve with the arc length at each of its nodes, so that places on it are single numbers.
pub(super) struct Measured<'a> {
    pub(super) curve: &'a Curve,
    /// Arc length at each node, from 0 at the first; in the model's length unit.
    arc: Vec<f64>,
    /// Length of the whole curve.
    pub(super) length: f64,
    /// Unit directions of the curve units; zero for a unit without length.
    directions: Vec<Vector2>,
}

impl<'a> Measured<'a> {
    pub(super) fn new(curve: &'a Curve) -> Self {
        let units = || curve.units().map(|unit| unit.vector());
        let arc = arc_lengths(units().map(|unit| unit.norm()));
        let length = arc[arc.len() - 1];
        let directions = units().map(|unit| unit.try_normalize(0.0).unwrap_or_default());
        Self { curve, arc, length, directions: directions.collect() }
    }

    /// The directions in which the curve arrives at and leaves a node.
    fn directions_at(&self, node: usize) -> [Option<&Vector2>; 2] {
        let closing = self.directions.last().filter(|_| self.curve.is_closed());
        let arriving = node.checked_sub(1).map_or(closing, |unit| self.directions.get(unit));
        [arriving, self.directions.get(node)]
    }

    /// The place where a node of another curve lies on this one, if it does.
    ///
    /// Of the given units, in order, that are near enough and run the same way, the nearest one
    /// decides.
    fn place_of(&self, node: &Point2, ways: [Option<&Vector2>; 2], near: &Near<'_>) -> Option<f64> {
        let mut nearest = None;
        for &index in near.units {
            let (unit, along) = (near.index.unit(index)?, &self.directions[index]);
            let agrees = ways.iter().flatten().any(|way| way.dot(along) >= near.limits.min_cosine);
            if !agrees {
                continue;
            }
            let x = unit.parameter(node).clamp(0.0, 1.0);
            let distance = (node - unit.at(x)).norm();
            let limit = nearest.map_or(near.limits.distance, |(least, _)| least);
            if distance < limit || (distance == limit && nearest.is_none()) {
                let step = self.arc[index + 1] - self.arc[index];
                nearest = Some((distance, self.arc[index] + x * step));
            }
        }
        nearest.map(|(_, place)| place)
    }

    /// For each node: its arc length, and where it lies on the other curve.
    ///
    /// Only nodes and units in the rectangle common to both grown envelopes are looked at (5.3.2).
    fn nodes_on(&self, other: &Measured<'_>, limits: &Limits) -> NodePlaces {
        let around_other = other.curve.envelope().grown(limits.distance);
        let around_own = self.curve.envelope().grown(limits.distance);
        let units_of_other = UnitIndex::within(other.curve, &around_own);
        let mut units = Vec::new();
        let nodes = self.curve.nodes().iter().enumerate();
        let place = |(index, node): (usize, &transect_geometry::Node)| {
            let on_other = around_other.contains(&node.position).then(|| {
                units_of_other.near(&node.position, limits.distance, &mut units);
                let near = Near { index: &units_of_other, units: &units, limits };
                other.place_of(&node.position, self.directions_at(index), &near)
            });
            (self.arc[index], on_other.flatten())
        };
        NodePlaces(nodes.map(place).collect())
    }
}

/// The units that may be near a node, and how near they must be.
struct Near<'a> {
    index: &'a UnitIndex,
    units: &'a [usize],
    limits: &'a Limits,
}

/// The tolerances in the form in which they are compared.
struct Limits {
    distance: f64,
    min_cosine: f64,
}

/// The nodes of a curve in order: arc length, and place on the other curve if enclosed.
pub(super) struct NodePlaces(Vec<(f64, Option<f64>)>);

impl NodePlaces {
    /// Whether a node strictly within a stretch is not enclosed. The stretch may begin in any round
    /// of a closed curve, of which `length` is the length, and run over its node 0.
    pub(super) fn unenclosed(&self, from: f64, step: f64, length: f64) -> bool {
        let begin = if from < 0.0 || from > length { from.rem_euclid(length) } else { from };
        let over = begin + step - length;
        self.unenclosed_between(begin, begin + step) || self.unenclosed_between(-1.0, over)
    }

    fn unenclosed_between(&self, from: f64, to: f64) -> bool {
        let first = self.0.partition_point(|(arc, _)| *arc <= from);
        let mut nodes = self.0[first..].iter().take_while(|(arc, _)| *arc < to);
        nodes.any(|(_, place)| place.is_none())
    }
}

/// A node of either curve that lies on the other one: the same spot on both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Match {
    /// Arc length on the first curve.
    pub(super) on_a: f64,
    /// Arc length on the second curve.
    pub(super) on_b: f64,
}

/// All matches in order along the first curve, and the nodes of both.
pub(super) fn find(
    a: &Measured<'_>,
    b: &Measured<'_>,
    tolerance: &OverlapTolerance,
) -> (Vec<Match>, NodePlaces, NodePlaces) {
    let min_cosine = tolerance.max_angle_rad().cos();
    let limits = Limits { distance: tolerance.distance(), min_cosine };
    let nodes_a = a.nodes_on(b, &limits);
    let nodes_b = b.nodes_on(a, &limits);
    let from_a = nodes_a.0.iter().filter_map(|&(on_a, place)| Some(Match { on_a, on_b: place? }));
    let from_b = nodes_b.0.iter().filter_map(|&(on_b, place)| Some(Match { on_a: place?, on_b }));
    let mut matches: Vec<_> = from_a.chain(from_b).collect();
    matches.sort_by(|p, q| p.on_a.total_cmp(&q.on_a).then(p.on_b.total_cmp(&q.on_b)));
    (matches, nodes_a, nodes_b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use transect_geometry::Node;

    fn curves() -> impl Strategy<Value = Curve> {
        let step = (-0.5..1.0, -0.4..0.4);
        let steps = prop::collection::vec(step, 3..40);
        (steps, any::<bool>()).prop_map(|(steps, closed)| {
            let mut at = Point2::origin();
            let node = |(x, y): (f64, f64)| {
                at += Vector2::new(x, y);
                Node::at(at)
            };
            Curve::new(steps.into_iter().map(node).collect(), closed).unwrap()
        })
    }

    proptest! {
        #[test]
        fn the_index_finds_the_places_a_look_at_all_units_finds(
            a in curves(), b in curves(), distance in 0.0..0.8,
        ) {
            let (a, b) = (Measured::new(&a), Measured::new(&b));
            let limits = Limits { distance, min_cosine: 0.5 };
            let all: Vec<_> = (0..b.directions.len()).collect();
            let index = UnitIndex::new([b.curve]);
            let near = Near { index: &index, units: &all, limits: &limits };
            let found = a.nodes_on(&b, &limits);
            for (index, (_, place)) in found.0.iter().enumerate() {
                let node = a.curve.nodes()[index].position;
                let expected = b.place_of(&node, a.directions_at(index), &near);
                prop_assert_eq!(*place, expected);
            }
        }
    }
}
