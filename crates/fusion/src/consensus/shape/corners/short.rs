//! Short sides: the end of a thin part, between two long sides that face each other.
//!
//! **Problem.** The end of a thin part has too few nodes to be found as a side, and smoothing
//! leaves most of them off it. So both its corners are cut off.
//!
//! **Idea.** The long sides are known well. Of the end, two numbers are left to find: where it
//! crosses them, and its slant. Few nodes determine the slant badly, so it is drawn towards none.
//!
//! **Steps.**
//! 1. The direction straight across both sides.
//! 2. A line through each run of nodes between the sides, its slant drawn towards none as far as it
//!    is uncertain.
//! 3. The line that fits best: each node between is compared with the nearest of the three sides.
//! 4. An arc that touches all three sides is the alternative. If an arc fits much better, the end
//!    is round.

use super::super::super::estimate::PlacedNode;
use super::super::super::tuning::corners::*;
use super::super::super::window::left_of;
use super::path::{Path, Stretch};
use super::side::Side;
use transect_geometry::Vector2;

/// The short side between two that follow each other and face each other.
pub(super) fn between(path: &Path<'_>, a: &Stretch, b: &Stretch) -> Option<Stretch> {
    let n = path.len();
    let first = a.first + a.count;
    let count = (b.first + 2 * n - first) % n;
    let longest = LONGEST_WAY * a.side.footprint.min(b.side.footprint);
    if !(1..=MAX_SHORT_NODES).contains(&count) || path.way(first + n - 1, count + 1) > longest {
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
    (misfit <= MAX_ROUND_RATIO * round).then_some(short)
}

/// The direction across two sides, from the first to the second; `None` unless they face each
/// other.
fn across(a: &Side, b: &Side) -> Option<Vector2> {
    let (before, after) = (a.at(a.length), b.at(0.0));
    if before.direction.dot(&after.direction) > FACING {
        return None;
    }
    let across = left_of(&(before.direction - after.direction)).try_normalize(0.0)?;
    let step = (after.position - before.position).dot(&across);
    (step != 0.0).then(|| across * step.signum())
}

/// Sum of the squared distances of nodes from the nearest of three sides, in standard deviations;
/// `None` unless the middle one leads from the first to the last.
fn sharp_misfit(nodes: &[&PlacedNode], sides: [&Side; 3]) -> Option<f64> {
    let [a, short, b] = sides;
    let (begins, ends) = (a.meeting(short)?[1], short.meeting(b)?[0]);
    let off = |k: &&PlacedNode| (nearest(k, &sides) / k.sigma).powi(2);
    (begins < ends).then(|| nodes.iter().map(off).sum())
}

/// The same with an arc that touches all three sides instead of the middle one; `None` without one.
fn round_misfit(nodes: &[&PlacedNode], [a, short, b]: [&Side; 3]) -> Option<f64> {
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
    let off = |k: &&PlacedNode| {
        let d = k.position - centre;
        // Ahead of where the arc begins, and behind where it ends.
        let beside_arc = d.dot(&before) > 0.0 && d.dot(&after) < 0.0;
        let off = if beside_arc { (d.norm() - radius).abs() } else { nearest(k, &[a, b]) };
        (off / k.sigma).powi(2)
    };
    Some(nodes.iter().map(off).sum())
}

/// Distance of a node from the nearest of some sides.
fn nearest(k: &PlacedNode, sides: &[&Side]) -> f64 {
    let off = sides.iter().map(|s| s.offsets(&k.position).1.abs());
    off.fold(f64::INFINITY, f64::min)
}
