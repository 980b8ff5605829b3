//! One side of a corner: the line that its nodes follow, extended to where the other side meets it.

use super::super::super::estimate::PlacedNode;
use super::super::super::tuning::corners::*;
use super::super::super::window::left_of;
use transect_geometry::{Point2, Vector2};

/// A straight line through nodes in the order of a chain: x along, y to the left.
///
/// `y = place + slope (x − centre)`, with the centre of gravity of the nodes, so that place and
/// slope have independent errors.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side {
    origin: Point2,
    along: Vector2,
    centre: f64,
    place: Estimate,
    slope: Estimate,
    /// Curvature of the nodes, positive to the left; 0 of a side with a stated direction. The side
    /// itself is straight.
    pub bend: Estimate,
    /// Where the last node lies along; the first is at 0.
    pub length: f64,
    /// Mean footprint of the nodes.
    pub footprint: f64,
}

/// A number and its variance.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Estimate {
    pub value: f64,
    pub variance: f64,
}

/// A place on a side or on its extension.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub position: Point2,
    /// Unit direction of the chain.
    pub direction: Vector2,
    /// Standard deviation across, without the systematic errors of views.
    pub sigma: f64,
}

/// A node in the frame of a side.
struct Sample {
    x: f64,
    y: f64,
    weight: f64,
}

impl Side {
    /// The side through at least two nodes; `None` if they are all in one place.
    pub fn new(nodes: &[&PlacedNode]) -> Option<Self> {
        let (first, last) = (nodes.first()?, nodes.last()?);
        let along = (last.position - first.position).try_normalize(0.0)?;
        Self::leading(nodes, along, f64::INFINITY)
    }

    /// A side through nodes, about in a direction: before any node is known, the slope has this
    /// standard deviation. `None` unless the nodes lead that way.
    pub fn leading(nodes: &[&PlacedNode], along: Vector2, slopes: f64) -> Option<Self> {
        let (first, last) = (nodes.first()?, nodes.last()?);
        let length = (last.position - first.position).dot(&along);
        let footprint = |k: &&PlacedNode| k.evidence.footprint;
        let step =
            if nodes.len() > 1 { length / (nodes.len() - 1) as f64 } else { footprint(first) };
        let sample = |k: &&PlacedNode| {
            let d = k.position - first.position;
            // Nodes that share their errors count as fewer. What all nodes share moves the side as
            // a whole, and is added to its corner.
            let shared = (k.correlation / step).max(1.0);
            let weight = 1.0 / (k.random_sigma().powi(2) * shared);
            Sample { x: d.dot(&along), y: d.dot(&left_of(&along)), weight }
        };
        let samples: Vec<Sample> = nodes.iter().map(sample).collect();
        let sum = |f: &dyn Fn(&Sample) -> f64| samples.iter().map(|s| s.weight * f(s)).sum::<f64>();
        let weight = sum(&|_| 1.0);
        let [centre, place] = [sum(&|s| s.x) / weight, sum(&|s| s.y) / weight];
        let squares = sum(&|s| (s.x - centre).powi(2)) + slopes.powi(-2);
        let slope = sum(&|s| (s.x - centre) * (s.y - place)) / squares;
        let side = Self {
            origin: first.position,
            along,
            centre,
            place: Estimate { value: place, variance: 1.0 / weight },
            slope: Estimate { value: slope, variance: 1.0 / squares },
            bend: if slopes.is_finite() { Estimate::default() } else { bend(&samples, centre) },
            length,
            footprint: nodes.iter().map(footprint).sum::<f64>() / nodes.len() as f64,
        };
        let numbers = [side.place, side.slope].map(|e| e.value + e.variance);
        (length >= 0.0 && numbers.iter().all(|n| n.is_finite())).then_some(side)
    }

    /// How far a place lies along, from the first node, and across from the side.
    pub fn offsets(&self, place: &Point2) -> (f64, f64) {
        let d = place - self.origin;
        let x = d.dot(&self.along);
        (x, d.dot(&left_of(&self.along)) - self.across(x))
    }

    fn across(&self, x: f64) -> f64 {
        self.place.value + self.slope.value * (x - self.centre)
    }

    /// How far a node lies off the side, as a share of the limit for nodes on it.
    pub fn off(&self, k: &PlacedNode) -> f64 {
        let (x, across) = self.offsets(&k.position);
        let sigma = k.random_sigma().hypot(self.at(x).sigma);
        across.abs() / (ON_SIGMAS * sigma + ON_FOOTPRINTS * k.evidence.footprint)
    }

    /// The place that lies so far along.
    pub fn at(&self, x: f64) -> Place {
        let normal = left_of(&self.along);
        let variance = self.place.variance + self.slope.variance * (x - self.centre).powi(2);
        Place {
            position: self.origin + self.along * x + normal * self.across(x),
            direction: (self.along + normal * self.slope.value).normalize(),
            sigma: variance.sqrt(),
        }
    }

    /// Where this side, extended forwards, meets one that follows it, extended backwards: how far
    /// along each. `None` if they do not meet at an angle.
    pub fn meeting(&self, next: &Self) -> Option<[f64; 2]> {
        let (a, b) = (self.at(self.length), next.at(0.0));
        let (gap, turn) = (b.position - a.position, a.direction.perp(&b.direction));
        if turn.abs() < SMALLEST_SINE {
            return None;
        }
        let steps = [gap.perp(&b.direction) / turn, gap.perp(&a.direction) / turn];
        // A step on the line, seen along the frame's x.
        let along = [
            self.length + steps[0] * a.direction.dot(&self.along),
            steps[1] * b.direction.dot(&next.along),
        ];
        along.iter().all(|x| x.is_finite()).then_some(along)
    }
}

/// Curvature of samples: twice the coefficient of the polynomial of second order that is orthogonal
/// to the line over the samples.
fn bend(samples: &[Sample], centre: f64) -> Estimate {
    let sum = |f: &dyn Fn(&Sample) -> f64| samples.iter().map(|s| s.weight * f(s)).sum::<f64>();
    let from_centre = |s: &Sample| s.x - centre;
    let slope = sum(&|s| s.x * s.x * from_centre(s)) / sum(&|s| from_centre(s).powi(2));
    let mean = sum(&|s| s.x * s.x) / sum(&|_| 1.0);
    let polynomial = |s: &Sample| s.x * s.x - slope * from_centre(s) - mean;
    let norm = sum(&|s| polynomial(s).powi(2));
    Estimate { value: 2.0 * sum(&|s| s.y * polynomial(s)) / norm, variance: 4.0 / norm }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_all_nodes_share_does_not_widen_a_side() {
        let side = |view_variance: f64| {
            let node = |k: u32| {
                let place = Point2::new(0.1 * f64::from(k), 0.0);
                let mut node = PlacedNode::at(place, Vector2::x(), 0.1);
                node.evidence.view_variance = view_variance;
                node.sigma = 0.002_f64.hypot(view_variance.sqrt());
                node
            };
            let nodes = [0, 1, 2, 3].map(node);
            Side::new(&nodes.each_ref()).unwrap().at(0.4).sigma
        };
        // Four nodes, at two and a half steps from their middle: 1/4 + 2.5² / 5 of a variance.
        assert!((side(0.0) - 0.002 * 1.5_f64.sqrt()).abs() < 1e-9, "{}", side(0.0));
        assert!((side(1e-4) - side(0.0)).abs() < 1e-9, "{}", side(1e-4));
    }
}
