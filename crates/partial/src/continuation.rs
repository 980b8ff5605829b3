//! Whether a curve continues across missing pixels (3.5.1), for both methods.
//!
//! Of two open ends, the rules are:
//! * **direction**: the way across the gap turns by no more than [`MAX_TURN`] from the curve on
//!   either side, in the image and in the plane. A step between two parallel surfaces turns in the
//!   plane.
//! * **range**: continued straight on from either side, the curve passes the other end by no more
//!   than the range may change from one pixel to the next. An end too short for a direction passes
//!   it by the whole change of the range. So a step is a jump however many missing pixels hide it;
//! * **surface**: on both sides of the curve, from one end to the other, each valid pixel is of one
//!   surface with the valid one before it.

use crate::pixel_grid::Grid;
use transect_device::{PairGeometry, Pixel, View};
use transect_geometry::{Point2, Vector2};
use transect_image::BreakRule;

/// Largest angle between a curve's end and the way across the gap, in radians. A curve as tight as
/// five pixels in radius turns by half of this within four pixels.
const MAX_TURN: f64 = std::f64::consts::FRAC_PI_3;

/// Places that give an end its direction; fewer would see the zigzag between the two kinds of
/// pairs.
pub(crate) const REACH: usize = 5;

/// Where a curve passes between two pixels: row and column of the image, and plane coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub image: Point2,
    pub in_plane: Point2,
}

/// How much a curve turns across the gap between two ends; `None` if that is too much, or if it
/// misses the other end.
///
/// Each end is given by its first places, from the end into its curve. `continues` tells whether a
/// curve that would miss the other end by a length may be on one surface with it.
pub(crate) fn turn(
    tail: &[Place],
    head: &[Place],
    continues: impl Fn(Option<f64>) -> bool,
) -> Option<f64> {
    let (end, begin) = (tail.first()?, head.first()?);
    let (behind, ahead) = (tail.last()?, head.last()?);
    let runs = |of: fn(&Place) -> Point2| [of(end) - of(behind), of(ahead) - of(begin)];
    let across_image = begin.image - end.image;
    let across = begin.in_plane - end.in_plane;
    let mut turn = 0.0;
    for run in runs(|p| p.image) {
        turn += angle_cost(&run, &across_image)?;
    }
    for run in runs(|p| p.in_plane) {
        turn += angle_cost(&run, &across)?;
        let miss = run.try_normalize(0.0).map(|run| run.perp(&across).abs());
        if !continues(miss) {
            return None;
        }
    }
    Some(turn)
}

/// How far two directions are from one: 0 to 0.5; `None` beyond [`MAX_TURN`]. A run without length
/// has no direction and costs as much as the largest turn.
fn angle_cost(run: &Vector2, across: &Vector2) -> Option<f64> {
    let lengths = run.norm() * across.norm();
    let least = MAX_TURN.cos();
    if lengths == 0.0 {
        return Some(1.0 - least);
    }
    let cos = run.dot(across) / lengths;
    (cos >= least).then_some(1.0 - cos)
}

/// Whether a curve that runs from one pixel towards another, and misses it by a length, stays on
/// one surface. It does if the length is no larger than a change of the range between neighbours
/// may be. If it is not known, the change of the range between the two is taken.
pub(crate) fn continues(
    view: &View,
    grid: &Grid,
    rule: &BreakRule,
    [a, b]: [Pixel; 2],
    miss: Option<f64>,
) -> bool {
    let Some(pair) = view.frame().pair(view.image(), a, b) else { return false };
    let (rows, cols) = grid.offset(a, b);
    let steps = rows.abs().max(cols.abs()).max(1.0);
    let range_step = miss.map_or(pair.range_step, |m| m as f32);
    rule.holds(&PairGeometry { range_step, lateral: pair.lateral / steps as f32 })
}

/// Whether two pixels that need not be neighbours pass for samples of one surface.
pub(crate) fn alike(view: &View, rule: &BreakRule, a: Pixel, b: Pixel) -> bool {
    view.frame().pair(view.image(), a, b).is_some_and(|pair| rule.allows_step(&pair))
}

/// How many pixels are missing on the straight way from one pixel to another; `None` if the valid
/// ones are not each of one surface with the one before.
pub(crate) fn missing_between(
    grid: &Grid,
    [a, b]: [Pixel; 2],
    valid: impl Fn(Pixel) -> bool,
    alike: impl Fn(Pixel, Pixel) -> bool,
) -> Option<usize> {
    let (rows, cols) = grid.offset(a, b);
    let steps = rows.abs().max(cols.abs()).max(1.0);
    let (mut last, mut missing) = (a, 0);
    for k in 1..=steps as i32 {
        let share = f64::from(k) / steps;
        let (rows, cols) = ((rows * share).round() as i32, (cols * share).round() as i32);
        let p = grid.step(a, rows, cols)?;
        if !valid(p) {
            missing += 1;
            continue;
        }
        if p != last && !alike(last, p) {
            return None;
        }
        last = p;
    }
    (last == b).then_some(missing)
}
