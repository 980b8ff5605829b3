//! Sharp corners: where two smooth stretches meet at an angle, the curve goes through the place at
//! which they meet.
//!
//! **Problem.** Fits use neighbours of one direction, and the smoothing of range images works over
//! several pixels. So within two or three footprints of a corner nodes follow neither side, and the
//! chord between the last two cuts the corner off.
//!
//! **Idea.** From farther away both sides show where they meet, as the faces of an object give
//! edges sharper than any pixel on them.
//!
//! **Steps**, on each chain, near places where the direction turns.
//! 1. Sides: rows of nodes that follow a line within their errors. A side begins where nodes follow
//!    a line best, and grows while the next node does; see `path.rs` and `side.rs`.
//! 2. A corner is where two sides that follow each other meet. It must lie ahead of both, and the
//!    nodes between may lie off the sides by as much as smoothing and sampling move nodes at a
//!    corner. A fillet whose nodes lie farther inside than that stays a fillet.
//! 3. Two sides that face each other may have a short one between them, with a corner at both of
//!    its ends; see `short.rs`.
//! 4. The nodes between move onto their side, nodes beyond the corner are removed, and the corner
//!    becomes a node.

mod path;
mod short;
mod side;

use super::super::connect::Chain;
use super::super::estimate::{Evidence, PlacedNode};
use super::super::options::Steps;
use super::super::tuning::corners::*;
use crate::sequence::neighbours;
use path::{Path, Stretch};
use side::{Place, Side};
use transect_geometry::{CurveUnit, Point2, Vector2};

/// Makes corners sharp; new nodes are added to `nodes`. `noise` is the standard deviation of a
/// single pixel across a curve.
pub(super) fn sharpen(
    nodes: &mut Vec<PlacedNode>,
    chains: &mut [Chain],
    noise: f64,
    steps: &Steps,
) {
    for chain in chains {
        let corners = corners(&Path::new(nodes, chain), noise, steps);
        if !corners.is_empty() {
            replace(nodes, chain, corners);
        }
    }
}

/// A corner with the nodes that replace some of a chain.
struct Corner {
    first: usize,
    count: usize,
    nodes: Vec<PlacedNode>,
    /// Whether the curve passes the corner at more than the corner's error; otherwise the curve
    /// stays as it is.
    is_cut_off: bool,
}

/// Puts corners in, in the order of the chain.
fn replace(nodes: &mut Vec<PlacedNode>, chain: &mut Chain, corners: Vec<Corner>) {
    let n = chain.nodes.len();
    let mut stays = vec![true; n];
    for corner in &corners {
        // On a closed chain, the replaced nodes may go on at its beginning.
        (corner.first..corner.first + corner.count).for_each(|k| stays[k % n] = false);
    }
    let mut numbers = Vec::with_capacity(n);
    let mut corners = corners.into_iter().peekable();
    for (k, &number) in chain.nodes.iter().enumerate() {
        while let Some(corner) = corners.next_if(|c| c.first == k) {
            let first = nodes.len() as u32;
            nodes.extend(corner.nodes);
            numbers.extend(first..nodes.len() as u32);
        }
        if stays[k] {
            numbers.push(number);
        }
    }
    chain.nodes = numbers;
}

/// All corners, in the order of the chain.
fn corners(path: &Path<'_>, noise: f64, steps: &Steps) -> Vec<Corner> {
    let stretches = path.stretches(SMALLEST_TURN.cos());
    let mut corners: Vec<Corner> = Vec::new();
    for (a, b) in neighbours(&stretches, path.is_closed()) {
        let found = match corner(path, a, b, noise) {
            Some(corner) => vec![corner],
            None if steps.short_sides => {
                let short = short::between(path, a, b);
                short.and_then(|s| both_ends(path, [a, &s, b], noise)).unwrap_or_default()
            }
            None => Vec::new(),
        };
        corners.extend(found.into_iter().filter(|c| c.is_cut_off));
    }
    corners.sort_by_key(|c| c.first);
    corners
}

/// The corners at both ends of a short side.
fn both_ends(path: &Path<'_>, [a, short, b]: [&Stretch; 3], noise: f64) -> Option<Vec<Corner>> {
    Some(vec![corner(path, a, short, noise)?, corner(path, short, b, noise)?])
}

/// The corner between two sides.
fn corner(path: &Path<'_>, a: &Stretch, b: &Stretch, noise: f64) -> Option<Corner> {
    let n = path.len();
    let first = (a.first + a.count) % n;
    let count = (b.first + n - first) % n;
    let last = first + n - 1;
    let footprint = a.side.footprint.max(b.side.footprint);
    let has_gap = (last..=last + count).any(|k| !path.is_step(k));
    if has_gap || path.way(last, count + 1) > LONGEST_ZONE * footprint {
        return None;
    }
    let meeting = Meeting::new([&a.side, &b.side])?;
    let ends = (path.node(last), path.node(b.first));
    let is_cut_off = meeting.is_cut_off(&path.nodes(first, count), ends, noise)?;
    // The last nodes of a side have neighbours on one hand only; the side as a whole is more
    // accurate.
    let near = |k: &usize| (path.node(*k).position - meeting.place).norm() < RIM * footprint;
    let of_a = (1..=a.count / 2).take_while(|k| near(&(first + n - k))).count();
    let of_b = (0..b.count / 2).take_while(|k| near(&(b.first + k))).count();
    let (first, count) = ((first + n - of_a) % n, count + of_a + of_b);
    let around = (path.node(first + n - 1), path.node(first + count));
    let nodes = meeting.nodes(&path.nodes(first, count), around);
    Some(Corner { first, count, nodes, is_cut_off })
}

/// Where two sides meet.
struct Meeting<'a> {
    sides: [&'a Side; 2],
    /// How far along each side.
    along: [f64; 2],
    place: Point2,
    sigma: f64,
    /// Angle between the directions, in radians.
    turn: f64,
    /// Unit directions of the chain before and after the corner.
    directions: [Vector2; 2],
}

impl<'a> Meeting<'a> {
    /// `None` unless both sides lead to it, at an angle that makes a corner.
    fn new(sides: [&'a Side; 2]) -> Option<Self> {
        let along = sides[0].meeting(sides[1])?;
        let ends = [sides[0].at(along[0]), sides[1].at(along[1])];
        let directions = ends.map(|e| e.direction);
        let turn = directions[0].angle(&directions[1]);
        let ahead = [along[0] - sides[0].length, -along[1]];
        let leads = |k: usize| (-BEYOND..=AHEAD).contains(&(ahead[k] / sides[k].footprint));
        let sigma = ends[0].sigma.hypot(ends[1].sigma) / turn.sin();
        // Along an arc both sides would bend as much as the way from one's middle to the other's.
        let way = ahead[0] + ahead[1] + 0.5 * (sides[0].length + sides[1].length);
        let left = directions[0].perp(&directions[1]).signum();
        let bends = |side: &Side| {
            let sigma = side.bend.variance.sqrt();
            left * side.bend.value + BEND_SIGMAS * sigma > BEND_SHARE * turn / way
        };
        let is_corner = leads(0)
            && leads(1)
            && (SMALLEST_TURN..=LARGEST_TURN).contains(&turn)
            && !sides.into_iter().any(bends);
        is_corner.then_some(Self { sides, along, place: ends[0].position, sigma, turn, directions })
    }

    /// Whether the curve cuts the corner off; `None` if the nodes between contradict a corner.
    fn is_cut_off(
        &self,
        between: &[&PlacedNode],
        ends: (&PlacedNode, &PlacedNode),
        noise: f64,
    ) -> Option<bool> {
        let footprint = self.sides[0].footprint.max(self.sides[1].footprint);
        let cut = self.cut(between, ends);
        let agrees = |k: &&PlacedNode| {
            let off = self.sides.map(|side| side.offsets(&k.position).1.abs());
            let near = (k.position - self.place).norm() < NEAR * footprint;
            let sampling = if near { SAMPLED * footprint } else { 0.0 };
            off[0].min(off[1]) <= noise + OFF_SIGMAS * k.random_sigma() + sampling
        };
        let chord = CHORD * footprint * (0.5 * self.turn).sin();
        let leaves = cut <= chord + noise && between.iter().all(agrees);
        leaves.then_some(cut > MIN_CUT_SIGMAS * self.sigma)
    }

    /// How far off the corner the curve passes.
    fn cut(&self, between: &[&PlacedNode], (before, after): (&PlacedNode, &PlacedNode)) -> f64 {
        let path = || std::iter::once(&before).chain(between).chain([&after]);
        let units = path().zip(path().skip(1));
        let off = units
            .map(|(a, b)| CurveUnit { start: a.position, end: b.position }.distance(&self.place));
        off.fold(f64::INFINITY, f64::min)
    }

    /// The nodes between on their sides, and the corner.
    fn nodes(
        &self,
        between: &[&PlacedNode],
        (before, after): (&PlacedNode, &PlacedNode),
    ) -> Vec<PlacedNode> {
        let mut nodes = self.on_side(0, before, &mut between.iter());
        let mut behind = self.on_side(1, after, &mut between.iter().rev());
        behind.reverse();
        let around = (nodes.last().unwrap_or(before), behind.first().unwrap_or(after));
        let corner = self.node(around);
        nodes.push(corner);
        nodes.append(&mut behind);
        nodes
    }

    /// The nodes that belong on a side, on their way to the corner.
    fn on_side(
        &self,
        k: usize,
        start: &PlacedNode,
        nodes: &mut dyn Iterator<Item = &&PlacedNode>,
    ) -> Vec<PlacedNode> {
        let (side, other) = (self.sides[k], self.sides[1 - k]);
        let apart = APART * side.footprint;
        // How far it still is to the corner, which both sides lead to.
        let left =
            |node: &PlacedNode| (self.along[k] - side.offsets(&node.position).0) * TOWARDS[k];
        let mut room = left(start);
        let mut moved = Vec::new();
        for node in nodes {
            let (x, across) = side.offsets(&node.position);
            let belongs = across.abs() <= other.offsets(&node.position).1.abs();
            if belongs && (apart..=room - apart).contains(&left(node)) {
                room = left(node);
                moved.push(placed(node, &side.at(x)));
            }
        }
        moved
    }

    /// The corner as a node.
    fn node(&self, (before, after): (&PlacedNode, &PlacedNode)) -> PlacedNode {
        let (of_before, of_after) = (&before.evidence, &after.evidence);
        let lighter = if of_before.weight < of_after.weight { before } else { after };
        let normals = [of_before, of_after].map(|e| e.normal.unwrap_or_default());
        let view_variance = of_before.view_variance.max(of_after.view_variance);
        PlacedNode {
            position: self.place,
            tangent: (self.directions[0] + self.directions[1]).normalize(),
            sigma: self.sigma.hypot(view_variance.sqrt()),
            evidence: Evidence {
                normal: (normals[0] + normals[1]).try_normalize(0.0),
                views: of_before.views.min(of_after.views),
                ..lighter.evidence
            },
            ..*lighter
        }
    }
}

/// Ways towards the corner along its sides.
const TOWARDS: [f64; 2] = [1.0, -1.0];

/// A node at a place of a side.
fn placed(node: &PlacedNode, place: &Place) -> PlacedNode {
    let sigma = place.sigma.hypot(node.evidence.view_variance.sqrt());
    PlacedNode { position: place.position, tangent: place.direction, sigma, ..*node }
}
