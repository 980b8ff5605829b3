//! Control points by least squares.
//!
//! The sum of squared distances of the nodes from the spline at their parameters is least where the
//! normal equations hold. Each parameter depends on four control points, so conjugate gradients
//! need no matrix. They start from points of the polyline, at the parameter of each control point's
//! largest weight. Control points that the nodes do not determine stay there.

use super::basis::Knots;
use crate::{Point2, Vector2};

/// Largest number of steps. Chosen by hand: one or two dozen are usual.
const STEPS: usize = 200;
/// Gradient, as a share of the first one, at which the iteration ends. Chosen by hand, far below
/// any tolerance, as is twice or half of it.
const ENOUGH: f64 = 1e-12;

/// Parameters of points: their distance along the polyline.
pub(super) fn chord_lengths(points: &[Point2]) -> Vec<f64> {
    let mut length = 0.0;
    let steps = points.windows(2).map(|pair| (pair[1] - pair[0]).norm());
    let rest = steps.map(|step| {
        length += step;
        length
    });
    std::iter::once(0.0).chain(rest).collect()
}

/// The control points of the spline nearest to points. A spline that is not periodic begins and
/// ends at the end points.
pub(super) fn controls(knots: &Knots, points: &[Point2], parameters: &[f64]) -> Vec<Point2> {
    let last = parameters[parameters.len() - 1];
    let start = |u: f64| {
        polyline_at(points, parameters, if knots.periodic { u.rem_euclid(last) } else { u })
    };
    let mut controls: Vec<Point2> = knots.greville().map(start).collect();
    let fixed = !knots.periodic;
    if let (true, Some(first), Some(end)) = (fixed, points.first(), points.last()) {
        let n = controls.len();
        (controls[0], controls[n - 1]) = (*first, *end);
    }
    // The last point of a periodic spline is its first one.
    let nodes = points.len() - usize::from(knots.periodic);
    let rows: Vec<_> = parameters[..nodes].iter().map(|u| knots.row(*u)).collect();
    let apply = |x: &[Vector2]| -> Vec<Vector2> {
        rows.iter().map(|row| row.iter().map(|(k, w)| x[*k] * *w).sum()).collect()
    };
    let gather = |residuals: &[Vector2]| {
        let mut sum = vec![Vector2::zeros(); controls.len()];
        for (row, residual) in rows.iter().zip(residuals) {
            row.iter().for_each(|(k, w)| sum[*k] += residual * *w);
        }
        if let (true, [first, .., last]) = (fixed, sum.as_mut_slice()) {
            (*first, *last) = (Vector2::zeros(), Vector2::zeros());
        }
        sum
    };
    let places: Vec<Vector2> = controls.iter().map(|c| c - points[0]).collect();
    let off = apply(&places).into_iter().zip(points).map(|(at, p)| (p - points[0]) - at);
    let mut residuals: Vec<Vector2> = off.collect();
    let mut gradient = gather(&residuals);
    let mut direction = gradient.clone();
    let mut size = squared(&gradient);
    let enough = size * ENOUGH * ENOUGH;
    let mut change = vec![Vector2::zeros(); controls.len()];
    for _ in 0..STEPS {
        if size <= enough {
            break;
        }
        let along = apply(&direction);
        let step = size / squared(&along);
        change.iter_mut().zip(&direction).for_each(|(c, d)| *c += d * step);
        residuals.iter_mut().zip(&along).for_each(|(r, a)| *r -= a * step);
        gradient = gather(&residuals);
        let next = squared(&gradient);
        let turn = next / size;
        direction.iter_mut().zip(&gradient).for_each(|(d, g)| *d = g + *d * turn);
        size = next;
    }
    controls.iter().zip(change).map(|(c, d)| c + d).collect()
}

fn squared(vectors: &[Vector2]) -> f64 {
    vectors.iter().map(Vector2::norm_squared).sum()
}

/// The point of a polyline at a parameter.
fn polyline_at(points: &[Point2], parameters: &[f64], u: f64) -> Point2 {
    let after = parameters.partition_point(|p| *p <= u).clamp(1, parameters.len() - 1);
    let (from, to) = (parameters[after - 1], parameters[after]);
    let share = if to > from { ((u - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
    points[after - 1] + (points[after] - points[after - 1]) * share
}
