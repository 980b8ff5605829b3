//! Chains: nodes in the order of a curve.

use super::super::estimate::PlacedNode;
use super::super::measure::NONE;
use super::super::tuning::chain::*;
use crate::sequence::neighbours;
use transect_geometry::Vector2;

/// The numbers of nodes in the order of a curve.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Chain {
    pub nodes: Vec<u32>,
    pub closed: bool,
}

impl Chain {
    /// The pairs of nodes that follow each other.
    pub fn units<'a>(
        &'a self,
        nodes: &'a [PlacedNode],
    ) -> impl Iterator<Item = (&'a PlacedNode, &'a PlacedNode)> {
        let at = |k: &u32| &nodes[*k as usize];
        neighbours(&self.nodes, self.closed).map(move |(a, b)| (at(a), at(b)))
    }

    pub fn length(&self, nodes: &[PlacedNode]) -> f64 {
        self.units(nodes).map(|(a, b)| (b.position - a.position).norm()).sum()
    }

    /// Measured length in footprints: of a gap only the sample spacing at its ends counts.
    pub fn footprints(&self, nodes: &[PlacedNode]) -> f64 {
        let measured = |(a, b): (&PlacedNode, &PlacedNode)| {
            (b.position - a.position).norm().min(a.spacing.max(b.spacing))
        };
        let length: f64 = self.units(nodes).map(measured).sum();
        let footprint: f64 = self.nodes.iter().map(|k| nodes[*k as usize].evidence.footprint).sum();
        length * self.nodes.len() as f64 / footprint
    }

    /// Whether the chain is large enough to be a curve: of this many footprints, or confirmed.
    pub fn is_curve(&self, nodes: &[PlacedNode], shortest_footprints: f64) -> bool {
        let is_long = || self.footprints(nodes) >= shortest_footprints;
        self.nodes.len() >= MIN_NODES && (is_long() || self.is_confirmed(nodes))
    }

    /// Whether the chain has no gap, and is closed or measured by at least two views.
    fn is_confirmed(&self, nodes: &[PlacedNode]) -> bool {
        let mut evidence = self.nodes.iter().map(|&k| &nodes[k as usize].evidence);
        let view = evidence.clone().next().map(|e| e.last_view);
        let is_shared = evidence.any(|e| e.views > 1 || Some(e.last_view) != view);
        let is_gap = |(a, b): (&PlacedNode, &PlacedNode)| {
            (b.position - a.position).norm() > CONFIRMED_STEP * a.spacing.max(b.spacing)
        };
        (self.closed || is_shared) && !self.units(nodes).any(is_gap)
    }

    /// Whether several views measured a node of the chain.
    pub fn is_shared(&self, nodes: &[PlacedNode]) -> bool {
        self.nodes.iter().any(|&k| nodes[k as usize].evidence.views > 1)
    }

    /// Standard deviation of the views' systematic errors, in the mean of squares.
    pub fn mean_view_error(&self, nodes: &[PlacedNode]) -> f64 {
        let variances = self.nodes.iter().map(|&k| nodes[k as usize].evidence.view_variance);
        (variances.sum::<f64>() / self.nodes.len().max(1) as f64).sqrt()
    }

    /// Unit direction of the chain at one of its nodes, by the chord between its neighbours.
    pub fn chord(&self, nodes: &[PlacedNode], at: usize) -> Vector2 {
        let n = self.nodes.len();
        let (before, after) = if self.closed && n > 2 * CHORD_NODES {
            ((at + n - CHORD_NODES) % n, (at + CHORD_NODES) % n)
        } else {
            (at.saturating_sub(CHORD_NODES), (at + CHORD_NODES).min(n - 1))
        };
        let place = |k: usize| nodes[self.nodes[k] as usize].position;
        let own = nodes[self.nodes[at] as usize].tangent;
        (place(after) - place(before)).try_normalize(0.0).unwrap_or(own)
    }

    /// Mean direction of the nodes at one end, without the `cut` outermost ones.
    pub fn direction(&self, nodes: &[PlacedNode], at_end: bool, cut: usize) -> Vector2 {
        let sum = |numbers: &mut dyn Iterator<Item = &u32>| {
            let chosen = numbers.skip(cut).take(DIRECTION_NODES);
            chosen.map(|&k| nodes[k as usize].tangent).sum::<Vector2>()
        };
        let mean =
            if at_end { sum(&mut self.nodes.iter().rev()) } else { sum(&mut self.nodes.iter()) };
        mean.try_normalize(1e-9).unwrap_or_else(Vector2::x)
    }
}

/// Follows the links: open chains from their heads, then closed ones.
pub(super) fn trace(next: &[u32]) -> Vec<Chain> {
    let mut has_previous = vec![false; next.len()];
    for &n in next.iter().filter(|n| **n != NONE) {
        has_previous[n as usize] = true;
    }
    let mut visited = vec![false; next.len()];
    let mut chains = Vec::new();
    for closed in [false, true] {
        for start in 0..next.len() {
            if visited[start] || (!closed && has_previous[start]) {
                continue;
            }
            let mut nodes = Vec::new();
            let mut at = start as u32;
            while at != NONE && !visited[at as usize] {
                visited[at as usize] = true;
                nodes.push(at);
                at = next[at as usize];
            }
            chains.push(Chain { nodes, closed });
        }
    }
    chains
}

/// Longest first; equal lengths by the place of their first node.
pub(crate) fn by_length(nodes: &[PlacedNode], chains: Vec<Chain>) -> Vec<Chain> {
    let mut measured: Vec<(f64, Chain)> =
        chains.into_iter().map(|c| (c.length(nodes), c)).collect();
    let first =
        |c: &Chain| c.nodes.first().map(|&k| nodes[k as usize].position).unwrap_or_default();
    measured.sort_by(|(length_a, a), (length_b, b)| {
        let (p, q) = (first(a), first(b));
        length_b.total_cmp(length_a).then(p.x.total_cmp(&q.x)).then(p.y.total_cmp(&q.y))
    });
    measured.into_iter().map(|(_, c)| c).collect()
}
