//! Hooks: short units that run backwards or aside, as two views' nodes of one corner in the wrong
//! order do.
//!
//! Two places closer than the errors of both tell no direction. The errors of views count, too.

use super::super::estimate::PlacedNode;
use super::super::tuning::hooks::*;
use super::chain::Chain;
use transect_geometry::Vector2;

/// Removes one node of each hook, the one with the smaller weight, until none is left.
pub(super) fn remove_hooks(nodes: &[PlacedNode], chain: &mut Chain) {
    while chain.nodes.len() >= MIN_NODES {
        let n = chain.nodes.len();
        let units = if chain.closed { n } else { n - 1 };
        let mut goes = vec![false; n];
        for a in 0..units {
            let b = (a + 1) % n;
            let weight = |k: usize| nodes[chain.nodes[k] as usize].evidence.weight;
            if !goes[a] && is_hook(nodes, chain, a) {
                goes[if weight(a) < weight(b) { a } else { b }] = true;
            }
        }
        if !goes.contains(&true) {
            return;
        }
        let mut goes = goes.iter();
        chain.nodes.retain(|_| goes.next() != Some(&true));
    }
}

/// Whether the unit behind `a` is a hook. It runs against the way from the node before it to the
/// node behind it, and is far shorter than the footprint. Or it turns by more than 90 degrees from
/// a neighbour, and is shorter than the errors of both its nodes together.
fn is_hook(nodes: &[PlacedNode], chain: &Chain, a: usize) -> bool {
    let n = chain.nodes.len();
    let at = |k: usize| &nodes[chain.nodes[k % n] as usize];
    if !chain.closed && (a == 0 || a + 2 >= n) {
        return false;
    }
    let [before, p, q, after] = [a + n - 1, a, a + 1, a + 2].map(at);
    let step = q.position - p.position;
    let short = SHORT_FOOTPRINTS * p.evidence.footprint.max(q.evidence.footprint);
    let is_against = |other: Vector2| step.dot(&other) < 0.0;
    let turns =
        || is_against(p.position - before.position) || is_against(after.position - q.position);
    step.norm() < short && is_against(after.position - before.position)
        || step.norm() < p.sigma.hypot(q.sigma) && turns()
}
