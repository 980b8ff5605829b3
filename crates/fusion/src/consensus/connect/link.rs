//! Links between nodes: one successor and one predecessor each.
//!
//! Candidates are pairs that lie ahead of each other, and the units of all views' own curves,
//! carried over to the nodes that absorbed their ends. The views' curves lead across gaps of single
//! views and round sharp bends. The cheapest candidate comes first: cost is length, increased by
//! bends and near open ends of the views' curves.

use super::super::estimate::PlacedNode;
use super::super::measure::{NONE, Observations, Scale};
use super::super::tuning::link::*;
use crate::grid::PointGrid;
use crate::ground::Ground;
use transect_geometry::Point2;

/// Gives every node the footprint of the coarsest one whose sample it lies within.
///
/// A coarse node stands for the fine ones beside it and removes others on both sides. The remaining
/// fine ones are as far apart as the coarse samples are, which is no gap.
pub(super) fn spread_spacing(nodes: &mut [PlacedNode], scale: &Scale) {
    let positions: Vec<Point2> = nodes.iter().map(|k| k.position).collect();
    let grid = PointGrid::new(&positions, scale.spacing);
    for k in 0..nodes.len() {
        let PlacedNode { position, tangent, evidence, .. } = nodes[k];
        let footprint = evidence.footprint;
        let across = scale.across(evidence.random_sigma);
        grid.within(&position, footprint, |j, d| {
            let there = &mut nodes[j];
            let beside =
                there.tangent.dot(&tangent) >= scale.same_way && d.perp(&tangent).abs() <= across;
            if beside && there.spacing < footprint {
                there.spacing = footprint;
            }
        });
    }
}

/// Successor of every node, or [`NONE`].
pub(super) fn link(
    nodes: &[PlacedNode],
    absorbed_by: &[u32],
    observations: &Observations,
    ground: &Ground<'_>,
    scale: &Scale,
) -> Vec<u32> {
    let mut candidates = Candidates { nodes, ground, scale, all: Vec::new() };
    candidates.add_ahead();
    if scale.steps().witnessed_links {
        candidates.add_witnessed(absorbed_by, observations);
    }
    let mut next = vec![NONE; nodes.len()];
    let mut previous = vec![NONE; nodes.len()];
    let mut all = candidates.all;
    all.sort_unstable();
    for c in all {
        let (from, to) = (c.from as usize, c.to as usize);
        let back_and_forth = next[to] == c.from;
        if next[from] == NONE && previous[to] == NONE && !back_and_forth {
            next[from] = c.to;
            previous[to] = c.from;
        }
    }
    next
}

/// A possible link. Its order is the order in which links are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// The bits of the cost; a positive number's bits have its order. The highest bit marks bridged
    /// ground, which comes last: it never keeps measured nodes from each other.
    cost: u64,
    from: u32,
    to: u32,
}

/// A step between two nodes, with the cosines between it and the directions there.
struct Step {
    length: f64,
    leave: f64,
    arrive: f64,
}

impl Step {
    fn between(a: &PlacedNode, b: &PlacedNode) -> Self {
        let step = b.position - a.position;
        let length = step.norm();
        Self { length, leave: a.tangent.dot(&step) / length, arrive: b.tangent.dot(&step) / length }
    }
}

/// Possible links; those that several views witness come several times.
struct Candidates<'a> {
    nodes: &'a [PlacedNode],
    ground: &'a Ground<'a>,
    scale: &'a Scale,
    all: Vec<Candidate>,
}

impl Candidates<'_> {
    fn add(&mut self, from: usize, to: usize, cost: f64, bridged: bool) {
        if self.nodes[from].is_across_shadow(&self.nodes[to], self.ground, self.scale) {
            return;
        }
        let cost = cost.to_bits() | u64::from(bridged) << 63;
        self.all.push(Candidate { cost, from: from as u32, to: to as u32 });
    }

    /// Cost of a step: its length, more if it bends, and more for nodes of little support.
    fn cost(&self, a: &PlacedNode, b: &PlacedNode, step: &Step) -> f64 {
        let doubt = if self.scale.steps().end_doubt { DOUBT } else { 0.0 };
        let doubted = |k: &PlacedNode| 1.0 + doubt * (1.0 - k.evidence.support.min(1.0));
        step.length * (2.0 - step.leave) * (2.0 - step.arrive) * doubted(a) * doubted(b)
    }

    /// Pairs of nodes that lie ahead of each other.
    fn add_ahead(&mut self) {
        let (nodes, scale) = (self.nodes, self.scale);
        let positions: Vec<Point2> = nodes.iter().map(|k| k.position).collect();
        let grid = PointGrid::new(&positions, REACH_FOOTPRINTS * scale.spacing);
        for (k, here) in nodes.iter().enumerate() {
            let footprint = here.evidence.footprint;
            grid.within(&here.position, REACH_FOOTPRINTS * footprint, |j, d| {
                let there = &nodes[j];
                // Each pair once, from the node with the larger footprint, which looks farther.
                let mine = (there.evidence.footprint, k) < (footprint, j);
                if !mine || here.tangent.dot(&there.tangent) < LEAST_COSINE {
                    return;
                }
                let (from, to) = if d.dot(&here.tangent) > 0.0 { (k, j) } else { (j, k) };
                let step = Step::between(&nodes[from], &nodes[to]);
                if step.length > 0.0 && step.leave.min(step.arrive) > LEAST_COSINE {
                    self.add(from, to, self.cost(&nodes[from], &nodes[to], &step), false);
                }
            });
        }
    }

    /// The units of the views' own curves, between the nodes that absorbed their ends.
    fn add_witnessed(&mut self, absorbed_by: &[u32], observations: &Observations) {
        for (o, &from) in observations.all.iter().zip(absorbed_by) {
            let Some(&to) = absorbed_by.get(o.next as usize) else { continue };
            if from == to {
                continue;
            }
            let (a, b) = (&self.nodes[from as usize], &self.nodes[to as usize]);
            let step = Step::between(a, b);
            // Between nodes of one direction, a step to the side is a change of layer, not a bend.
            let straight = a.tangent.dot(&b.tangent) >= LEAST_COSINE;
            let least = if straight { SIDEWAYS } else { BACKWARD };
            if step.leave >= least && step.arrive >= least {
                let cost = WITNESSED * self.cost(a, b, &step);
                self.add(from as usize, to as usize, cost, o.bridged);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::consensus::options::ConsensusOptions;
    use transect_geometry::Vector2;

    #[test]
    fn a_curve_goes_on_where_a_view_saw_it_well_and_not_where_another_overshoots() {
        let node = |x: f64, y: f64, support: f64| {
            let mut node = PlacedNode::at(Point2::new(x, y), Vector2::x(), 0.02);
            node.evidence.support = support;
            node
        };
        // Two layers run into one node; the one seen at a view's end alone is a little nearer.
        let nodes = [node(0.0, 0.002, 1.0), node(0.001, -0.002, 0.05), node(0.02, 0.0, 2.0)];
        let options = ConsensusOptions::default();
        let scale =
            Scale { spacing: 0.02, threshold: 0.001, same_way: 0.6, settled: false, options };
        let (observations, grid) = (Observations::default(), PointGrid::new(&[], 1.0));
        let next = link(&nodes, &[], &observations, &Ground::new(&observations, &grid), &scale);
        assert_eq!(next, [2, NONE, NONE]);
    }
}
