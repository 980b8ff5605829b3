//! Links between kept nodes: one successor and one predecessor each.
//!
//! Candidates are pairs that lie ahead of each other, and every unit of every view's own curve
//! carried over to the nodes that absorbed its ends: the views' connectivity bridges gaps of single
//! views and goes round sharp bends. Shortest first, longer when bent and where only ends of views'
//! curves lie.

use super::observations::{NONE, Observations};
use super::{Kept, Scale};
use crate::grid::PointGrid;
use transect_geometry::Point2;

/// How far ahead a node looks for its successor, in footprints.
const REACH_FOOTPRINTS: f64 = 3.0;

/// Smallest cosine between the directions of linked nodes, and between them and the step, without a
/// view's own word for it.
const SMALLEST_TURN_COSINE: f64 = 0.5;

/// How far behind its start a carried-over unit may end, as a cosine: bends at thin tips.
const BACKWARD: f64 = -0.2;

/// Smallest cosine between a step and the directions of two nodes that share theirs.
const SIDEWAYS: f64 = 0.3;

/// A carried-over unit counts as this share of its length.
const WITNESSED: f64 = 0.7;

/// A link counts as longer by this share of its length for each of its nodes that has no credit: what
/// lies near open ends, where scanners overshoot, is linked last. Four follows a real scanner's better
/// views a little more closely, and loses corners that views saw with few samples.
const DOUBT: f64 = 1.0;

/// Gives every node the footprint of the coarsest one whose sample it lies within.
///
/// A coarse node stands for the fine ones beside it and leaves others out on both sides. What is left
/// of the fine ones is as far apart as the coarse samples are, and no gap.
pub(super) fn spread_spacing(kept: &mut [Kept], scale: &Scale) {
    let positions: Vec<Point2> = kept.iter().map(|k| k.position).collect();
    let grid = PointGrid::new(&positions, scale.spacing);
    for k in 0..kept.len() {
        let Kept { position, tangent, footprint, cluster_sigma, room, .. } = kept[k];
        let across = scale.across(cluster_sigma, room);
        grid.within(&position, footprint, |j, d| {
            let there = &mut kept[j];
            let beside =
                there.tangent.dot(&tangent) >= scale.same_way && d.perp(&tangent).abs() <= across;
            if beside && there.spacing < footprint {
                there.spacing = footprint;
            }
        });
    }
}

/// Successor of every kept node, or [`NONE`].
pub(super) fn link(
    kept: &[Kept],
    absorbed_by: &[u32],
    observations: &Observations,
    scale: &Scale,
) -> Vec<u32> {
    let mut candidates = Candidates::new(kept.len());
    let doubt = if scale.steps.link_doubt { DOUBT } else { 0.0 };
    ahead(kept, scale, &mut candidates, doubt);
    if scale.steps.witnessed_links {
        witnessed(kept, absorbed_by, observations, &mut candidates, doubt);
    }
    let mut next = vec![NONE; kept.len()];
    let mut previous = vec![NONE; kept.len()];
    for c in candidates.cheapest_first() {
        let (from, to) = (c.from as usize, c.to as usize);
        let back_and_forth = next[to] == c.from;
        if next[from] == NONE && previous[to] == NONE && !back_and_forth {
            next[from] = c.to;
            previous[to] = c.from;
        }
    }
    next
}

/// A possible link. Its order is that in which links are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// The bits of the cost, which is positive, so that they have its order. Bridged ground, by the
    /// highest bit, comes last: it never keeps seen nodes from each other.
    cost: u64,
    from: u32,
    to: u32,
}

/// Possible links, each pair of nodes once at its least cost: many views witness the same one.
#[derive(Debug)]
struct Candidates {
    /// Each with the number of an earlier one from the same node, or [`NONE`].
    all: Vec<(Candidate, u32)>,
    /// The last one from each node.
    last: Vec<u32>,
}

impl Candidates {
    fn new(nodes: usize) -> Self {
        Self { all: Vec::with_capacity(4 * nodes), last: vec![NONE; nodes] }
    }

    fn add(&mut self, (from, to): (usize, usize), cost: f64, bridged: bool) {
        let cost = cost.to_bits() | u64::from(bridged) << 63;
        let mut at = self.last[from];
        while let Some((candidate, earlier)) = self.all.get_mut(at as usize) {
            if candidate.to == to as u32 {
                candidate.cost = candidate.cost.min(cost);
                return;
            }
            at = *earlier;
        }
        let number = self.all.len() as u32;
        let candidate = Candidate { cost, from: from as u32, to: to as u32 };
        self.all.push((candidate, std::mem::replace(&mut self.last[from], number)));
    }

    fn cheapest_first(self) -> Vec<Candidate> {
        let mut all: Vec<Candidate> = self.all.into_iter().map(|(c, _)| c).collect();
        all.sort_unstable();
        all
    }
}

/// Cost of a step between two nodes, from its length and the cosines between it and their directions.
fn cost(a: &Kept, b: &Kept, distance: f64, (leave, arrive): (f64, f64), doubt: f64) -> f64 {
    let doubted = |k: &Kept| 1.0 + doubt * (1.0 - k.credit.min(1.0));
    distance * (2.0 - leave) * (2.0 - arrive) * doubted(a) * doubted(b)
}

/// Pairs of nodes that lie ahead of each other.
fn ahead(kept: &[Kept], scale: &Scale, candidates: &mut Candidates, doubt: f64) {
    let positions: Vec<Point2> = kept.iter().map(|k| k.position).collect();
    let grid = PointGrid::new(&positions, REACH_FOOTPRINTS * scale.spacing);
    for (k, here) in kept.iter().enumerate() {
        let reach = REACH_FOOTPRINTS * here.footprint;
        grid.within(&here.position, reach, |j, d| {
            let there = &kept[j];
            // Each pair once, from the node with the larger footprint, which looks farther.
            let mine = (there.footprint, k) < (here.footprint, j);
            if !mine || here.tangent.dot(&there.tangent) < SMALLEST_TURN_COSINE {
                return;
            }
            let distance = d.norm();
            if distance <= 0.0 {
                return;
            }
            let (from, to) = if d.dot(&here.tangent) > 0.0 { (k, j) } else { (j, k) };
            let step = kept[to].position - kept[from].position;
            let (leave, arrive) =
                (kept[from].tangent.dot(&step) / distance, kept[to].tangent.dot(&step) / distance);
            if leave.min(arrive) > SMALLEST_TURN_COSINE {
                candidates.add(
                    (from, to),
                    cost(&kept[from], &kept[to], distance, (leave, arrive), doubt),
                    false,
                );
            }
        });
    }
}

/// The views' own curve units, between the nodes that absorbed their ends.
fn witnessed(
    kept: &[Kept],
    absorbed_by: &[u32],
    observations: &Observations,
    candidates: &mut Candidates,
    doubt: f64,
) {
    for (o, &from) in observations.all.iter().zip(absorbed_by) {
        let Some(&to) = absorbed_by.get(o.next as usize) else { continue };
        if from == to {
            continue;
        }
        let (a, b) = (&kept[from as usize], &kept[to as usize]);
        let step = b.position - a.position;
        let distance = step.norm();
        let (leave, arrive) = (a.tangent.dot(&step) / distance, b.tangent.dot(&step) / distance);
        // Between nodes of one direction a step to the side is a change of layer, not a bend.
        let straight = a.tangent.dot(&b.tangent) >= SMALLEST_TURN_COSINE;
        let least = if straight { SIDEWAYS } else { BACKWARD };
        if leave >= least && arrive >= least {
            let cost = WITNESSED * cost(a, b, distance, (leave, arrive), doubt);
            candidates.add((from as usize, to as usize), cost, o.bridged);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_geometry::Vector2;

    #[test]
    fn a_curve_goes_on_where_a_view_saw_it_well_and_not_where_another_overshoots() {
        let node = |x: f64, y: f64, credit: f64| Kept {
            credit,
            ..Kept::new(Point2::new(x, y), Vector2::x(), 0.02)
        };
        // Two layers run into one node; the one seen at a view's end alone is a little nearer.
        let kept = [node(0.0, 0.002, 1.0), node(0.001, -0.002, 0.05), node(0.02, 0.0, 2.0)];
        let scale = Scale {
            spacing: 0.02,
            threshold: 0.001,
            threshold_spreads: 8.0,
            same_way: 0.6,
            steps: super::super::Steps::ALL,
        };
        let next = link(&kept, &[], &Observations::default(), &scale);
        assert_eq!(next, [2, NONE, NONE]);
    }
}
