//! One curve from two that overlap (dissertation 5.5.2).
//!
//! **Problem.** Where two curves show the same piece of surface, one is wanted, smoother than each
//! and half way between them.
//!
//! **Idea.** In the frame of each unit of the basis curve, the distant curve's points have
//! distances y to it. Their mean is a low-pass filter, and half of it lies between the curves.
//!
//! **Steps.**
//! 1. Sum up y over the points of the distant curve while 0 ≤ x ≤ x_end and |y| ≤ threshold.
//! 2. When x > x_end, the unit is finished: its new node is (x_end/2, Σy/2n) (Figure 5.10).
//! 3. Go on to the next unit of the basis curve if it covers the point (Figure 5.11 a). If the
//!    point lies beyond that unit, too, basis and distant curve are exchanged. The new unit ends in
//!    that point, and the first point to be processed is the start of the unit beyond which it lies
//!    (Figure 5.11 b).
//! 4. Where |y| > threshold or x < 0, look forward (Figure 5.12). At a corner the basis curve goes
//!    on to its next unit; the points of a dimple are left out.
//!
//! **Departures from the source.** In the look-forward as printed, a continuous rise of |y| or fall
//! of x means a corner. Here it is believed only if a later unit of the basis curve holds one of
//! the points looked at. Otherwise the rising flank of a wide dimple would move the basis on. A
//! point which a later unit holds is round a corner whatever noise does to the rise. For the same
//! reason no unit may end in a point that is nowhere near the basis curve when the curves are
//! exchanged. A point in the wedge outside a bend, behind one unit's end and before the next one's
//! start, counts with the next one. A node that the chord between two new nodes would leave by more
//! than the threshold is kept, or sharp corners between long units would be cut. If two exchanges
//! follow each other without a point in between, as on zigzags, the second one is not made.
//!
//! The midpoint of a chord lies inside the arc: every merge moves a curve by up to h²/8R towards
//! its inside (errata). This is the method's, and one reason why
//! [`consensus`](mod@crate::consensus) is the default. The newest curve weighs half, so half of the
//! loss is taken back with each merge, and on a circle it settles at little more than h²/8R.
//!
//! **Cost.** Linear in the nodes of both overlaps; a look-forward reaches four thresholds.

use super::strand::Strand;
use super::verify::{Limits, Start, UnitFrame, holds};
use transect_geometry::{CurveUnit, Node};

/// How far along both curves the look-forward reaches, in thresholds. Outside a corner of 30° a
/// curve runs on for up to this much farther than one that is a threshold inside it.
const LOOK_FORWARD: f64 = 4.0;

/// Fewest points and units that are looked at, however far they are apart.
const FEWEST_AHEAD: usize = 3;

/// The merged part of two curves, and where it belongs on each.
#[derive(Debug, Clone, Default)]
pub(super) struct Averaged {
    /// The new nodes.
    pub nodes: Vec<Node>,
    /// How many nodes of each strand come before them.
    pub heads: [usize; 2],
    /// The first node of each strand that comes behind them.
    pub tails: [usize; 2],
    /// Nodes behind the last new one that a chord might lose: the basis curve's.
    pub passed: Vec<Node>,
    /// Points left out as noise, by strand and node.
    pub noise: Vec<(usize, usize)>,
}

/// Averages two strands from a verified start to the end of their overlap.
pub(super) fn average(strands: [&Strand; 2], start: &Start, limits: &Limits) -> Averaged {
    let mut result = Averaged::default();
    result.heads[start.basis] = start.unit + 1;
    result.heads[1 - start.basis] = start.point;
    let mut next = [start.point; 2];
    next[start.basis] = start.unit;
    let mut walk = Walk {
        strands,
        limits,
        basis: start.basis,
        next,
        sum: Sum::default(),
        exchanged: false,
        finished: false,
        result,
    };
    // Every step moves on along one strand, and an exchange gives back no more than one unit.
    while walk.step() {}
    walk.finish()
}

/// The sums over the points of one unit.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    points: u32,
    y: f64,
    variance: f64,
    weight: f32,
}

impl Sum {
    fn add(&mut self, y: f64, node: &Node) {
        self.points += 1;
        self.y += y;
        self.variance += f64::from(node.sigma).powi(2);
        self.weight += node.weight;
    }
}

/// Along two strands, unit by unit of the basis curve and point by point of the distant one.
struct Walk<'a> {
    strands: [&'a Strand; 2],
    limits: &'a Limits,
    /// Which strand is the basis curve.
    basis: usize,
    /// The current unit of the basis curve, and the next point of the distant one.
    next: [usize; 2],
    sum: Sum,
    /// Whether no point has been processed since basis and distant curve were exchanged.
    exchanged: bool,
    /// Whether the current unit has its new node.
    finished: bool,
    result: Averaged,
}

impl Walk<'_> {
    fn step(&mut self) -> bool {
        let (Some(unit), distant) = (self.unit(), 1 - self.basis) else { return false };
        let point = self.next[distant];
        if point >= self.strands[distant].enclosed.end {
            return self.go_on_with_the_basis_alone();
        }
        let node = self.strands[distant].nodes[point];
        let frame = UnitFrame::new(&unit);
        let (x, y) = frame.local(&node.position);
        let near = y.abs() <= self.limits.threshold;
        if x > frame.x_end || frame.x_end <= 0.0 {
            return self.go_on_to(point);
        }
        let in_the_wedge = x < 0.0 && near && x.hypot(y) <= self.limits.threshold;
        if near && x >= 0.0 {
            self.add(y, &node);
        } else if self.is_corner(&frame, point) {
            self.finish_unit();
            self.advance();
        } else if in_the_wedge {
            self.add(y, &node);
        } else {
            self.leave_out(point);
        }
        true
    }

    fn unit(&self) -> Option<CurveUnit> {
        self.unit_at(self.next[self.basis])
    }

    /// A unit of the basis curve with a part in the overlap.
    fn unit_at(&self, k: usize) -> Option<CurveUnit> {
        let basis = self.strands[self.basis];
        (k < basis.enclosed.end).then(|| basis.unit(k)).flatten()
    }

    fn add(&mut self, y: f64, node: &Node) {
        self.sum.add(y, node);
        self.next[1 - self.basis] += 1;
        self.exchanged = false;
    }

    /// Finishes the unit, and goes on to the next one or exchanges the curves (Figure 5.11).
    fn go_on_to(&mut self, point: usize) -> bool {
        self.finish_unit();
        self.advance();
        let Some(unit) = self.unit() else { return false };
        let frame = UnitFrame::new(&unit);
        let distant = self.strands[1 - self.basis];
        let (x, _) = frame.local(&distant.nodes[point].position);
        if x <= frame.x_end || frame.x_end <= 0.0 {
            return true;
        }
        if self.is_beside_what_comes(point) {
            self.exchange(point);
        } else {
            self.leave_out(point);
        }
        true
    }

    fn leave_out(&mut self, point: usize) {
        self.result.noise.push((1 - self.basis, point));
        self.next[1 - self.basis] += 1;
    }

    /// Whether a point beyond the current unit is near the basis curve at all: no unit may end in
    /// the tip of a dimple.
    fn is_beside_what_comes(&self, point: usize) -> bool {
        let (basis, distant) = (self.strands[self.basis], self.strands[1 - self.basis]);
        let place = distant.nodes[point].position;
        let first = self.next[self.basis];
        let Some(unit) = basis.unit(first) else { return false };
        // Along a bend of up to 120° the way is at most twice the chord.
        let chord = (place - unit.start).norm();
        let end = self.ahead(basis, first, 2.0 * chord) + 1;
        (first..end.min(basis.units().end)).filter_map(|k| basis.unit(k)).any(|unit| {
            let along = UnitFrame::new(&unit).along;
            unit.distance(&place) <= self.limits.threshold
                && distant.runs_along(point, &along, self.limits.least_cosine)
        })
    }

    /// Behind the distant curve's last enclosed point, its last unit may cover points of the basis
    /// curve still.
    fn go_on_with_the_basis_alone(&mut self) -> bool {
        let (basis, distant) = (self.basis, 1 - self.basis);
        let point = self.next[distant];
        let more = self.next[basis] + 1 < self.strands[basis].enclosed.end;
        if !more || self.exchanged || point >= self.strands[distant].nodes.len() {
            return false;
        }
        self.finish_unit();
        self.advance();
        self.exchange(point)
    }

    /// Makes the unit that ends in a point the basis; the start of the unit so far is the next
    /// point. Not twice in a row, which would go round in circles.
    fn exchange(&mut self, point: usize) -> bool {
        let distant = 1 - self.basis;
        let Some(unit) = point.checked_sub(1).filter(|_| !self.exchanged) else { return false };
        // Nor may a unit begin in noise: the basis curve goes on by itself.
        let left_out = self.result.noise.iter().rfind(|(strand, _)| *strand == distant);
        if left_out == Some(&(distant, unit)) {
            return false;
        }
        self.basis = distant;
        self.next[self.basis] = unit;
        self.exchanged = true;
        self.finished = false;
        true
    }

    fn advance(&mut self) {
        self.next[self.basis] += 1;
        self.finished = false;
        let passed = self.strands[self.basis].nodes.get(self.next[self.basis]);
        self.result.passed.extend(passed);
    }

    /// The new node of the unit: (x_end/2, Σy/2n).
    fn finish_unit(&mut self) {
        let sum = std::mem::take(&mut self.sum);
        if sum.points == 0 {
            return;
        }
        let Some(unit) = self.unit() else { return };
        let nodes = &self.strands[self.basis].nodes;
        let (a, b) = (nodes[self.next[self.basis]], nodes[self.next[self.basis] + 1]);
        let frame = UnitFrame::new(&unit);
        let n = f64::from(sum.points);
        let variance = |node: &Node| f64::from(node.sigma).powi(2);
        // Half the middle of the unit, half the mean of the points.
        let sigma = 0.5 * (0.25 * (variance(&a) + variance(&b)) + sum.variance / (n * n)).sqrt();
        let normals = a.normal.unwrap_or_default() + b.normal.unwrap_or_default();
        let node = Node::at(frame.place(0.5 * frame.x_end, sum.y / (2.0 * n)))
            .with_sigma(sigma as f32)
            .with_footprint(0.5 * (a.footprint + b.footprint))
            .with_weight(sum.weight + 0.5 * (a.weight + b.weight))
            .with_correlation(0.5 * (a.correlation + b.correlation))
            .with_normal(normals.try_normalize(0.0));
        let passed = std::mem::take(&mut self.result.passed);
        // Nodes that a strand keeps before the first new one do not belong to this chord.
        let last = self.result.nodes.last().copied();
        if let Some(last) = last {
            let kept = lost_by(&last, &node, &passed, self.limits.threshold);
            self.result.nodes.extend(kept);
        }
        self.result.nodes.push(node);
        self.finished = true;
    }

    /// The look-forward of Figure 5.12 for a point that the current unit does not hold.
    fn is_corner(&self, frame: &UnitFrame, point: usize) -> bool {
        let distant = self.strands[1 - self.basis];
        let last = self.ahead(distant, point, 0.0).min(distant.enclosed.end.saturating_sub(1));
        if self.is_held_ahead(point) {
            return true;
        }
        let local = |k: usize| frame.local(&distant.nodes[k].position);
        let goes_on = |(x, y): (f64, f64), (x2, y2): (f64, f64)| {
            if x < 0.0 { x2 < x } else { y2.abs() > y.abs() }
        };
        let monotone = (point..last).all(|k| goes_on(local(k), local(k + 1)));
        monotone && last > point && (point + 1..=last).any(|k| self.is_held_ahead(k))
    }

    /// Whether one of the coming units of the basis curve holds a point of the distant one.
    fn is_held_ahead(&self, point: usize) -> bool {
        let (basis, distant) = (self.strands[self.basis], self.strands[1 - self.basis]);
        let first = self.next[self.basis] + 1;
        let end = (self.ahead(basis, first, 0.0) + 1).min(basis.units().end);
        (first..end).any(|unit| holds(basis, unit, distant, point, self.limits))
    }

    /// The last node of a strand that the look-forward from a node reaches, and some way more.
    fn ahead(&self, strand: &Strand, from: usize, more: f64) -> usize {
        let reach = LOOK_FORWARD * self.limits.threshold + more;
        let (mut at, mut walked) = (from, 0.0);
        while let Some(unit) = strand.unit(at) {
            walked += unit.vector().norm();
            if walked > reach && at >= from + FEWEST_AHEAD {
                break;
            }
            at += 1;
        }
        at
    }

    fn finish(mut self) -> Averaged {
        self.finish_unit();
        let (basis, distant) = (self.basis, 1 - self.basis);
        self.result.tails[basis] = self.next[basis] + usize::from(self.finished);
        self.result.tails[distant] = self.next[distant];
        self.result
    }
}

/// The nodes that the chord between two others leaves by more than the threshold.
pub(super) fn lost_by(from: &Node, to: &Node, passed: &[Node], threshold: f64) -> Vec<Node> {
    let chord = CurveUnit { start: from.position, end: to.position };
    let lost = |node: &&Node| chord.distance(&node.position) > threshold;
    passed.iter().filter(lost).copied().collect()
}

#[cfg(test)]
mod tests;
