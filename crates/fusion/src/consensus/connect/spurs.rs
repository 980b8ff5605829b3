//! Spurs: open chains along a closed one that one view alone measured, or that have little support.
//!
//! Between two boundaries with their solid on the same side, a third runs the other way. Where no
//! view measured one, the spur is an error of its view.

use super::super::estimate::PlacedNode;
use super::super::measure::Scale;
use super::super::tuning::spurs::*;
use super::chain::Chain;
use super::cover::Cover;

/// Removes spurs.
pub(super) fn without_spurs(
    nodes: &[PlacedNode],
    mut chains: Vec<Chain>,
    scale: &Scale,
) -> Vec<Chain> {
    let weak = |c: &Chain| {
        let count = c.nodes.len() as f64;
        let evidence = || c.nodes.iter().map(|&k| &nodes[k as usize].evidence);
        let views: u32 = evidence().map(|e| e.views).sum();
        let support: f64 = evidence().map(|e| e.support).sum();
        !c.closed && (f64::from(views) <= MAX_VIEWS * count || support <= MAX_SUPPORT * count)
    };
    if !chains.iter().any(weak) || !chains.iter().any(|c| c.closed) {
        return chains;
    }
    let mut cover = Cover::new(nodes, &chains, scale);
    chains.iter().filter(|c| c.closed).for_each(|c| cover.accept(c));
    // The largest plausible offset: the overlap threshold, or more where the views err by more.
    let max_offset = |k: u32| {
        let view_sigma = nodes[k as usize].evidence.view_variance.sqrt();
        scale.threshold.max(scale.options.threshold_spreads * view_sigma)
    };
    let beside = |k: &&u32| cover.lies_within(**k, THRESHOLDS * max_offset(**k));
    chains.retain(|c| {
        let is_beside = || c.nodes.iter().filter(beside).count() as f64;
        !(weak(c) && is_beside() >= BESIDE_SHARE * c.nodes.len() as f64)
    });
    chains
}
