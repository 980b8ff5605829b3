//! Short sides: the end of a thin part, between two long sides that face each other.
//!
//! **Problem.** The end of a thin part has too few nodes to be found as a side, and smoothing leaves most
//! of them off it, so that both its corners are cut off.
//!
//! **Idea.** The long sides are known well. Of the end little is left to be found: where it crosses them,
//! and how slanted. Few nodes tell its slant badly; what they do not tell is taken to be none.
//!
//! **Steps.**
//! 1. The direction straight across both sides.
//! 2. Of each run of nodes between the sides a line, its slant drawn towards none as far as it is unknown.
//! 3. The line that fits best: each node between is beside the nearest of the three sides.
//! 4. Arcs that touch all three sides are the other way to turn round. If one fits much better, the end
//!    is round.

use super::super::Kept;
use super::super::window::left_of;
use super::path::{Path, Stretch};
use super::side::Side;
use transect_geometry::Vector2;

/// Longest way round the end, in footprints, and most nodes there.
const LONGEST_WAY: f64 = 12.0;
const MOST_NODES: usize = 16;

/// Largest cosine between the directions of sides that face each other (40 degrees).
const FACING: f64 = -0.766;

/// Standard deviation of the slants of ends, as a slope (17 degrees).
const SLANT: f64 = 0.3;

/// How many times as large as that of an arc the misfit of a sharp end may be: smoothing alone rounds it.
const ROUNDED: f64 = 2.0;

/// The short side between two that follow each other and face each other.
pub(super) fn between(path: &Path<'_>, a: &Stretch, b: &Stretch) -> Option<Stretch> {
    let n = path.len();
    let first = a.first + a.count;
    let count = (b.first + 2 * n - first) % n;
    let longest = LONGEST_WAY * a.side.footprint.min(b.side.footprint);
    if !(1..=MOST_NODES).contains(&count) || path.way(first + n - 1, count + 1) > longest {
        return None;
    }
    let across = across(&a.side, &b.side)?;
    let nodes = path.nodes(first, count);
    let runs = (0..count).flat_map(|from| (from + 1..=count).map(move |to| from..to));
    let (mut best, mut round) = (None, f64::INFINITY);
    for run in runs {
        let Some(side) = Side::leading(nodes.get(run.clone())?, across, SLANT) else { continue };
        let sides = [&a.side, &side, &b.side];
        round = round_misfit(&nodes, sides).map_or(round, |misfit| round.min(misfit));
        let Some(misfit) = sharp_misfit(&nodes, sides) else { continue };
        if best.is_none_or(|(least, _)| misfit < least) {
            best =
                Some((misfit, Stretch { first: (first + run.start) % n, count: run.len(), side }));
        }
    }
    let (misfit, short) = best?;
    (misfit <= ROUNDED * round).then_some(short)
}

/// The direction across two sides, from the first to the second; `None` unless they face each other.
fn across(a: &Side, b: &Side) -> Option<Vector2> {
    let (before, after) = (a.at(a.length), b.at(0.0));
    if before.direction.dot(&after.direction) > FACING {
        return None;
    }
    let across = left_of(&(before.direction - after.direction)).try_normalize(0.0)?;
    let step = (after.position - before.position).dot(&across);
    (step != 0.0).then(|| across * step.signum())
}

/// Sum of the squared distances of nodes from the nearest of three sides, in standard deviations; `None`
/// unless the middle one leads from the first to the last.
fn sharp_misfit(nodes: &[&Kept], sides: [&Side; 3]) -> Option<f64> {
    let [a, short, b] = sides;
    let (begins, ends) = (a.meeting(short)?[1], short.meeting(b)?[0]);
    let off = |k: &&Kept| (nearest(k, &sides) / k.sigma).powi(2);
    (begins < ends).then(|| nodes.iter().map(off).sum())
}

/// The same with an arc that touches all three sides instead of the middle one; `None` if there is none.
fn round_misfit(nodes: &[&Kept], [a, short, b]: [&Side; 3]) -> Option<f64> {
    let (begins, ends) = (a.meeting(short)?, short.meeting(b)?);
    let along = short.at(begins[1]).direction;
    let (before, after) = (a.at(begins[0]).direction, b.at(ends[1]).direction);
    let turns = [
        before.perp(&along).atan2(before.dot(&along)),
        along.perp(&after).atan2(along.dot(&after)),
    ];
    if turns[0] * turns[1] <= 0.0 {
        return None;
    }
    let tangents = turns.map(|t| (0.5 * t.abs()).tan());
    let radius = (ends[0] - begins[1]) / (tangents[0] + tangents[1]);
    if radius.is_nan() || radius <= 0.0 {
        return None;
    }
    let touches = short.at(begins[1] + radius * tangents[0]).position;
    let centre = touches + left_of(&along) * (radius * turns[0].signum());
    let off = |k: &&Kept| {
        let d = k.position - centre;
        // Ahead of where the arc begins, and behind where it ends.
        let beside_arc = d.dot(&before) > 0.0 && d.dot(&after) < 0.0;
        let off = if beside_arc { (d.norm() - radius).abs() } else { nearest(k, &[a, b]) };
        (off / k.sigma).powi(2)
    };
    Some(nodes.iter().map(off).sum())
}

/// Distance of a node from the nearest of some sides.
fn nearest(k: &Kept, sides: &[&Side]) -> f64 {
    let off = sides.iter().map(|s| s.offsets(&k.position).1.abs());
    off.fold(f64::INFINITY, f64::min)
}
