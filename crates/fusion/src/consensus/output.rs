//! From pieces to curves: nodes in between where chords would miss the curve, marks of bridged ground,
//! and the reasons why open curves end.

use super::Kept;
use super::observations::{Observations, ViewEnd};
use super::pieces::{Piece, by_length};
use crate::grid::PointGrid;
use transect_geometry::{Curve, EndReason, Node, Point2};

/// Distance between neighbouring nodes, in footprints, from which the ground between them counts as
/// bridged: thinning leaves up to twice its own reach, and a single missing pixel is no gap.
const BRIDGED_FOOTPRINTS: f64 = 3.0;

/// A node goes in between where the chord misses the curve by more than this share of the standard
/// deviation.
const CHORD_SHARE: f64 = 0.25;

/// Smallest cosine between a unit and the directions of its nodes for which they tell the curve
/// between them (20 degrees): at a corner they do not.
const SMOOTH: f64 = 0.94;

/// How far from the end of a fused curve that of a view is looked for, in footprints.
const END_FOOTPRINTS: f64 = 4.0;

/// The curves of the pieces, longest first.
pub(super) fn curves(
    kept: &[Kept],
    pieces: Vec<Piece>,
    ends: &Ends<'_>,
    middle: bool,
) -> Vec<Curve> {
    let curve = |p: &Piece| {
        let curve = Curve::new(nodes(kept, p, middle), p.closed).ok()?;
        Some(curve.with_ends(ends.of(p)))
    };
    by_length(kept, pieces).iter().filter_map(curve).collect()
}

/// The nodes of a piece, with those that belong between them.
fn nodes(kept: &[Kept], piece: &Piece, middle: bool) -> Vec<Node> {
    let at = |k: u32| &kept[k as usize];
    let mut nodes: Vec<Node> = Vec::with_capacity(2 * piece.nodes.len());
    for (k, &number) in piece.nodes.iter().enumerate() {
        let mut node = at(number).node();
        let next = piece.nodes.get(k + 1).or(piece.nodes.first().filter(|_| piece.closed));
        let Some(&next) = next else {
            nodes.push(node);
            break;
        };
        let gap = bridge(at(number), at(next));
        node.bridged = gap.is_some();
        nodes.push(node);
        nodes.extend(gap.or_else(|| between(at(number), at(next)).filter(|_| middle)));
    }
    nodes
}

/// The mark of a gap: a node without views, if two neighbours are too far apart to have been seen
/// side by side.
fn bridge(a: &Kept, b: &Kept) -> Option<Node> {
    let gap = (b.position - a.position).norm();
    let middle = || {
        // Nothing is known in between but the two ends and their distance.
        Node::at(a.position + (b.position - a.position) * 0.5)
            .with_sigma((0.25 * gap) as f32)
            .with_footprint(gap as f32)
            .with_weight(0.0)
            .with_views(0)
            .with_bridged(true)
    };
    (gap > BRIDGED_FOOTPRINTS * a.spacing.max(b.spacing)).then(middle)
}

/// The middle of the cubic with the places and directions of two nodes, where their chord misses it.
fn between(a: &Kept, b: &Kept) -> Option<Node> {
    let step = b.position - a.position;
    let length = step.norm();
    let least = SMOOTH * length;
    if a.tangent.dot(&step) < least || b.tangent.dot(&step) < least {
        return None;
    }
    let middle = (a.tangent - b.tangent) * (0.125 * length);
    let sigma = 0.5 * (a.sigma + b.sigma);
    (step.perp(&middle).abs() > CHORD_SHARE * sigma * length).then(|| {
        let lighter = if a.weight < b.weight { a.node() } else { b.node() };
        lighter.moved_to(a.position + step * 0.5 + middle).with_sigma(sigma as f32)
    })
}

/// Where the views' curves begin and end.
pub(super) struct Ends<'a> {
    kept: &'a [Kept],
    all: Vec<ViewEnd>,
    /// The kept node that stands for each.
    at: Vec<Point2>,
    grid: PointGrid,
}

impl<'a> Ends<'a> {
    pub fn new(observations: &Observations, absorbed_by: &[u32], kept: &'a [Kept]) -> Self {
        let all = observations.ends.clone();
        let by = |e: &ViewEnd| absorbed_by.get(e.observation as usize);
        let place = |e: &ViewEnd| by(e).and_then(|k| kept.get(*k as usize)).map(|k| k.position);
        let at: Vec<Point2> = all.iter().map(|e| place(e).unwrap_or_default()).collect();
        let grid = PointGrid::new(&at, END_FOOTPRINTS * observations.spacing());
        Self { kept, all, at, grid }
    }

    /// Why a piece begins and ends where it does.
    fn of(&self, piece: &Piece) -> [Option<EndReason>; 2] {
        match piece.nodes.as_slice() {
            [first, .., last] if !piece.closed => {
                [self.near(*first, false), self.near(*last, true)]
            }
            _ => [None; 2],
        }
    }

    /// The reason of the nearest end of a view's curve; of several in one place, the first in the
    /// order of reasons.
    fn near(&self, k: u32, is_last: bool) -> Option<EndReason> {
        let here = &self.kept[k as usize];
        let mut nearest: Option<(f64, EndReason)> = None;
        self.grid.within(&here.position, END_FOOTPRINTS * here.footprint, |e, _| {
            let end = self.all[e];
            let found = ((self.at[e] - here.position).norm(), end.reason);
            if end.is_last == is_last && nearest.is_none_or(|n| found < n) {
                nearest = Some(found);
            }
        });
        nearest.map(|(_, reason)| reason)
    }
}
