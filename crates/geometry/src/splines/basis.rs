//! Knots of cubic B-splines, their basis functions and blossoms (L. Piegl, W. Tiller, The NURBS
//! Book, 1997).

use super::CubicSpline;
use crate::{Point2, Vector2};

/// The knots of a spline with ends, or of a periodic one.
#[derive(Debug, Clone)]
pub(super) struct Knots {
    all: Vec<f64>,
    /// Number of independent control points; a periodic spline repeats the first three.
    pub unknowns: usize,
    pub periodic: bool,
}

impl Knots {
    /// Knots at breaks in rising order: at least two, for a periodic spline at least five.
    pub fn new(breaks: &[f64], periodic: bool) -> Self {
        let (first, last) = (breaks[0], breaks[breaks.len() - 1]);
        let spans = breaks.len() - 1;
        let mut all = Vec::with_capacity(breaks.len() + 6);
        if periodic {
            let length = last - first;
            all.extend((1..=3).rev().map(|k| breaks[spans - k] - length));
            all.extend_from_slice(breaks);
            all.extend((1..=3).map(|k| breaks[k] + length));
            return Self { all, unknowns: spans, periodic };
        }
        all.extend([first; 3]);
        all.extend_from_slice(breaks);
        all.extend([last; 3]);
        Self { all, unknowns: spans + 3, periodic }
    }

    /// The control points on which a parameter depends, with their weights.
    pub fn row(&self, u: f64) -> [(usize, f64); 4] {
        let span = span(&self.all, u);
        let weights = weights(&self.all, span, u);
        let index =
            |k: usize| (span - 3 + k) % if self.periodic { self.unknowns } else { usize::MAX };
        [0, 1, 2, 3].map(|k| (index(k), weights[k]))
    }

    /// Parameters at which control points have the largest weight: means of three knots (Greville).
    pub fn greville(&self) -> impl Iterator<Item = f64> + '_ {
        self.all.windows(3).skip(1).take(self.unknowns).map(|w| (w[0] + w[1] + w[2]) / 3.0)
    }

    /// The same spline with its ends at control points.
    pub fn clamped(&self, mut controls: Vec<Point2>) -> CubicSpline {
        if !self.periodic {
            return CubicSpline { knots: self.all.clone(), controls };
        }
        controls.extend_from_within(..3);
        let (first, last) = (3, self.all.len() - 4);
        let ends = [self.all[first], self.all[last]];
        let inner = &self.all[first + 1..last];
        let knots: Vec<f64> = [[ends[0]; 4].as_slice(), inner, &[ends[1]; 4]].concat();
        // The control points of any knots are the blossom at three knots in a row.
        let count = knots.len() - 4;
        let control = |k: usize| {
            let at = [knots[k + 1], knots[k + 2], knots[k + 3]];
            let middle = 0.5 * (knots[k.max(3)] + knots[(k.max(3)) + 1]);
            blossom(&self.all, &controls, span(&self.all, middle), at)
        };
        let controls = (0..count).map(control).collect();
        CubicSpline { knots, controls }
    }
}

/// The span between knots that holds a parameter: `knots[span] <= u < knots[span + 1]`, or the last
/// one.
pub(super) fn span(knots: &[f64], u: f64) -> usize {
    let last = knots.len() - 4;
    let after = knots[..last].partition_point(|knot| *knot <= u);
    let mut span = after.saturating_sub(1).max(3);
    while span > 3 && knots[span] >= knots[last] {
        span -= 1;
    }
    span
}

/// The four basis functions that are not zero in a span.
fn weights(knots: &[f64], span: usize, u: f64) -> [f64; 4] {
    let mut weights = [1.0, 0.0, 0.0, 0.0];
    for degree in 1..4 {
        let mut carried = 0.0;
        for k in 0..degree {
            let (left, right) = (knots[span + 1 + k - degree], knots[span + 1 + k]);
            let part = weights[k] / (right - left);
            weights[k] = carried + (right - u) * part;
            carried = (u - left) * part;
        }
        weights[degree] = carried;
    }
    weights
}

/// The blossom of a span's cubic: affine in each of its three arguments, and the cubic itself where
/// all are equal.
pub(super) fn blossom(knots: &[f64], controls: &[Point2], span: usize, at: [f64; 3]) -> Point2 {
    let mut points = [0, 1, 2, 3].map(|k| controls[span - 3 + k]);
    for (degree, u) in (1..4).zip(at) {
        for k in (degree..4).rev() {
            let (left, right) = (knots[span - 3 + k], knots[span + 1 + k - degree]);
            let share = (u - left) / (right - left);
            let step: Vector2 = points[k] - points[k - 1];
            points[k] = points[k - 1] + step * share;
        }
    }
    points[3]
}
