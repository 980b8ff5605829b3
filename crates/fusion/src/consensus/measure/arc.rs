//! One view's curve along its length: arc lengths, directions, and roughness.

use crate::sequence::arc_lengths;
use transect_geometry::{Curve, Node, Vector2};

/// Arc lengths along a curve.
pub(super) struct Arc<'a> {
    pub curve: &'a Curve,
    /// Arc length at each node, from the first, and at the end.
    at: Vec<f64>,
    /// Length of the unit that begins at each node.
    steps: Vec<f64>,
    pub length: f64,
    /// The squared residual of each four nodes in a row, by the first of them; `None` if unknown.
    residuals: Vec<Option<f64>>,
}

impl<'a> Arc<'a> {
    pub fn new(curve: &'a Curve) -> Self {
        let steps: Vec<f64> = curve.units().map(|unit| unit.vector().norm()).collect();
        let at = arc_lengths(steps.iter().copied());
        let length = at[steps.len()];
        Self { curve, at, steps, length, residuals: residuals(curve) }
    }

    pub fn to_open_end(&self, k: usize) -> f64 {
        if self.curve.is_closed() {
            f64::INFINITY
        } else {
            self.at[k].min(self.length - self.at[k])
        }
    }

    /// Standard deviation of a node across the curve, from how far the nodes around it lie off
    /// parabolas. Infinite where too few nodes are around.
    ///
    /// The error of sampling changes from node to node and is part of it. Noise that neighbours
    /// share is not.
    pub fn roughness(&self, k: usize) -> f64 {
        // The four that hold the node, and one more on each side.
        let n = self.residuals.len() as isize;
        let wrapped = |i: isize| if self.curve.is_closed() { i.rem_euclid(n) } else { i };
        let (mut squares, mut count) = (0.0, 0.0);
        for i in k as isize - 4..k as isize + 2 {
            let residual = usize::try_from(wrapped(i)).ok().and_then(|i| self.residuals.get(i));
            if let Some(Some(square)) = residual {
                squares += square;
                count += 1.0;
            }
        }
        if count > 0.0 { (squares / count).sqrt() } else { f64::INFINITY }
    }

    /// Unit direction at a node: from the mean of the nodes within `reach` before it to the mean of
    /// those after it. On a closed curve the two sides end half way round it: nodes that both held
    /// would take away each other, and leave a direction of rounding errors.
    pub fn tangent(&self, k: usize, reach: f64) -> Vector2 {
        let reach = if self.curve.is_closed() { reach.min(0.5 * self.length) } else { reach };
        let d = self.mean_offset(k, reach, true) - self.mean_offset(k, reach, false);
        d.try_normalize(0.0).unwrap_or_else(|| self.chord(k))
    }

    /// Mean offset of the nodes within `reach` on one side: round closed curves, and up to the
    /// first bridge.
    fn mean_offset(&self, k: usize, reach: f64, ahead: bool) -> Vector2 {
        let nodes = self.curve.nodes();
        let here = nodes[k].position;
        let (mut sum, mut count, mut walked, mut at) = (Vector2::zeros(), 0.0, 0.0, k);
        while let Some(to) = self.step(at, ahead) {
            // A bridge has no measured direction.
            let unit = if ahead { at } else { to };
            if nodes[unit].bridged {
                break;
            }
            walked += self.steps[unit];
            // The nearest node always counts, however far it is.
            if (walked > reach && count > 0.0) || to == k {
                break;
            }
            sum += nodes[to].position - here;
            count += 1.0;
            at = to;
        }
        if count > 0.0 { sum / count } else { Vector2::zeros() }
    }

    fn step(&self, at: usize, ahead: bool) -> Option<usize> {
        let n = self.curve.nodes().len();
        match (ahead, self.curve.is_closed()) {
            (true, true) => Some(if at + 1 < n { at + 1 } else { 0 }),
            (false, true) => Some(if at > 0 { at - 1 } else { n - 1 }),
            (true, false) => (at + 1 < n).then_some(at + 1),
            (false, false) => at.checked_sub(1),
        }
    }

    fn chord(&self, k: usize) -> Vector2 {
        let unit = self.curve.units().nth(k.min(self.curve.units().len() - 1));
        unit.and_then(|u| u.vector().try_normalize(0.0)).unwrap_or_else(Vector2::x)
    }
}

/// For each four nodes in a row the squared error of one node, if all lie on a parabola but for
/// independent errors.
fn residuals(curve: &Curve) -> Vec<Option<f64>> {
    let nodes = curve.nodes();
    let n = nodes.len();
    let count = if curve.is_closed() { n } else { n.saturating_sub(3) };
    let inside = nodes.windows(4).map(|w| residual([&w[0], &w[1], &w[2], &w[3]]));
    let wrapped = |k: usize| residual([k, k + 1, k + 2, k + 3].map(|i| &nodes[i % n]));
    let mut residuals = Vec::with_capacity(count);
    residuals.extend(inside);
    residuals.extend((residuals.len()..count).map(wrapped));
    residuals
}

/// The third difference, over the value that unit errors would give it. Its factors are the
/// products of the distances between the other three nodes, with alternating signs, so one division
/// is enough.
fn residual([a, b, c, d]: [&Node; 4]) -> Option<f64> {
    let along = d.position - a.position;
    let (to_b, to_c) = (b.position - a.position, c.position - a.position);
    // Places along and across, times the length of the chord.
    let (length, x1, x2, x3) =
        (along.norm_squared(), along.dot(&to_b), along.dot(&to_c), along.dot(&along));
    let (y1, y2) = (along.perp(&to_b), along.perp(&to_c));
    let measured = !(a.bridged || b.bridged || c.bridged);
    if !(measured && 0.0 < x1 && x1 < x2 && x2 < x3) {
        return None;
    }
    let (x21, x31, x32) = (x2 - x1, x3 - x1, x3 - x2);
    let shares = [x21 * x31 * x32, -x2 * x3 * x32, x1 * x3 * x31, -x1 * x2 * x21];
    let difference = shares[1] * y1 + shares[2] * y2;
    let squares: f64 = shares.iter().map(|s| s * s).sum();
    let squared = difference * difference / (squares * length);
    squared.is_finite().then_some(squared)
}
