//! The corners of a curve, at which splines are cut.
//!
//! The direction on either side of a node points to the first node at least a few tolerances away,
//! because smaller details cannot be told from noise. A corner turns by more than a limit, and more
//! than all nodes near it.

use crate::{Point2, Vector2};

/// Smallest turn of a corner, in degrees. Chosen by hand. Halved, bends are cut into pieces;
/// doubled, corners are followed by many knots.
const LEAST_TURN_DEG: f64 = 35.0;

/// Distance of the nodes that give a node's directions, in tolerances. Chosen by hand. Doubled,
/// corners close to each other are taken as one; halved, noise makes corners.
const REACH: f64 = 6.0;

/// Points of one spline.
#[derive(Debug)]
pub(super) struct Piece {
    /// At least one; of a periodic spline the first is repeated last.
    pub points: Vec<Point2>,
    pub periodic: bool,
}

/// The pieces of a curve between its corners.
pub(super) fn pieces(points: &[Point2], closed: bool, tolerance: f64) -> Vec<Piece> {
    let n = points.len();
    let whole = |first: usize, last: usize, periodic: bool| Piece {
        points: (first..=last).map(|k| points[k % n]).collect(),
        periodic,
    };
    if closed && n == 2 {
        // There and back: both points are corners, however near they are.
        return vec![whole(0, 1, false), whole(1, 2, false)];
    }
    let corners = corners(points, closed, tolerance);
    match (closed && n > 2, corners.as_slice()) {
        (false, []) => vec![whole(0, n - 1, false)],
        (true, []) => vec![whole(0, n, true)],
        (false, corners) => {
            let cuts: Vec<usize> = [&[0], corners, &[n - 1]].concat();
            cuts.windows(2).map(|cut| whole(cut[0], cut[1], false)).collect()
        }
        (true, corners) => {
            let cuts: Vec<usize> = [corners, &[corners[0] + n]].concat();
            cuts.windows(2).map(|cut| whole(cut[0], cut[1], false)).collect()
        }
    }
}

fn corners(points: &[Point2], closed: bool, tolerance: f64) -> Vec<usize> {
    let n = points.len();
    let reach = REACH * tolerance;
    let nodes = if closed { 0..n } else { 1..n.saturating_sub(1) };
    let mut turns = vec![0.0; n];
    for k in nodes {
        let ahead = toward(points, k, closed, reach, |k| k + 1);
        let behind = toward(points, k, closed, reach, |k| k + n - 1);
        turns[k] = match (behind, ahead) {
            (Some(behind), Some(ahead)) => (-behind).angle(&ahead),
            _ => 0.0,
        };
    }
    let least = LEAST_TURN_DEG.to_radians();
    // The node with the largest turn within reach is the corner; its neighbours see the same one.
    let largest = |k: usize| {
        let rival = |other: usize| turns[other] > turns[k] || turns[other] == turns[k] && other < k;
        let mut near = Vec::new();
        for step in [1, n - 1] {
            let mut other = k;
            for _ in 0..n / 2 {
                if !closed && (other == 0 && step != 1 || other == n - 1 && step == 1) {
                    break;
                }
                other = (other + step) % n;
                if (points[other] - points[k]).norm() > reach {
                    break;
                }
                near.push(other);
            }
        }
        !near.into_iter().any(rival)
    };
    (0..n).filter(|k| turns[*k] > least && largest(*k)).collect()
}

/// Unit direction from a node to the first node beyond the reach, or to the end of the curve.
fn toward(
    points: &[Point2],
    k: usize,
    closed: bool,
    reach: f64,
    step: impl Fn(usize) -> usize,
) -> Option<Vector2> {
    let n = points.len();
    let mut other = k;
    for _ in 0..n / 2 + 1 {
        let next = step(other) % n;
        let wrapped = !closed && next.abs_diff(other) > 1;
        if wrapped {
            break;
        }
        other = next;
        if (points[other] - points[k]).norm() > reach {
            break;
        }
    }
    (points[other] - points[k]).try_normalize(0.0)
}
