//! Cover: the longest chains first, and what lies beside an accepted chain is cut away.

use super::super::estimate::PlacedNode;
use super::super::measure::{NONE, Scale};
use super::super::tuning::chain::MIN_NODES;
use super::super::tuning::cover::*;
use super::chain::{Chain, by_length};
use crate::grid::PointGrid;
use crate::sequence::runs;
use transect_geometry::{Point2, Vector2};

/// Accepts chains, longest first, cutting away what lies beside an accepted one in the same
/// direction, and leaving out rests that are too short.
///
/// Of a thin leg a view has a sample or two of each side, so a chain that no other covers may be of
/// any size. A rest beside another chain is no thin part.
pub(super) fn cover(nodes: &[PlacedNode], chains: Vec<Chain>, scale: &Scale) -> Vec<Chain> {
    let mut cover = Cover::new(nodes, &chains, scale);
    let mut accepted = Vec::new();
    for chain in by_length(nodes, chains) {
        // The first chain, which usually has most of the nodes, lies beside no accepted one.
        let first = accepted.is_empty();
        let covered: Vec<bool> =
            chain.nodes.iter().map(|&k| !first && cover.lies_beside(k)).collect();
        let is_whole = !covered.contains(&true);
        for run in uncovered(&chain, &covered) {
            let is_long = || run.footprints(nodes) >= REST_FOOTPRINTS;
            if is_whole || (run.nodes.len() >= MIN_NODES && is_long()) {
                cover.accept(&run);
                accepted.push(run);
            }
        }
    }
    accepted
}

/// The chains accepted so far.
pub(super) struct Cover<'a> {
    nodes: &'a [PlacedNode],
    scale: &'a Scale,
    grid: PointGrid,
    /// Direction of the chain at each of its nodes. Noise may have turned it away from the
    /// direction the node was placed with.
    directions: Vec<Vector2>,
    /// For each accepted node the one that follows it, or itself at an end; [`NONE`] for others.
    following: Vec<u32>,
    /// How far beyond the node that begins it an accepted unit reaches at most.
    longest: f64,
}

impl<'a> Cover<'a> {
    pub fn new(nodes: &'a [PlacedNode], chains: &[Chain], scale: &'a Scale) -> Self {
        let positions: Vec<Point2> = nodes.iter().map(|k| k.position).collect();
        let mut directions: Vec<Vector2> = nodes.iter().map(|k| k.tangent).collect();
        for chain in chains {
            for (at, &k) in chain.nodes.iter().enumerate() {
                directions[k as usize] = chain.chord(nodes, at);
            }
        }
        let grid = PointGrid::new(&positions, CELL_FOOTPRINTS * scale.spacing);
        let following = vec![NONE; nodes.len()];
        Self { nodes, scale, grid, directions, following, longest: 0.0 }
    }

    pub fn accept(&mut self, run: &Chain) {
        let follows = run.nodes.iter().skip(1).chain(run.closed.then(|| &run.nodes[0]));
        for (&k, &next) in run.nodes.iter().zip(follows) {
            self.follow(k, next);
        }
        if let (false, Some(&last)) = (run.closed, run.nodes.last()) {
            self.follow(last, last);
        }
    }

    fn follow(&mut self, k: u32, next: u32) {
        self.following[k as usize] = next;
        let (node, next) = (&self.nodes[k as usize], &self.nodes[next as usize]);
        let unit = (next.position - node.position).norm();
        self.longest = self.longest.max(unit + node.evidence.footprint);
    }

    /// Whether a node lies beside an accepted chain of the same direction.
    fn lies_beside(&self, k: u32) -> bool {
        let here = &self.nodes[k as usize];
        let width = self.scale.across(here.evidence.random_sigma).max(here.evidence.footprint);
        self.lies_within(k, width)
    }

    /// Whether a node lies within a width of an accepted chain of the same direction.
    pub fn lies_within(&self, k: u32, width: f64) -> bool {
        let here = &self.nodes[k as usize];
        // Views that are farther away have longer units.
        let reach = self.longest + here.evidence.footprint;
        let mut beside = false;
        self.grid.within(&here.position, width.hypot(reach), |j, d| {
            beside = beside || self.is_beside(k as usize, j, &d, width);
        });
        beside
    }

    /// Whether a node lies beside an accepted one, at `from_here`, or beside the unit that follows.
    fn is_beside(&self, k: usize, j: usize, from_here: &Vector2, width: f64) -> bool {
        let Some(next) = self.nodes.get(self.following[j] as usize) else { return false };
        let (here, there) = (&self.nodes[k], &self.nodes[j]);
        let unit = next.position - there.position;
        let along = unit.try_normalize(0.0).unwrap_or(self.directions[j]);
        let margin = here.evidence.footprint;
        let x = -from_here.dot(&along);
        along.dot(&self.directions[k]) >= self.scale.same_way
            && (-margin..=unit.norm() + margin).contains(&x)
            && from_here.perp(&along).abs() <= width
    }
}

/// The uncovered runs of a chain.
fn uncovered(chain: &Chain, covered: &[bool]) -> Vec<Chain> {
    if !covered.contains(&true) {
        return vec![chain.clone()];
    }
    let run = |run: Vec<usize>| {
        let nodes = run.into_iter().filter(|k| !covered[*k]).map(|k| chain.nodes[k]).collect();
        Chain { nodes, closed: false }
    };
    let runs = runs(chain.nodes.len(), chain.closed, |k| covered[k]).into_iter().map(run);
    runs.filter(|run| !run.nodes.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::consensus::options::ConsensusOptions;

    #[test]
    fn coarse_nodes_cover_nothing_beyond_the_end_of_their_chain() {
        let node =
            |x: f64, footprint: f64| PlacedNode::at(Point2::new(x, 0.0), Vector2::x(), footprint);
        let coarse = (0..5).map(|k| node(0.3 * f64::from(k), 0.3));
        let fine = (0..12).map(|k| node(1.21 + 0.003 * f64::from(k), 0.003));
        let beside = (0..12).map(|k| node(0.21 + 0.003 * f64::from(k), 0.003));
        let nodes: Vec<PlacedNode> = coarse.chain(fine).chain(beside).collect();
        let chain = |nodes: std::ops::Range<u32>| Chain { nodes: nodes.collect(), closed: false };
        let options = ConsensusOptions::default();
        let scale =
            Scale { spacing: 0.003, threshold: 0.001, same_way: 0.6, settled: false, options };
        let accepted = cover(&nodes, vec![chain(0..5), chain(5..17), chain(17..29)], &scale);
        let firsts: Vec<u32> = accepted.iter().map(|chain| chain.nodes[0]).collect();
        assert_eq!(firsts, [0, 5], "the one that goes on stays, the one beside goes");
    }
}
