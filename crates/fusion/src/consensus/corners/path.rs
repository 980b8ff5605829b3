//! The nodes of a piece as a path, and the stretches of it that are sides of corners.

use super::super::Kept;
use super::super::pieces::Piece;
use super::side::Side;

/// Nodes before and after one between which a turn shows that a corner may be near.
const LOOK: usize = 4;

/// Nodes on each side of a turn among which sides are looked for.
const AROUND: usize = 16;

/// Nodes with which a side begins.
const SEED: usize = 4;

/// Longest side, in footprints: what is farther away says little of the corner.
const LONGEST_SIDE: f64 = 10.0;

/// Smallest cosine between the direction of a side and those of its nodes (25 degrees).
const SAME_SIDE: f64 = 0.906;

/// Longest step along a side and between two, in footprints: beyond it nobody saw the ground between.
const LONGEST_STEP: f64 = 3.0;

/// A piece and how far apart its nodes are.
pub(super) struct Path<'a> {
    pub steps: &'a super::super::Steps,
    kept: &'a [Kept],
    piece: &'a Piece,
    /// Length of the unit that begins at each node; that of the last is 0 on open pieces.
    units: Vec<f64>,
}

/// Consecutive nodes of a piece that follow one side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch {
    pub first: usize,
    pub count: usize,
    pub side: Side,
}

impl<'a> Path<'a> {
    pub fn new(kept: &'a [Kept], piece: &'a Piece, steps: &'a super::super::Steps) -> Self {
        let n = piece.nodes.len();
        let place = |k: usize| kept[piece.nodes[k] as usize].position;
        let length = |k: usize| match k + 1 < n {
            true => (place(k + 1) - place(k)).norm(),
            false if piece.closed => (place(0) - place(k)).norm(),
            false => 0.0,
        };
        Self { kept, piece, units: (0..n).map(length).collect(), steps }
    }

    pub fn len(&self) -> usize {
        self.units.len()
    }

    pub fn is_closed(&self) -> bool {
        self.piece.closed
    }

    /// A node by its number in the piece, which goes round on closed ones.
    pub fn node(&self, k: usize) -> &'a Kept {
        &self.kept[self.piece.nodes[k % self.len()] as usize]
    }

    /// Nodes in a row.
    pub fn nodes(&self, first: usize, count: usize) -> Vec<&'a Kept> {
        (first..first + count).map(|k| self.node(k)).collect()
    }

    /// Length of the way from a node over some units.
    pub fn way(&self, first: usize, units: usize) -> f64 {
        (first..first + units).map(|k| self.units[k % self.len()]).sum()
    }

    /// Which nodes are near a turn of more than an angle; of at least `LOOK` nodes.
    fn near_turns(&self, cosine: f64) -> Vec<bool> {
        let n = self.len();
        let closed = self.piece.closed;
        let mut near = vec![false; n];
        for k in if closed { 0..n } else { LOOK..n.saturating_sub(LOOK) } {
            let (before, after) = (self.node(k + n - LOOK), self.node(k + LOOK));
            if before.tangent.dot(&after.tangent) < cosine {
                let around = (k + n).saturating_sub(AROUND)..=k + n + AROUND;
                around
                    .filter(|j| closed || (n..2 * n).contains(j))
                    .for_each(|j| near[j % n] = true);
            }
        }
        near
    }

    /// The sides near turns, in the order of the piece. None of them share nodes.
    pub fn stretches(&self, cosine: f64) -> Vec<Stretch> {
        let n = self.len();
        if n < 2 * SEED {
            return Vec::new();
        }
        let mut free = self.near_turns(cosine);
        if !free.contains(&true) {
            return Vec::new();
        }
        let starts = if self.piece.closed { n } else { n - SEED + 1 };
        let mut seeds: Vec<(f64, usize)> =
            (0..starts).filter_map(|k| Some((self.seed(k, &free)?, k))).collect();
        seeds.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut stretches = Vec::new();
        for (_, k) in seeds {
            if (k..k + SEED).all(|j| free[j % n]) {
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

    /// How far nodes in a row are from being a side; `None` if they are none.
    fn seed(&self, first: usize, free: &[bool]) -> Option<f64> {
        if !(first..first + SEED).all(|k| free[k % self.len()]) {
            return None;
        }
        let nodes = self.nodes(first, SEED);
        let side = Side::new(&nodes, self.steps.bent_sides)?;
        let off = nodes.iter().map(|k| side.off(k)).fold(0.0, f64::max);
        let steps = (first..first + SEED - 1).all(|k| self.is_step(k));
        let one_way = nodes.iter().all(|k| self.runs_along(&side, k));
        (off <= 1.0 && steps && one_way).then_some(off)
    }

    /// Whether the unit that begins at a node is short enough to have been seen.
    pub fn is_step(&self, k: usize) -> bool {
        let footprint = self.node(k).footprint.max(self.node(k + 1).footprint);
        self.units[k % self.len()] <= LONGEST_STEP * footprint
    }

    fn runs_along(&self, side: &Side, k: &Kept) -> bool {
        let (x, _) = side.offsets(&k.position);
        k.tangent.dot(&side.at(x).direction) >= SAME_SIDE
    }

    /// The longest side that holds a seed.
    fn grow(&self, seed: usize, free: &[bool]) -> Option<Stretch> {
        let n = self.len();
        // Counted from one round later, so that it can begin before the first node.
        let (mut first, mut count) = (seed + n, SEED);
        let mut side = Side::new(&self.nodes(first, count), self.steps.bent_sides)?;
        let mut ends = [true; 2];
        while ends.contains(&true) && count < n {
            for (at_end, open) in [false, true].into_iter().zip(&mut ends) {
                let (next, step) = if at_end {
                    (first + count, first + count - 1)
                } else {
                    (first - 1, first - 1)
                };
                let inside = self.piece.closed || (n..2 * n).contains(&next);
                let node = self.node(next);
                let long = side.length + self.units[step % n] > LONGEST_SIDE * side.footprint;
                let joins = inside && free[next % n] && !long && self.is_step(step) && count < n;
                *open = *open && joins && side.off(node) <= 1.0 && self.runs_along(&side, node);
                if *open {
                    (first, count) = (if at_end { first } else { first - 1 }, count + 1);
                    side = Side::new(&self.nodes(first, count), self.steps.bent_sides)?;
                }
            }
        }
        Some(Stretch { first: first % n, count, side })
    }
}
