//! Rings: small closed chains that cannot be told from a circle become one.
//!
//! **Problem.** A window of a few footprints covers much of a leg or a hole. Its parabola has too
//! few neighbours, and every node errs by itself.
//!
//! **Idea.** All nodes of a closed chain together leave little error if the curve has few unknowns.
//! A circle has three. Its nodes show whether it is one: the next harmonics of the distance from
//! its centre are then no larger than their errors.
//!
//! **Steps**, on each closed chain without gaps whose nodes go round a centre.
//! 1. The circle of least squares: `r(φ) = c₀ + c₁ cos φ + s₁ sin φ` around a centre that moves
//!    until c₁ and s₁ vanish.
//! 2. Harmonics up to the fourth, of an ellipse, a triangle and a square. If together they are no
//!    larger than their errors, the chain is a circle.
//! 3. The nodes move onto it, with nodes in between where the chord would turn by much.
//!
//! Errors that neighbours of one view share make harmonics too; the chain then stays as it is.

use super::super::connect::Chain;
use super::super::estimate::PlacedNode;
use super::super::tuning::rings::*;
use super::super::window::left_of;
use crate::sequence::neighbours;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::{FRAC_PI_2, TAU};
use transect_geometry::{Point2, Vector2};

/// Makes chains circles; new nodes are added to `nodes`.
pub(super) fn round(nodes: &mut Vec<PlacedNode>, chains: &mut [Chain]) {
    for chain in chains.iter_mut().filter(|c| c.closed) {
        let round: Vec<&PlacedNode> = chain.nodes.iter().map(|k| &nodes[*k as usize]).collect();
        if let Some(circle) = Circle::new(&round) {
            let placed = circle.nodes(&round);
            let first = nodes.len() as u32;
            nodes.extend(placed);
            chain.nodes = (first..nodes.len() as u32).collect();
        }
    }
}

/// A node seen from a centre: its angle, distance and weight.
type Sample = [f64; 3];

/// A circle through nodes.
struct Circle {
    centre: Point2,
    radius: f64,
    /// Covariance of radius and centre.
    covariance: DMatrix<f64>,
}

impl Circle {
    /// `None` if the nodes do not go once round without a gap, or are no circle.
    fn new(nodes: &[&PlacedNode]) -> Option<Self> {
        let harmonics = HARMONICS.min((nodes.len().checked_sub(1)?) / 2);
        if harmonics < 2 || !is_small(nodes) || !has_no_gap(nodes) {
            return None;
        }
        let places: Vec<Point2> = nodes.iter().map(|k| k.position).collect();
        let sum: Vector2 = places.iter().map(|p| p.coords).sum();
        let mut centre = Point2::from(sum / places.len() as f64);
        let weights = weights(nodes);
        for _ in 0..ROUNDS {
            let fit = Harmonics::new(&polar(&places, &weights, &centre), 1)?;
            centre += Vector2::new(fit.coefficients[1], fit.coefficients[2]);
        }
        let samples = polar(&places, &weights, &centre);
        if !goes_round(&samples) {
            return None;
        }
        let (circle, all) = (Harmonics::new(&samples, 1)?, Harmonics::new(&samples, harmonics)?);
        let more = 2.0 * (harmonics - 1) as f64;
        let most = more + CONFIDENCE * (2.0 * more).sqrt();
        let radius = circle.coefficients[0];
        let is_small = radius > 0.0 && radius <= LARGEST_RADIUS * footprint(nodes);
        (is_small && circle.misfit - all.misfit <= most).then_some(Self {
            centre,
            radius,
            covariance: circle.covariance,
        })
    }

    /// The nodes on the circle, and those between.
    fn nodes(&self, nodes: &[&PlacedNode]) -> Vec<PlacedNode> {
        let angle = |k: &PlacedNode| {
            let d = k.position - self.centre;
            d.y.atan2(d.x)
        };
        let mut placed = Vec::with_capacity(2 * nodes.len());
        for (a, b) in neighbours(nodes, true) {
            let (from, turn) = (angle(a), turn(angle(a), angle(b)));
            let count = (turn.abs() / LARGEST_NODE_TURN).ceil().max(1.0);
            let lighter = if a.evidence.weight < b.evidence.weight { a } else { b };
            for step in 0..count as usize {
                let k = if step == 0 { a } else { lighter };
                placed.push(self.node(k, from + turn * step as f64 / count, turn.signum()));
            }
        }
        placed
    }

    fn node(&self, k: &PlacedNode, angle: f64, sign: f64) -> PlacedNode {
        let out = Vector2::new(angle.cos(), angle.sin());
        let row = DVector::from_row_slice(&[1.0, out.x, out.y]);
        let variance = row.dot(&(&self.covariance * &row));
        PlacedNode {
            position: self.centre + out * self.radius,
            tangent: left_of(&out) * sign,
            sigma: (variance + k.evidence.view_variance).sqrt(),
            // Two nodes of a circle share 1 + 2 cos of the angle between them, of 3. Round the
            // circle that is a third of its length.
            correlation: k.correlation.max(TAU / 3.0 * self.radius),
            ..*k
        }
    }
}

fn footprint(nodes: &[&PlacedNode]) -> f64 {
    nodes.iter().map(|k| k.evidence.footprint).sum::<f64>() / nodes.len() as f64
}

fn perimeter(nodes: &[&PlacedNode]) -> f64 {
    neighbours(nodes, true).map(|(a, b)| (b.position - a.position).norm()).sum()
}

/// Whether the way round is at most twice that of the largest ring; noise makes it longer.
fn is_small(nodes: &[&PlacedNode]) -> bool {
    perimeter(nodes) <= 2.0 * TAU * LARGEST_RADIUS * footprint(nodes)
}

/// Whether no step round is a gap.
fn has_no_gap(nodes: &[&PlacedNode]) -> bool {
    neighbours(nodes, true).all(|(a, b)| a.is_beside(b))
}

/// The inverse variance of each node, divided by how many nodes share the error.
fn weights(nodes: &[&PlacedNode]) -> Vec<f64> {
    let step = perimeter(nodes) / nodes.len() as f64;
    let weight = |k: &&PlacedNode| {
        let shared = (k.correlation / step).clamp(1.0, nodes.len() as f64);
        let random = (k.sigma * k.sigma - k.evidence.view_variance).max(f64::MIN_POSITIVE);
        1.0 / (random * shared)
    };
    nodes.iter().map(weight).collect()
}

fn polar(places: &[Point2], weights: &[f64], centre: &Point2) -> Vec<Sample> {
    let sample = |(p, w): (&Point2, &f64)| {
        let d = p - centre;
        [d.y.atan2(d.x), d.norm(), *w]
    };
    places.iter().zip(weights).map(sample).collect()
}

/// Turn from one angle to another, between half a turn right and left.
fn turn(from: f64, to: f64) -> f64 {
    let turn = (to - from).rem_euclid(TAU);
    if turn > 0.5 * TAU { turn - TAU } else { turn }
}

/// Whether samples go once round, all one way, and by less than a quarter at once.
fn goes_round(samples: &[Sample]) -> bool {
    let turns: Vec<f64> = neighbours(samples, true).map(|(a, b)| turn(a[0], b[0])).collect();
    let all: f64 = turns.iter().sum();
    let one_way = turns.iter().all(|t| t * all > 0.0 && t.abs() < FRAC_PI_2);
    one_way && (all.abs() - TAU).abs() < 1e-6
}

/// Distances from a centre as a sum of harmonics of the angle.
struct Harmonics {
    /// Mean, then cosine and sine of each.
    coefficients: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Weighted sum of squares of what is left.
    misfit: f64,
}

impl Harmonics {
    fn new(samples: &[Sample], count: usize) -> Option<Self> {
        let row = |angle: f64, k: usize| match (k, k % 2) {
            (0, _) => 1.0,
            (_, 1) => (k.div_ceil(2) as f64 * angle).cos(),
            _ => ((k / 2) as f64 * angle).sin(),
        };
        let columns = 2 * count + 1;
        let of = |angle: f64| DVector::from_fn(columns, |k, _| row(angle, k));
        // Sums by hand: the rounding of products of larger matrices depends on the processor.
        let mut normal = DMatrix::zeros(columns, columns);
        let mut moments = DVector::zeros(columns);
        for [angle, distance, weight] in samples {
            let row = of(*angle);
            for i in 0..columns {
                moments[i] += weight * distance * row[i];
                (0..columns).for_each(|j| normal[(i, j)] += weight * row[i] * row[j]);
            }
        }
        let covariance = normal.cholesky()?.inverse();
        let coefficients: DVector<f64> = &covariance * moments;
        let off = |[angle, distance, weight]: &Sample| {
            weight * (distance - of(*angle).dot(&coefficients)).powi(2)
        };
        let misfit: f64 = samples.iter().map(off).sum();
        misfit.is_finite().then_some(Self { coefficients, covariance, misfit })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIGMA: f64 = 0.05;

    /// Nodes a footprint of 1 apart at a distance from a centre that depends on the angle.
    fn ring(count: u32, distance: impl Fn(f64) -> f64) -> Vec<PlacedNode> {
        let node = |k: u32| {
            let angle = TAU * f64::from(k) / f64::from(count);
            let out = Vector2::new(angle.cos(), angle.sin());
            let noise = f64::from((k + 1) * 7919 % 101) / 101.0 - 0.5;
            let position = Point2::new(3.0, 5.0) + out * (distance(angle) + 3.46 * SIGMA * noise);
            let mut node = PlacedNode::at(position, left_of(&out), 1.0);
            (node.sigma, node.evidence.weight) = (SIGMA, 1.0);
            node
        };
        (0..count).map(node).collect()
    }

    fn rounded(mut nodes: Vec<PlacedNode>) -> Vec<PlacedNode> {
        let mut chains = [Chain { nodes: (0..nodes.len() as u32).collect(), closed: true }];
        round(&mut nodes, &mut chains);
        chains[0].nodes.iter().map(|k| nodes[*k as usize]).collect()
    }

    #[test]
    fn noisy_circles_become_round() {
        for count in [7, 12, 30, 90] {
            let radius = f64::from(count) / TAU;
            let nodes = rounded(ring(count, |_| radius));
            assert!(nodes.len() > 20, "{count}: chords turn by little");
            for k in &nodes {
                let d = k.position - Point2::new(3.0, 5.0);
                let off = (d.norm() - radius).abs();
                assert!(
                    off < 3.0 * k.sigma && k.sigma < 0.8 * SIGMA,
                    "{count}: {off} of {}",
                    k.sigma
                );
                assert!(k.tangent.perp(&d).abs() > 0.99 * d.norm(), "{count}");
            }
        }
    }

    #[test]
    fn what_is_told_from_a_circle_stays() {
        for harmonic in 2..=4 {
            let shape = |angle: f64| 4.0 + 0.1 * (f64::from(harmonic) * angle + 0.4).cos();
            assert_eq!(rounded(ring(25, shape)).len(), 25, "{harmonic}");
        }
        let square = |angle: f64| 3.0 / angle.cos().abs().max(angle.sin().abs());
        assert_eq!(rounded(ring(25, square)).len(), 25);
    }

    #[test]
    fn gaps_stay() {
        let mut kept = ring(25, |_| 4.0);
        kept.drain(3..6);
        assert_eq!(rounded(kept).len(), 22);
    }
}
