//! Sharp corners: where two smooth stretches meet at an angle, the curve goes through the place at
//! which they meet.
//!
//! **Problem.** Fits use neighbours of one direction, and the smoothing of range images works over
//! several pixels. So within two or three footprints of a corner nodes follow neither side, and the
//! chord between the last two cuts the corner off.
//!
//! **Idea.** From farther away both sides tell where they meet, as the faces of an object give edges
//! sharper than any pixel on them.
//!
//! **Steps**, on each piece, near places where the direction turns.
//! 1. Sides: rows of nodes that follow a line, or a parabola where they tell one, within their errors;
//!    begun where nodes follow a line best, and grown while the next one does; see `path.rs` and
//!    `side.rs`.
//! 2. A corner is where two sides that follow each other meet, if that lies ahead of both, and the
//!    nodes between contradict it by no more than what smoothing and sampling do to a corner. A
//!    fillet whose nodes lie farther inside than that stays one.
//! 3. Two sides that face each other may have a short one between them, with a corner at both of its ends;
//!    see `short.rs`.
//! 4. The nodes between move onto their side, those beyond the corner go, and the corner becomes a
//!    node.

mod path;
mod short;
mod side;

use super::Kept;
use super::pieces::Piece;
use path::{Path, Stretch};
use side::{Place, Side};
use transect_geometry::{Point2, Vector2};

/// Longest way between two sides of a corner, and how far ahead of each they may meet, in footprints.
const LONGEST_ZONE: f64 = 7.0;
const AHEAD: f64 = 6.0;

/// How far a side may reach beyond the corner, in footprints.
const BEYOND: f64 = 0.5;

/// Smallest turn of a corner, in radians (40 degrees), and largest (140 degrees): a sharper one is a
/// thin tip, of which the nodes know more than its sides.
const SMALLEST_TURN: f64 = 0.7;
const LARGEST_TURN: f64 = 2.44;

/// Share of the curvature of an arc along both sides that each side must be known to fall short of, and
/// standard deviations that make it known.
const BEND_SHARE: f64 = 0.6;
const BEND_SIGMAS: f64 = 0.5;

/// How far nodes between the sides may lie off them, in standard deviations, besides the noise of a
/// pixel: smoothing over a crease moves a node by no more.
const OFF_SIGMAS: f64 = 3.0;

/// Footprints from the corner within which a view's unit joins samples of both sides, and by how many
/// that moves nodes off them.
const NEAR: f64 = 0.7;
const SAMPLED: f64 = 0.2;

/// How far from the corner, in footprints, both ends of a chord that cuts it off may be: a unit longer
/// than twice that is no longer ground that was seen.
const CHORD: f64 = 1.5;

/// The corner must lie off the curve by more than this many standard deviations of its place.
const TOLD_SIGMAS: f64 = 1.0;

/// Footprints by which the ends of both sides may differ where they meet.
const SAME_PLACE: f64 = 0.01;

/// Footprints from a corner within which nodes of a side move onto it.
const RIM: f64 = 2.5;

/// Distance in footprints that nodes keep from the corner and from each other.
const APART: f64 = 0.4;

/// Makes corners sharp; new nodes are added to `kept`. `noise` is the standard deviation of a single
/// pixel across a curve.
pub(super) fn sharpen(
    kept: &mut Vec<Kept>,
    pieces: &mut [Piece],
    noise: f64,
    steps: &super::Steps,
) {
    for piece in pieces {
        let corners = corners(&Path::new(kept, piece, steps), noise);
        if !corners.is_empty() {
            replace(kept, piece, corners);
        }
    }
}

/// What takes the place of some nodes of a piece.
struct Corner {
    first: usize,
    count: usize,
    nodes: Vec<Kept>,
    /// Whether it lies off the curve by more than its error.
    is_told: bool,
}

/// Puts corners in, which are in the order of the piece.
fn replace(kept: &mut Vec<Kept>, piece: &mut Piece, corners: Vec<Corner>) {
    let n = piece.nodes.len();
    let mut stays = vec![true; n];
    for corner in &corners {
        // What is replaced may go on at the beginning of a closed piece.
        (corner.first..corner.first + corner.count).for_each(|k| stays[k % n] = false);
    }
    let mut nodes = Vec::with_capacity(n);
    let mut corners = corners.into_iter().peekable();
    for (k, &number) in piece.nodes.iter().enumerate() {
        while let Some(corner) = corners.next_if(|c| c.first == k) {
            let first = kept.len() as u32;
            kept.extend(corner.nodes);
            nodes.extend(first..kept.len() as u32);
        }
        if stays[k] {
            nodes.push(number);
        }
    }
    piece.nodes = nodes;
}

/// All corners, in the order of the piece.
fn corners(path: &Path<'_>, noise: f64) -> Vec<Corner> {
    let stretches = path.stretches(SMALLEST_TURN.cos());
    let follows = stretches.iter().skip(1).chain(stretches.first().filter(|_| path.is_closed()));
    let pairs = stretches.iter().zip(follows);
    let mut corners: Vec<Corner> =
        pairs.flat_map(|(a, b)| between(path, (a, b), noise)).flatten().collect();
    corners.sort_by_key(|c| c.first);
    corners
}

/// What is between two sides: a corner, or the two of a short side.
fn between(path: &Path<'_>, (a, b): (&Stretch, &Stretch), noise: f64) -> [Option<Corner>; 2] {
    if let Some(corner) = corner(path, (a, b), noise) {
        return [corner.is_told.then_some(corner), None];
    }
    let short = short::between(path, a, b).filter(|_| path.steps.short_sides);
    let corners =
        short.and_then(|s| Some([corner(path, (a, &s), noise)?, corner(path, (&s, b), noise)?]));
    // One that the curve goes through already does not contradict the other.
    corners.map_or([None, None], |c| c.map(|c| c.is_told.then_some(c)))
}

/// The corner between two sides.
fn corner(path: &Path<'_>, (a, b): (&Stretch, &Stretch), noise: f64) -> Option<Corner> {
    let n = path.len();
    let first = (a.first + a.count) % n;
    let count = (b.first + n - first) % n;
    let last = first + n - 1;
    let footprint = a.side.footprint.max(b.side.footprint);
    let is_seen = (last..=last + count).all(|k| path.is_step(k));
    if !is_seen || path.way(last, count + 1) > LONGEST_ZONE * footprint {
        return None;
    }
    let meeting = Meeting::new([&a.side, &b.side])?;
    let ends = (path.node(last), path.node(b.first));
    let is_told = meeting.is_told(&path.nodes(first, count), ends, noise)?;
    // The last nodes of a side have neighbours on one hand alone; the side as a whole knows better.
    let near = |k: &usize| (path.node(*k).position - meeting.place).norm() < RIM * footprint;
    let of_a = (1..=a.count / 2).take_while(|k| near(&(first + n - k))).count();
    let of_b = (0..b.count / 2).take_while(|k| near(&(b.first + k))).count();
    let (first, count) = ((first + n - of_a) % n, count + of_a + of_b);
    let around = (path.node(first + n - 1), path.node(first + count));
    let nodes = meeting.nodes(&path.nodes(first, count), around);
    Some(Corner { first, count, nodes, is_told })
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
    /// Unit directions of the piece before and after the corner.
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
            let (bend, sigma) = side.bend;
            left * bend + BEND_SIGMAS * sigma > BEND_SHARE * turn / way
        };
        // Bent sides may pass each other.
        let apart = (ends[1].position - ends[0].position).norm();
        let is_corner = leads(0)
            && leads(1)
            && apart <= SAME_PLACE * sides[0].footprint
            && (SMALLEST_TURN..=LARGEST_TURN).contains(&turn)
            && !sides.into_iter().any(bends);
        is_corner.then_some(Self { sides, along, place: ends[0].position, sigma, turn, directions })
    }

    /// Whether the corner matters; `None` unless the nodes between are what it leaves of itself.
    fn is_told(&self, between: &[&Kept], ends: (&Kept, &Kept), noise: f64) -> Option<bool> {
        let footprint = self.sides[0].footprint.max(self.sides[1].footprint);
        let cut = self.cut(between, ends);
        let agrees = |k: &&Kept| {
            let off = self.sides.map(|side| side.offsets(&k.position).1.abs());
            let near = (k.position - self.place).norm() < NEAR * footprint;
            let random = (k.sigma * k.sigma - k.common_variance).max(0.0).sqrt();
            let sampling = if near { SAMPLED * footprint } else { 0.0 };
            off[0].min(off[1]) <= noise + OFF_SIGMAS * random + sampling
        };
        let chord = CHORD * footprint * (0.5 * self.turn).sin();
        let leaves = cut <= chord + noise && between.iter().all(agrees);
        leaves.then_some(cut > TOLD_SIGMAS * self.sigma)
    }

    /// How far off the corner the curve passes.
    fn cut(&self, between: &[&Kept], (before, after): (&Kept, &Kept)) -> f64 {
        let path = || std::iter::once(&before).chain(between).chain([&after]);
        let units = path().zip(path().skip(1));
        let off = units.map(|(a, b)| distance(&self.place, (&a.position, &b.position)));
        off.fold(f64::INFINITY, f64::min)
    }

    /// The nodes between on their sides, and the corner.
    fn nodes(&self, between: &[&Kept], (before, after): (&Kept, &Kept)) -> Vec<Kept> {
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
        start: &Kept,
        nodes: &mut dyn Iterator<Item = &&Kept>,
    ) -> Vec<Kept> {
        let (side, other) = (self.sides[k], self.sides[1 - k]);
        let apart = APART * side.footprint;
        // How far it still is to the corner, which both sides lead to.
        let left = |node: &Kept| (self.along[k] - side.offsets(&node.position).0) * TOWARDS[k];
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
    fn node(&self, (before, after): (&Kept, &Kept)) -> Kept {
        let tangent = self.directions[0] + self.directions[1];
        Kept {
            position: self.place,
            cluster: self.place,
            tangent: tangent.normalize(),
            sigma: self.sigma.hypot(before.common_variance.max(after.common_variance).sqrt()),
            normal: (before.normal + after.normal).try_normalize(0.0).unwrap_or_default(),
            views: before.views.min(after.views),
            ..if before.weight < after.weight { *before } else { *after }
        }
    }
}

/// Ways towards the corner along its sides.
const TOWARDS: [f64; 2] = [1.0, -1.0];

/// A node at a place of a side.
fn placed(node: &Kept, place: &Place) -> Kept {
    let sigma = place.sigma.hypot(node.common_variance.sqrt());
    Kept { position: place.position, tangent: place.direction, sigma, ..*node }
}

/// Distance of a place from a unit.
fn distance(place: &Point2, (a, b): (&Point2, &Point2)) -> f64 {
    let (unit, d) = (b - a, place - a);
    let squared = unit.norm_squared();
    let share = if squared > 0.0 { (d.dot(&unit) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (d - unit * share).norm()
}
