//! What lies along one view's curve: arc lengths, directions, and how rough it is.

use transect_geometry::{Curve, Node, Vector2};

/// Arc lengths along a curve.
pub(super) struct Arc<'a> {
    curve: &'a Curve,
    /// Arc length at each node, from the first.
    at: Vec<f64>,
    /// Length of the unit that begins at each node.
    steps: Vec<f64>,
    pub length: f64,
    /// Squared error of the nodes of four in a row, from where it begins; infinite if unknown.
    residuals: Vec<f64>,
}

impl<'a> Arc<'a> {
    pub fn new(curve: &'a Curve) -> Self {
        let mut length = 0.0;
        let steps: Vec<f64> = curve.units().map(|u| u.vector().norm()).collect();
        let mut at = Vec::with_capacity(steps.len() + 1);
        at.push(0.0);
        at.extend(steps.iter().map(|step| {
            length += step;
            length
        }));
        at.truncate(curve.nodes().len());
        let residuals = residuals(curve);
        Self { curve, at, steps, length, residuals }
    }

    pub fn to_open_end(&self, k: usize) -> f64 {
        if self.curve.is_closed() {
            f64::INFINITY
        } else {
            self.at[k].min(self.length - self.at[k])
        }
    }

    /// Standard deviation of a node across the curve by what its neighbours say: how far nodes lie off
    /// parabolas through those around them. Infinite where too few are around.
    ///
    /// Noise that neighbours share is not in it; the error of sampling is, as it changes from node to
    /// node.
    pub fn roughness(&self, k: usize) -> f64 {
        // Fours that hold the node, and one more on each side.
        const AROUND: usize = 6;
        let n = self.residuals.len();
        let closed = self.curve.is_closed();
        // The first of them, counted from one round before where a closed curve begins.
        let (first, round) =
            if closed { ((k + AROUND * n + 2 - AROUND) % n, 0) } else { (k + 1, AROUND - 1) };
        let (mut sum, mut count) = (0.0, 0.0);
        let mut at = first;
        for _ in 0..AROUND {
            let found = at.checked_sub(round).and_then(|at| self.residuals.get(at));
            if let Some(r) = found.filter(|r| r.is_finite()) {
                (sum, count) = (sum + r, count + 1.0);
            }
            at += 1;
            if closed && at == n {
                at = 0;
            }
        }
        if count > 0.0 { (sum / count).sqrt() } else { f64::INFINITY }
    }

    /// Unit direction at a node: from the mean of the nodes within `reach` before it to the mean of
    /// those after it.
    pub fn tangent(&self, k: usize, reach: f64) -> Vector2 {
        let d = self.mean_offset(k, reach, true) - self.mean_offset(k, reach, false);
        d.try_normalize(0.0).unwrap_or_else(|| self.chord(k))
    }

    fn mean_offset(&self, k: usize, reach: f64, ahead: bool) -> Vector2 {
        let nodes = self.curve.nodes();
        let here = nodes[k].position;
        let (mut sum, mut count, mut walked, mut at) = (Vector2::zeros(), 0.0, 0.0, k);
        while let Some(to) = self.step(at, ahead) {
            // Over ground that nobody saw a direction says nothing.
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

/// Of every four nodes in a row the squared error of one, if all lie on a parabola but for errors of
/// their own: the third difference, over what unit errors would make it.
fn residuals(curve: &Curve) -> Vec<f64> {
    let nodes = curve.nodes();
    let n = nodes.len();
    let count = if curve.is_closed() { n } else { n.saturating_sub(3) };
    let wrapped = |i: usize| if i < n { i } else { i % n };
    let four = |k: usize| [k, k + 1, k + 2, k + 3].map(|i| &nodes[wrapped(i)]);
    (0..count).map(|k| residual(four(k))).collect()
}

fn residual(four: [&Node; 4]) -> f64 {
    let begin = four[0].position;
    let Some(along) = (four[3].position - begin).try_normalize(0.0) else { return f64::INFINITY };
    let local = four.map(|node| node.position - begin);
    let (x, y) = (local.map(|d| d.dot(&along)), local.map(|d| along.perp(&d)));
    let seen = four[..3].iter().all(|node| !node.bridged);
    let forward = x[0] < x[1] && x[1] < x[2] && x[2] < x[3];
    if !(seen && forward) {
        return f64::INFINITY;
    }
    let share = |i: usize| {
        let product: f64 = (0..4).filter(|j| *j != i).map(|j| x[i] - x[j]).product();
        1.0 / product
    };
    let shares = [share(0), share(1), share(2), share(3)];
    let difference: f64 = shares.iter().zip(&y).map(|(s, y)| s * y).sum();
    difference * difference / shares.iter().map(|s| s * s).sum::<f64>()
}
