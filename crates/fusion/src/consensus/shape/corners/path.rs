//! The nodes of a chain as a path, and the stretches of it that are sides of corners.

use super::super::super::connect::Chain;
use super::super::super::estimate::PlacedNode;
use super::super::super::tuning::corners::*;
use super::side::Side;

/// A chain and how far apart its nodes are.
pub(super) struct Path<'a> {
    nodes: &'a [PlacedNode],
    chain: &'a Chain,
    /// Length of the unit that begins at each node; that of the last is 0 on open chains.
    units: Vec<f64>,
}

/// Consecutive nodes of a chain that follow one side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch {
    pub first: usize,
    pub count: usize,
    pub side: Side,
}

impl<'a> Path<'a> {
    pub fn new(nodes: &'a [PlacedNode], chain: &'a Chain) -> Self {
        let lengths = chain.units(nodes).map(|(a, b)| (b.position - a.position).norm());
        let mut units: Vec<f64> = lengths.collect();
        units.resize(chain.nodes.len(), 0.0);
        Self { nodes, chain, units }
    }

    pub fn len(&self) -> usize {
        self.units.len()
    }

    pub fn is_closed(&self) -> bool {
        self.chain.closed
    }

    /// A node by its number in the chain, which goes round on closed ones.
    pub fn node(&self, k: usize) -> &'a PlacedNode {
        &self.nodes[self.chain.nodes[k % self.len()] as usize]
    }

    /// Nodes in a row.
    pub fn nodes(&self, first: usize, count: usize) -> Vec<&'a PlacedNode> {
        (first..first + count).map(|k| self.node(k)).collect()
    }

    /// Length of the way from a node over some units.
    pub fn way(&self, first: usize, units: usize) -> f64 {
        (first..first + units).map(|k| self.units[k % self.len()]).sum()
    }

    /// Which nodes are near a turn of more than an angle. The path has at least `LOOK_NODES` nodes.
    fn near_turns(&self, cosine: f64) -> Vec<bool> {
        let n = self.len();
        let closed = self.chain.closed;
        let mut near = vec![false; n];
        for k in if closed { 0..n } else { LOOK_NODES..n.saturating_sub(LOOK_NODES) } {
            let (before, after) = (self.node(k + n - LOOK_NODES), self.node(k + LOOK_NODES));
            if before.tangent.dot(&after.tangent) < cosine {
                let around = (k + n).saturating_sub(AROUND_NODES)..=k + n + AROUND_NODES;
                around
                    .filter(|j| closed || (n..2 * n).contains(j))
                    .for_each(|j| near[j % n] = true);
            }
        }
        near
    }

    /// The sides near turns, in the order of the chain. No two share a node.
    pub fn stretches(&self, cosine: f64) -> Vec<Stretch> {
        let n = self.len();
        if n < 2 * SEED_NODES {
            return Vec::new();
        }
        let mut free = self.near_turns(cosine);
        if !free.contains(&true) {
            return Vec::new();
        }
        let starts = if self.chain.closed { n } else { n - SEED_NODES + 1 };
        let mut seeds: Vec<(f64, usize)> =
            (0..starts).filter_map(|k| Some((self.seed(k, &free)?, k))).collect();
        seeds.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut stretches = Vec::new();
        for (_, k) in seeds {
            if (k..k + SEED_NODES).all(|j| free[j % n]) {
                let stretch = self.grow(k, &free);
                if let Some(s) = &stretch {
                    (s.first..s.first + s.count).for_each(|j| free[j % n] = false);
                }
                stretches.extend(stretch);
            }
        }
        stretches.sort_by_key(|s| s.first);
        stretches
    }

    /// How far off a side the nodes of a row are at most, in shares of the limit; `None` if they
    /// are no side.
    fn seed(&self, first: usize, free: &[bool]) -> Option<f64> {
        if !(first..first + SEED_NODES).all(|k| free[k % self.len()]) {
            return None;
        }
        let nodes = self.nodes(first, SEED_NODES);
        let side = Side::new(&nodes)?;
        let off = nodes.iter().map(|k| side.off(k)).fold(0.0, f64::max);
        let steps = (first..first + SEED_NODES - 1).all(|k| self.is_step(k));
        let one_way = nodes.iter().all(|k| self.runs_along(&side, k));
        (off <= 1.0 && steps && one_way).then_some(off)
    }

    /// Whether the unit that begins at a node is no gap.
    pub fn is_step(&self, k: usize) -> bool {
        self.node(k).is_beside(self.node(k + 1))
    }

    fn runs_along(&self, side: &Side, k: &PlacedNode) -> bool {
        let (x, _) = side.offsets(&k.position);
        k.tangent.dot(&side.at(x).direction) >= SAME_SIDE
    }

    /// The longest side that holds a seed.
    fn grow(&self, seed: usize, free: &[bool]) -> Option<Stretch> {
        let n = self.len();
        // Counted from one round later, so that it can begin before the first node.
        let (mut first, mut count) = (seed + n, SEED_NODES);
        let mut side = Side::new(&self.nodes(first, count))?;
        let mut ends = [true; 2];
        while ends.contains(&true) && count < n {
            for (at_end, open) in [false, true].into_iter().zip(&mut ends) {
                let (next, step) = if at_end {
                    (first + count, first + count - 1)
                } else {
                    (first - 1, first - 1)
                };
                let inside = self.chain.closed || (n..2 * n).contains(&next);
                let node = self.node(next);
                let long = side.length + self.units[step % n] > LONGEST_SIDE * side.footprint;
                let joins = inside && free[next % n] && !long && self.is_step(step) && count < n;
                *open = *open && joins && side.off(node) <= 1.0 && self.runs_along(&side, node);
                if *open {
                    (first, count) = (if at_end { first } else { first - 1 }, count + 1);
                    side = Side::new(&self.nodes(first, count))?;
                }
            }
        }
        Some(Stretch { first: first % n, count, side })
    }
}
