//! Pieces: chains of linked nodes, and what is cut from them because it lies beside a better one.

use super::observations::NONE;
use super::{Kept, Scale};
use crate::grid::PointGrid;
use std::cmp::Ordering;
use transect_geometry::{Point2, Vector2};

/// Fewest nodes of a piece; fewer have no direction of their own.
const FEWEST_NODES: usize = 3;

/// Fewest nodes of a piece that is straightened: a small ring is all bends.
const FEWEST_TO_STRAIGHTEN: usize = 8;

/// Longest curve unit that is looked for beside a node, in footprints: that of a joined gap.
const LONGEST_UNIT_FOOTPRINTS: f64 = 4.0;

/// Kept nodes in the order of a curve.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Piece {
    pub nodes: Vec<u32>,
    pub closed: bool,
}

impl Piece {
    pub fn length(&self, kept: &[Kept]) -> f64 {
        let at = |k: u32| kept[k as usize].position;
        let open: f64 = self.nodes.windows(2).map(|w| (at(w[1]) - at(w[0])).norm()).sum();
        let closing = match (self.closed, self.nodes.as_slice()) {
            (true, [first, .., last]) => (at(*first) - at(*last)).norm(),
            _ => 0.0,
        };
        open + closing
    }

    /// Length in footprints of what was seen of it: of a gap no more counts than its ends' samples.
    pub fn footprints(&self, kept: &[Kept]) -> f64 {
        let at = |k: &u32| &kept[*k as usize];
        let seen = |a: &u32, b: &u32| {
            let (a, b) = (at(a), at(b));
            (b.position - a.position).norm().min(a.spacing.max(b.spacing))
        };
        let open: f64 = self.nodes.windows(2).map(|w| seen(&w[0], &w[1])).sum();
        let closing = match (self.closed, self.nodes.as_slice()) {
            (true, [first, .., last]) => seen(last, first),
            _ => 0.0,
        };
        let footprint: f64 = self.nodes.iter().map(|k| at(k).footprint).sum();
        (open + closing) * self.nodes.len() as f64 / footprint
    }

    /// Whether an open piece is long enough against its own error to have a direction. Shorter ones
    /// are what noise leaves of surfaces that run nearly along the plane.
    pub fn has_direction(&self, kept: &[Kept]) -> bool {
        const SIGMAS: f64 = 6.0;
        let sigma: f64 = self.nodes.iter().map(|&k| kept[k as usize].sigma).sum();
        self.closed || self.length(kept) * self.nodes.len() as f64 >= SIGMAS * sigma
    }

    /// Unit direction of the piece at one of its nodes, from two nodes before to two after.
    fn chord(&self, kept: &[Kept], at: usize) -> Vector2 {
        const REACH: usize = 2;
        let n = self.nodes.len();
        let (before, after) = if self.closed && n > 2 * REACH {
            ((at + n - REACH) % n, (at + REACH) % n)
        } else {
            (at.saturating_sub(REACH), (at + REACH).min(n - 1))
        };
        let place = |k: usize| kept[self.nodes[k] as usize].position;
        let own = kept[self.nodes[at] as usize].tangent;
        (place(after) - place(before)).try_normalize(0.0).unwrap_or(own)
    }

    /// Mean direction of the nodes at one end, towards the end of the curve, when some are cut off.
    pub fn direction(&self, kept: &[Kept], at_end: bool, cut: usize) -> Vector2 {
        const NODES: usize = 4;
        let sum = |nodes: &mut dyn Iterator<Item = &u32>| {
            nodes.skip(cut).take(NODES).map(|&k| kept[k as usize].tangent).sum::<Vector2>()
        };
        let mean =
            if at_end { sum(&mut self.nodes.iter().rev()) } else { sum(&mut self.nodes.iter()) };
        mean.try_normalize(1e-9).unwrap_or_else(Vector2::x)
    }
}

/// Follows the links: open pieces from their heads, then closed ones.
pub(super) fn trace(next: &[u32]) -> Vec<Piece> {
    let mut has_previous = vec![false; next.len()];
    for &n in next.iter().filter(|n| **n != NONE) {
        has_previous[n as usize] = true;
    }
    let mut visited = vec![false; next.len()];
    let mut pieces = Vec::new();
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
            pieces.push(Piece { nodes, closed });
        }
    }
    pieces
}

/// Takes out sideways steps: a unit that leads across, or back, between nodes of one direction is
/// where a curve changed from one view's layer to another's, and its less seen node goes. So it does
/// where two views' nodes of one corner follow each other the wrong way round, and a node that says
/// nothing between two far better ones.
pub(super) fn straighten(kept: &[Kept], piece: &mut Piece, st: &super::Steps) {
    const PASSES: usize = 4;
    for _ in 0..PASSES {
        let n = piece.nodes.len();
        let units = if piece.closed { n } else { n.saturating_sub(1) };
        let mut goes = vec![false; n];
        for k in 0..units {
            let (a, b) = (k, (k + 1) % n);
            let (p, q) = (&kept[piece.nodes[a] as usize], &kept[piece.nodes[b] as usize]);
            if !goes[a]
                && ((st.sideways && steps_sideways(p, q))
                    || (st.backward && steps_back(kept, piece, a)))
            {
                goes[if p.weight < q.weight { a } else { b }] = true;
            } else if !goes[a] && st.redundant && says_nothing(kept, piece, a) {
                goes[b] = true;
            }
        }
        if !goes.contains(&true) || n < FEWEST_TO_STRAIGHTEN {
            return;
        }
        let mut goes = goes.iter();
        piece.nodes.retain(|_| goes.next() != Some(&true));
    }
}

/// Whether the node behind `a` lies within its error of the chord between its neighbours, both far more
/// accurate and close to each other: a view that cuts a corner another one saw.
fn says_nothing(kept: &[Kept], piece: &Piece, a: usize) -> bool {
    const BETTER: f64 = 4.0;
    const SIGMAS: f64 = 4.0;
    const CLOSE: f64 = 1.5;
    let n = piece.nodes.len();
    if !piece.closed && a + 2 >= n {
        return false;
    }
    let at = |k: usize| &kept[piece.nodes[k % n] as usize];
    let (p, here, q) = (at(a), at(a + 1), at(a + 2));
    let chord = q.position - p.position;
    let off = chord.perp(&(here.position - p.position)).abs();
    here.sigma > BETTER * p.sigma.max(q.sigma)
        && chord.norm() < CLOSE * here.footprint
        && off <= SIGMAS * here.sigma * chord.norm()
}

/// Whether a unit shorter than half a footprint runs against the way from the node before it to the one
/// behind it.
fn steps_back(kept: &[Kept], piece: &Piece, a: usize) -> bool {
    const SHORT: f64 = 0.5;
    let n = piece.nodes.len();
    let at = |k: usize| &kept[piece.nodes[k % n] as usize];
    if !piece.closed && (a == 0 || a + 2 >= n) {
        return false;
    }
    let (p, q) = (at(a), at(a + 1));
    let step = q.position - p.position;
    let around = at(a + 2).position - at(a + n - 1).position;
    step.norm() < SHORT * p.footprint.max(q.footprint) && step.dot(&around) < 0.0
}

fn steps_sideways(p: &Kept, q: &Kept) -> bool {
    const SMALLEST_COSINE: f64 = 0.3;
    let step = (q.position - p.position).try_normalize(0.0).unwrap_or(p.tangent);
    let one_way = p.tangent.dot(&q.tangent) >= 0.5;
    one_way && (p.tangent + q.tangent).normalize().dot(&step) < SMALLEST_COSINE
}

/// Longest first; equal lengths by their first node's place.
pub(super) fn by_length(kept: &[Kept], pieces: Vec<Piece>) -> Vec<Piece> {
    let mut measured: Vec<(f64, Piece)> = pieces.into_iter().map(|p| (p.length(kept), p)).collect();
    let place = |p: &Piece| {
        p.nodes.first().map_or((0.0, 0.0), |&k| {
            let at = kept[k as usize].position;
            (at.x, at.y)
        })
    };
    measured.sort_by(|(la, a), (lb, b)| {
        let (pa, pb) = (place(a), place(b));
        let places = || pa.0.total_cmp(&pb.0).then(pa.1.total_cmp(&pb.1));
        match lb.total_cmp(la) {
            Ordering::Equal => places(),
            decided => decided,
        }
    });
    measured.into_iter().map(|(_, p)| p).collect()
}

/// Shortest piece that is accepted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shortest {
    /// Fewest footprints and nodes of a piece no part of which lies beside another.
    pub whole: (f64, usize),
    /// The same of what is left of one that was cut.
    pub rest: (f64, usize),
}

impl Shortest {
    /// Of pieces that take part in joining: a thin leg shows a sample or two of each side. Scraps
    /// beside another piece are no such thing.
    pub const PART: Self = Self { whole: (0.0, 1), rest: (2.0, FEWEST_NODES) };

    /// Of pieces that are curves.
    pub fn curve(footprints: f64) -> Self {
        Self { whole: (footprints, FEWEST_NODES), rest: (footprints, FEWEST_NODES) }
    }
}

/// Accepts pieces, longest first, cutting away what lies beside an accepted one in the same
/// direction, and dropping what is too short to be a curve of its own.
///
/// Returns the accepted pieces and how many nodes were cut or dropped.
pub(super) fn cover(
    kept: &[Kept],
    pieces: Vec<Piece>,
    scale: &Scale,
    shortest: Shortest,
) -> (Vec<Piece>, usize) {
    let mut cover = Cover::new(kept, &pieces, scale);
    let (mut result, mut dropped) = (Vec::new(), 0);
    for piece in by_length(kept, pieces) {
        // Nothing lies beside the first one, which as a rule has most of the nodes.
        let first = result.is_empty();
        let covered: Vec<bool> =
            piece.nodes.iter().map(|&k| !first && cover.lies_beside(k)).collect();
        let is_whole = !covered.contains(&true);
        let (footprints, nodes) = if is_whole { shortest.whole } else { shortest.rest };
        for run in runs(&piece, &covered) {
            if run.footprints(kept) < footprints || run.nodes.len() < nodes {
                dropped += run.nodes.len();
                continue;
            }
            cover.accept(&run);
            result.push(run);
        }
        dropped += covered.iter().filter(|c| **c).count();
    }
    (result, dropped)
}

/// Open pieces that one view saw, or only ends of views' curves, along a closed piece of the same
/// direction and closer to it than this many times what they may be astray: between two boundaries with their
/// solid on one side runs a third the other way, so where nobody saw one, what saw the piece is wrong.
const SPUR_THRESHOLDS: f64 = 3.0;

/// Largest mean number of views of a spur, and largest mean credit.
const SPUR_VIEWS: f64 = 1.5;
const SPUR_CREDIT: f64 = 1.0;

/// Smallest share of a spur's nodes that lie beside the closed piece: what overshoots bends away.
const SPUR_BESIDE: f64 = 2.0 / 3.0;

/// Takes out spurs; returns the others and how many nodes went.
pub(super) fn without_spurs(
    kept: &[Kept],
    pieces: Vec<Piece>,
    scale: &Scale,
) -> (Vec<Piece>, usize) {
    let weak = |p: &Piece| {
        let nodes = p.nodes.len() as f64;
        let views: u32 = p.nodes.iter().map(|&k| kept[k as usize].views).sum();
        let credit: f64 = p.nodes.iter().map(|&k| kept[k as usize].credit).sum();
        !p.closed && (f64::from(views) <= SPUR_VIEWS * nodes || credit <= SPUR_CREDIT * nodes)
    };
    if !pieces.iter().any(weak) || !pieces.iter().any(|p| p.closed) {
        return (pieces, 0);
    }
    let mut cover = Cover::new(kept, &pieces, scale);
    pieces.iter().filter(|p| p.closed).for_each(|p| cover.accept(p));
    let limit = |k: u32| SPUR_THRESHOLDS * scale.astray(&kept[k as usize]);
    let beside = |k: &&u32| cover.lies_within(**k, limit(**k));
    let is_spur = |p: &Piece| {
        let count = p.nodes.iter().filter(beside).count();
        weak(p) && count as f64 >= SPUR_BESIDE * p.nodes.len() as f64
    };
    let (spurs, others): (Vec<Piece>, Vec<Piece>) = pieces.into_iter().partition(is_spur);
    (others, spurs.iter().map(|p| p.nodes.len()).sum())
}

/// What has been accepted so far.
struct Cover<'a> {
    kept: &'a [Kept],
    scale: &'a Scale,
    grid: PointGrid,
    /// Direction of the piece at each of its nodes: that of the curve as it came out, which noise
    /// may have turned away from the direction the node was placed with.
    directions: Vec<Vector2>,
    /// For each accepted node the one that follows it, or itself at an end; [`NONE`] for others.
    following: Vec<u32>,
}

impl<'a> Cover<'a> {
    fn new(kept: &'a [Kept], pieces: &[Piece], scale: &'a Scale) -> Self {
        let positions: Vec<Point2> = kept.iter().map(|k| k.position).collect();
        let mut directions: Vec<Vector2> = kept.iter().map(|k| k.tangent).collect();
        for piece in pieces {
            for (at, &k) in piece.nodes.iter().enumerate() {
                directions[k as usize] = piece.chord(kept, at);
            }
        }
        let grid = PointGrid::new(&positions, LONGEST_UNIT_FOOTPRINTS * scale.spacing);
        Self { kept, scale, grid, directions, following: vec![NONE; kept.len()] }
    }

    fn accept(&mut self, run: &Piece) {
        let follows = run.nodes.iter().skip(1).chain(run.closed.then(|| &run.nodes[0]));
        for (&k, &next) in run.nodes.iter().zip(follows) {
            self.following[k as usize] = next;
        }
        if let (false, Some(&last)) = (run.closed, run.nodes.last()) {
            self.following[last as usize] = last;
        }
    }

    /// Whether a node lies beside an accepted piece of the same direction.
    fn lies_beside(&self, k: u32) -> bool {
        let here = &self.kept[k as usize];
        let width = self.scale.across(here.cluster_sigma, f64::INFINITY).max(here.footprint);
        self.lies_within(k, width.min(here.room))
    }

    /// Whether a node lies within a width of an accepted piece of the same direction.
    fn lies_within(&self, k: u32, width: f64) -> bool {
        let here = &self.kept[k as usize];
        let reach = LONGEST_UNIT_FOOTPRINTS * here.footprint.max(self.scale.spacing);
        let mut beside = false;
        self.grid.within(&here.position, width.hypot(reach), |j, d| {
            beside = beside || self.is_beside(k as usize, j, &d, width);
        });
        beside
    }

    /// Whether a node lies beside an accepted one, at `from_here`, or beside the unit that follows.
    fn is_beside(&self, k: usize, j: usize, from_here: &Vector2, width: f64) -> bool {
        let Some(next) = self.kept.get(self.following[j] as usize) else { return false };
        let (here, there) = (&self.kept[k], &self.kept[j]);
        let unit = next.position - there.position;
        let along = unit.try_normalize(0.0).unwrap_or(self.directions[j]);
        let margin = here.footprint.max(there.footprint);
        let x = -from_here.dot(&along);
        along.dot(&self.directions[k]) >= self.scale.same_way
            && (-margin..=unit.norm() + margin).contains(&x)
            && from_here.perp(&along).abs() <= width
    }
}

/// The uncovered runs of a piece.
fn runs(piece: &Piece, covered: &[bool]) -> Vec<Piece> {
    if covered.iter().all(|c| !c) {
        return vec![piece.clone()];
    }
    let n = piece.nodes.len();
    // A closed piece is opened at a covered node, so that no run is cut in two.
    let start = if piece.closed { covered.iter().position(|c| *c).unwrap_or(0) } else { 0 };
    let mut result = Vec::new();
    let mut nodes = Vec::new();
    for k in (start..n).chain(0..start) {
        if !covered[k] {
            nodes.push(piece.nodes[k]);
        } else if !nodes.is_empty() {
            result.push(Piece { nodes: std::mem::take(&mut nodes), closed: false });
        }
    }
    if !nodes.is_empty() {
        result.push(Piece { nodes, closed: false });
    }
    result
}
