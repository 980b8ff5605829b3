//! Hooks: short units that run backwards, as two views' nodes of one corner in the wrong order do.

use super::super::estimate::PlacedNode;
use super::super::tuning::hooks::*;
use super::chain::Chain;

/// Removes one node of each hook: the one with the smaller weight.
pub(super) fn remove_hooks(nodes: &[PlacedNode], chain: &mut Chain) {
    for _ in 0..PASSES {
        let n = chain.nodes.len();
        let units = if chain.closed { n } else { n.saturating_sub(1) };
        let mut goes = vec![false; n];
        for a in 0..units {
            let b = (a + 1) % n;
            let weight = |k: usize| nodes[chain.nodes[k] as usize].evidence.weight;
            if !goes[a] && steps_back(nodes, chain, a) {
                goes[if weight(a) < weight(b) { a } else { b }] = true;
            }
        }
        if !goes.contains(&true) || n < MIN_NODES {
            return;
        }
        let mut goes = goes.iter();
        chain.nodes.retain(|_| goes.next() != Some(&true));
    }
}

/// Whether the unit behind `a` is short and runs against the way from the node before it to the
/// node behind it.
fn steps_back(nodes: &[PlacedNode], chain: &Chain, a: usize) -> bool {
    let n = chain.nodes.len();
    let at = |k: usize| &nodes[chain.nodes[k % n] as usize];
    if !chain.closed && (a == 0 || a + 2 >= n) {
        return false;
    }
    let (p, q) = (at(a), at(a + 1));
    let step = q.position - p.position;
    let around = at(a + 2).position - at(a + n - 1).position;
    let footprint = p.evidence.footprint.max(q.evidence.footprint);
    step.norm() < SHORT_FOOTPRINTS * footprint && step.dot(&around) < 0.0
}
