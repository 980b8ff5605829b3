//! From chains to curves: nodes in between where chords would miss the curve, marks of bridged
//! ground, and the reasons why open curves end.

use super::super::connect::{Chain, by_length};
use super::super::estimate::PlacedNode;
use super::super::measure::{Observations, Scale, ViewEnd};
use super::super::tuning::output::*;
use crate::grid::PointGrid;
use crate::ground::Ground;
use transect_geometry::{Curve, EndReason, Node, Point2};

/// The curves of the chains, longest first, and the number of nodes of chains that are no curve.
pub(super) fn curves(
    nodes: &[PlacedNode],
    chains: Vec<Chain>,
    (ground, scale): (&Ground<'_>, &Scale),
    ends: &Ends<'_>,
) -> (Vec<Curve>, usize) {
    let (mut curves, mut refused) = (Vec::new(), 0);
    for chain in &by_length(nodes, chains) {
        let nodes = curve_nodes(nodes, chain, ground, scale);
        match Curve::new(nodes, chain.closed) {
            Ok(curve) => curves.push(curve.with_ends(ends.of(chain))),
            Err(_) => refused += chain.nodes.len(),
        }
    }
    (curves, refused)
}

/// The nodes of a chain, with those that belong between them.
fn curve_nodes(
    nodes: &[PlacedNode],
    chain: &Chain,
    ground: &Ground<'_>,
    scale: &Scale,
) -> Vec<Node> {
    let middle_nodes = scale.steps().middle_nodes;
    let mut result: Vec<Node> = Vec::with_capacity(2 * chain.nodes.len());
    for (here, next) in chain.units(nodes) {
        let gap = bridge(here, next, ground, scale);
        result.push(here.node().with_bridged(gap.is_some()));
        result.extend(gap.or_else(|| between(here, next).filter(|_| middle_nodes)));
    }
    let last = chain.nodes.last().filter(|_| !chain.closed);
    result.extend(last.map(|&k| nodes[k as usize].node()));
    result
}

/// The mark of a gap: a node without views, if no view measured the ground between two neighbours.
fn bridge(a: &PlacedNode, b: &PlacedNode, ground: &Ground<'_>, scale: &Scale) -> Option<Node> {
    let (unit, footprint) = a.unit_to(b);
    let gap = unit.vector().norm();
    let across = scale.across(a.sigma.max(b.sigma)).max(MEASURED_FOOTPRINTS * footprint);
    let middle = || {
        // Only the two ends and their distance are known.
        Node::at(a.position + (b.position - a.position) * 0.5)
            .with_sigma((0.25 * gap) as f32)
            .with_footprint(gap as f32)
            .with_weight(0.0)
            .with_views(0)
            .with_bridged(true)
    };
    (gap > GAP_FOOTPRINTS * footprint && !ground.is_measured(&unit, footprint, across)).then(middle)
}

/// The middle of the cubic with the places and directions of two nodes, where their chord misses
/// it.
fn between(a: &PlacedNode, b: &PlacedNode) -> Option<Node> {
    let step = b.position - a.position;
    let length = step.norm();
    let least = SMOOTH_COSINE * length;
    if a.tangent.dot(&step) < least || b.tangent.dot(&step) < least {
        return None;
    }
    let middle = (a.tangent - b.tangent) * (0.125 * length);
    let by_slopes = 0.125 * length * a.slope_sigma().hypot(b.slope_sigma());
    let sigma = 0.5 * (a.sigma + b.sigma);
    let least = (CHORD_SHARE * sigma).max(SLOPE_SIGMAS * by_slopes);
    (step.perp(&middle).abs() > least * length).then(|| {
        let lighter = if a.evidence.weight < b.evidence.weight { a.node() } else { b.node() };
        lighter.moved_to(a.position + step * 0.5 + middle).with_sigma(sigma.hypot(by_slopes) as f32)
    })
}

/// Where the views' curves begin and end.
pub(super) struct Ends<'a> {
    nodes: &'a [PlacedNode],
    all: Vec<ViewEnd>,
    /// The node that stands for each.
    at: Vec<Point2>,
    grid: PointGrid,
}

impl<'a> Ends<'a> {
    pub fn new(observations: &Observations, absorbed_by: &[u32], nodes: &'a [PlacedNode]) -> Self {
        let all = observations.ends.clone();
        let by = |e: &ViewEnd| absorbed_by.get(e.observation as usize);
        let place = |e: &ViewEnd| by(e).and_then(|k| nodes.get(*k as usize)).map(|k| k.position);
        let at: Vec<Point2> = all.iter().map(|e| place(e).unwrap_or_default()).collect();
        let grid = PointGrid::new(&at, END_FOOTPRINTS * observations.spacing());
        Self { nodes, all, at, grid }
    }

    /// Why a chain begins and ends where it does.
    fn of(&self, chain: &Chain) -> [Option<EndReason>; 2] {
        match chain.nodes.as_slice() {
            [first, .., last] if !chain.closed => {
                [self.near(*first, false), self.near(*last, true)]
            }
            _ => [None; 2],
        }
    }

    /// The reason of the nearest end of a view's curve; of several in one place, the first in the
    /// order of reasons.
    fn near(&self, k: u32, is_last: bool) -> Option<EndReason> {
        let here = &self.nodes[k as usize];
        let mut nearest: Option<(f64, EndReason)> = None;
        self.grid.within(&here.position, END_FOOTPRINTS * here.evidence.footprint, |e, _| {
            let end = self.all[e];
            let found = ((self.at[e] - here.position).norm(), end.reason);
            if end.is_last == is_last && nearest.is_none_or(|n| found < n) {
                nearest = Some(found);
            }
        });
        nearest.map(|(_, reason)| reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_geometry::Vector2;

    #[test]
    fn directions_of_noisy_nodes_bend_no_long_step() {
        let node = |x: f64, slope: f64, correlation: f64| {
            let place = Point2::new(x, 0.0);
            let mut node = PlacedNode::at(place, Vector2::new(1.0, slope).normalize(), 0.01);
            (node.sigma, node.correlation) = (5e-4, correlation);
            node
        };
        let middle =
            |correlation| between(&node(0.0, 0.05, correlation), &node(0.5, -0.05, correlation));
        assert!(middle(0.01).is_none(), "fits of a centimetre do not know this bend");
        let bend = middle(1.0).unwrap();
        assert!((bend.position.y - 0.05 / 4.0 * 0.5).abs() < 1e-4);
        assert!(bend.sigma > 5e-4 && bend.sigma < 6e-4);
        assert!(middle(0.0).is_none(), "a node of no fit");
    }
}
