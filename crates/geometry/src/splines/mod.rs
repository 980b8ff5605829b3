//! Cubic B-splines as a derived description of a curve (dissertation, section 2.4.1).
//!
//! **Problem.** A program that draws or machines splines needs a curve of thousands of nodes with
//! few control points, never farther from the curve than a stated tolerance.
//!
//! **Idea.** The dissertation names B-splines as the other way to describe a contour, their control
//! points found from its nodes. Here they are found by least squares. Knots are added where the
//! spline leaves the polyline of the nodes, until a bound that holds everywhere is within the
//! tolerance.
//!
//! **Steps.**
//! 1. A curve is cut at its corners (`corners.rs`), because a smooth spline cannot follow them. A
//!    closed curve without corners becomes one periodic spline.
//! 2. Nodes get parameters by chord length, `fit.rs` the control points by least squares; the ends
//!    of pieces stay in place.
//! 3. Between neighbouring nodes and knots, spline and chord are both polynomials of the same
//!    parameter. The Bézier control points of their difference bound it (a polynomial lies in the
//!    hull of its control points). Where the bound exceeds the tolerance, the knot span is halved;
//!    back to 2.
//! 4. If more spans than chords would be needed, the chords themselves become cubics: the deviation
//!    is then 0.
//!
//! The bound holds for the distance of every point of the spline from the polyline, and of every
//! point of the polyline from the spline, because it compares equal parameters. The true distance
//! may be smaller.
//!
//! **Place.** This crate does not know files; `exchange` writes the splines.
//!
//! **Departures from the source.** It gives no algorithm.
//!
//! **Cost.** Each round O(nodes + control points) per step of conjugate gradients; a dozen rounds.
//! Do not use it to smooth: a tolerance far above the noise rounds off details.

mod basis;
mod corners;
mod fit;

use crate::{Curve, Point2};
use basis::Knots;

/// Why a curve has no splines.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SplineError {
    /// The tolerance is zero, negative, NaN or infinite.
    #[error("the tolerance of splines must be a positive length, got {0}")]
    BadTolerance(f64),
}

/// A cubic B-spline that begins at its first control point and ends at its last.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicSpline {
    knots: Vec<f64>,
    controls: Vec<Point2>,
}

/// A curve as splines; each begins at the end of the one before.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct CurveSplines {
    /// The splines in the curve's order, cut at its corners.
    pub pieces: Vec<CubicSpline>,
    /// Whether the last ends where the first begins.
    pub closed: bool,
    /// Upper bound of the distance between splines and polyline, in the model's length unit.
    pub deviation: f64,
}

impl CubicSpline {
    /// Knots, four more than control points; the first four are equal, and so are the last four.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Control points, in plane coordinates.
    pub fn controls(&self) -> &[Point2] {
        &self.controls
    }

    /// The point at a parameter, which is clamped to those of the spline's ends.
    pub fn point(&self, u: f64) -> Point2 {
        let (first, last) = (self.knots[3], self.knots[self.knots.len() - 4]);
        let u = u.clamp(first, last);
        basis::blossom(&self.knots, &self.controls, basis::span(&self.knots, u), [u; 3])
    }
}

/// Fits splines that are nowhere farther than `tolerance` from a curve's polyline. A curve whose
/// nodes are all in one place has no pieces.
///
/// # Errors
/// [`SplineError::BadTolerance`] unless the tolerance is positive and finite.
///
/// ```
/// use transect_geometry::{Curve, Node, Point2, fit_splines};
/// let node = |k: i32| {
///     let angle = std::f64::consts::TAU * f64::from(k) / 500.0;
///     Node::at(Point2::new(2.0 * angle.cos(), angle.sin()))
/// };
/// let ellipse = Curve::new((0..500).map(node).collect(), true)?;
/// let splines = fit_splines(&ellipse, 1e-3)?;
/// assert!(splines.deviation <= 1e-3 && splines.pieces.len() == 1);
/// assert!(splines.pieces[0].controls().len() < 50);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fit_splines(curve: &Curve, tolerance: f64) -> Result<CurveSplines, SplineError> {
    if !(tolerance.is_finite() && tolerance > 0.0) {
        return Err(SplineError::BadTolerance(tolerance));
    }
    let closed = curve.is_closed();
    let mut points: Vec<Point2> = curve.nodes().iter().map(|n| n.position).collect();
    points.dedup();
    if closed && points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    if points.len() < 2 {
        // All nodes are in one place, which is no spline.
        return Ok(CurveSplines { pieces: Vec::new(), closed, deviation: 0.0 });
    }
    let (pieces, deviations): (Vec<_>, Vec<_>) = corners::pieces(&points, closed, tolerance)
        .iter()
        .map(|piece| within(&piece.points, piece.periodic, tolerance))
        .unzip();
    Ok(CurveSplines { pieces, closed, deviation: deviations.into_iter().fold(0.0, f64::max) })
}

/// The spline along points within a tolerance, and its bound. A periodic spline has its first point
/// repeated last.
fn within(points: &[Point2], periodic: bool, tolerance: f64) -> (CubicSpline, f64) {
    let parameters = fit::chord_lengths(points);
    let last = parameters.last().copied().unwrap_or(0.0);
    if points.len() < 3 || last <= 0.0 {
        return (chords(points, &parameters), 0.0);
    }
    // Periodic splines need at least four different control points.
    let mut breaks: Vec<f64> = if periodic {
        (0..=4).map(|k| last * f64::from(k) / 4.0).collect()
    } else {
        vec![0.0, last]
    };
    while breaks.len() <= points.len() {
        let knots = Knots::new(&breaks, periodic);
        let spline = knots.clamped(fit::controls(&knots, points, &parameters));
        let (deviation, split) = check(&spline, points, &parameters, &breaks, tolerance);
        if deviation <= tolerance {
            return (spline, deviation);
        }
        let before = breaks.len();
        for k in split.into_iter().rev() {
            let middle = 0.5 * (breaks[k] + breaks[k + 1]);
            if breaks[k] < middle && middle < breaks[k + 1] {
                breaks.insert(k + 1, middle);
            }
        }
        if breaks.len() == before {
            break;
        }
    }
    (chords(points, &parameters), 0.0)
}

/// Upper bound of the distance at equal parameters, and the spans in which it exceeds the
/// tolerance.
fn check(
    spline: &CubicSpline,
    points: &[Point2],
    parameters: &[f64],
    breaks: &[f64],
    tolerance: f64,
) -> (f64, Vec<usize>) {
    let (mut worst, mut split) = (0.0_f64, Vec::new());
    let mut chord = 0;
    for (k, ends) in breaks.windows(2).enumerate() {
        let mut from = ends[0];
        let mut within = true;
        while from < ends[1] {
            while chord + 2 < parameters.len() && parameters[chord + 1] <= from {
                chord += 1;
            }
            let to = parameters[chord + 1].min(ends[1]);
            let to = if to > from { to } else { ends[1] };
            let share =
                |u: f64| (u - parameters[chord]) / (parameters[chord + 1] - parameters[chord]);
            let at = |u: f64| points[chord] + (points[chord + 1] - points[chord]) * share(u);
            let bound = apart(spline, [from, to], [at(from), at(to)]);
            worst = worst.max(bound);
            within &= bound <= tolerance;
            from = to;
        }
        if !within {
            split.push(k);
        }
    }
    (worst, split)
}

/// Largest distance of the Bézier control points of spline minus `chord` between two parameters.
fn apart(spline: &CubicSpline, [from, to]: [f64; 2], chord: [Point2; 2]) -> f64 {
    let span = basis::span(&spline.knots, 0.5 * (from + to));
    let control = |k: usize| {
        let mut at = [from; 3];
        at.iter_mut().take(k).for_each(|u| *u = to);
        basis::blossom(&spline.knots, &spline.controls, span, at)
            - (chord[0] + (chord[1] - chord[0]) * (k as f64 / 3.0))
    };
    (0..4).map(|k| control(k).norm()).fold(0.0, f64::max)
}

/// The polyline itself as a cubic spline: each chord a cubic of its own.
fn chords(points: &[Point2], parameters: &[f64]) -> CubicSpline {
    let mut knots = vec![parameters[0]];
    let mut controls = vec![points[0]];
    for (pair, u) in points.windows(2).zip(parameters) {
        knots.extend([*u; 3]);
        controls.extend([1.0, 2.0, 3.0].map(|k| pair[0] + (pair[1] - pair[0]) * (k / 3.0)));
    }
    let last = parameters[parameters.len() - 1];
    knots.extend([last; 4]);
    CubicSpline { knots, controls }
}

#[cfg(test)]
mod tests;
