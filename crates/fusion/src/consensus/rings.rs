//! Rings: closed curves that nothing tells from a circle become one.
//!
//! **Problem.** A window of a few footprints sees much of a leg or a hole from one end to the other; its
//! parabola has too few neighbours, and every node errs by itself.
//!
//! **Idea.** All nodes of a closed curve together have few errors left if the curve has few unknowns. A circle
//! has three. Whether it is one, its nodes tell: the next harmonics of the distance from its centre
//! then are no larger than their errors.
//!
//! **Steps**, on each closed piece without gaps whose nodes go round a centre.
//! 1. The circle of least squares: `r(φ) = c₀ + c₁ cos φ + s₁ sin φ` around a centre that moves until c₁ and
//!    s₁ vanish.
//! 2. Harmonics up to the fourth, of an ellipse, a triangle and a square. If together they are no
//!    more than their errors, the piece is a circle.
//! 3. The nodes move onto it, with nodes in between where the chord would turn by much.
//!
//! Errors that a view's neighbours have in common make harmonics too; then the piece stays as it is.

use super::Kept;
use super::pieces::Piece;
use super::window::left_of;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::{FRAC_PI_2, TAU};
use transect_geometry::{Point2, Vector2};

/// Highest harmonic that is looked at.
const HARMONICS: usize = 4;

/// Standard deviations by which the squares of the harmonics may exceed what errors make them.
const CONFIDENCE: f64 = 3.0;

/// Largest radius, in footprints: on larger rings the narrowest window turns by less than what a parabola
/// follows, and windows may choose.
const LARGEST_RADIUS: f64 = 19.0;

/// Longest step along a ring, in footprints: beyond it nobody saw the ground between.
const LONGEST_STEP: f64 = 3.0;

/// Largest turn between neighbouring nodes, in radians.
const LARGEST_TURN: f64 = 0.3;

/// Makes pieces circles; new nodes are added to `kept`.
pub(super) fn round(kept: &mut Vec<Kept>, pieces: &mut [Piece]) {
    for piece in pieces.iter_mut().filter(|p| p.closed) {
        let nodes: Vec<&Kept> = piece.nodes.iter().map(|k| &kept[*k as usize]).collect();
        if let Some(circle) = Circle::new(&nodes) {
            let nodes = circle.nodes(&nodes);
            let first = kept.len() as u32;
            kept.extend(nodes);
            piece.nodes = (first..kept.len() as u32).collect();
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
    /// `None` if the nodes go not once round, with steps that were seen, or are no circle.
    fn new(nodes: &[&Kept]) -> Option<Self> {
        const ROUNDS: usize = 5;
        let harmonics = HARMONICS.min((nodes.len().checked_sub(1)?) / 2);
        if harmonics < 2 || !is_small(nodes) || !is_seen(nodes) {
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
    fn nodes(&self, nodes: &[&Kept]) -> Vec<Kept> {
        let angle = |k: &Kept| {
            let d = k.position - self.centre;
            d.y.atan2(d.x)
        };
        let next = nodes.iter().skip(1).chain(nodes.first());
        let mut placed = Vec::with_capacity(2 * nodes.len());
        for (a, b) in nodes.iter().zip(next) {
            let (from, turn) = (angle(a), turn(angle(a), angle(b)));
            let count = (turn.abs() / LARGEST_TURN).ceil().max(1.0);
            let lighter = if a.weight < b.weight { a } else { b };
            for step in 0..count as usize {
                let k = if step == 0 { a } else { lighter };
                placed.push(self.node(k, from + turn * step as f64 / count, turn.signum()));
            }
        }
        placed
    }

    fn node(&self, k: &Kept, angle: f64, sign: f64) -> Kept {
        let out = Vector2::new(angle.cos(), angle.sin());
        let row = DVector::from_row_slice(&[1.0, out.x, out.y]);
        let variance = row.dot(&(&self.covariance * &row));
        Kept {
            position: self.centre + out * self.radius,
            tangent: left_of(&out) * sign,
            sigma: (variance + k.common_variance).sqrt(),
            correlation: k.correlation.max(self.radius),
            ..*k
        }
    }
}

fn footprint(nodes: &[&Kept]) -> f64 {
    nodes.iter().map(|k| k.footprint).sum::<f64>() / nodes.len() as f64
}

fn perimeter(nodes: &[&Kept]) -> f64 {
    let next = nodes.iter().skip(1).chain(nodes.first());
    nodes.iter().zip(next).map(|(a, b)| (b.position - a.position).norm()).sum()
}

/// Whether the way round is not much longer than that round the largest ring, as noise may make it.
fn is_small(nodes: &[&Kept]) -> bool {
    perimeter(nodes) <= 2.0 * TAU * LARGEST_RADIUS * footprint(nodes)
}

/// Whether no step round is a gap.
fn is_seen(nodes: &[&Kept]) -> bool {
    let next = nodes.iter().skip(1).chain(nodes.first());
    nodes.iter().zip(next).all(|(a, b)| {
        (b.position - a.position).norm() <= LONGEST_STEP * a.footprint.max(b.footprint)
    })
}

/// Of each node the inverse of its variance; nodes that share their errors say less.
fn weights(nodes: &[&Kept]) -> Vec<f64> {
    let step = perimeter(nodes) / nodes.len() as f64;
    let weight = |k: &&Kept| {
        let shared = (k.correlation / step).clamp(1.0, nodes.len() as f64);
        let random = (k.sigma * k.sigma - k.common_variance).max(f64::MIN_POSITIVE);
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
    let next = samples.iter().skip(1).chain(samples.first());
    let turns: Vec<f64> = samples.iter().zip(next).map(|(a, b)| turn(a[0], b[0])).collect();
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
        // Sums by hand: how a product of larger matrices is rounded depends on the processor.
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
    fn ring(count: u32, distance: impl Fn(f64) -> f64) -> Vec<Kept> {
        let node = |k: u32| {
            let angle = TAU * f64::from(k) / f64::from(count);
            let out = Vector2::new(angle.cos(), angle.sin());
            let noise = f64::from((k + 1) * 7919 % 101) / 101.0 - 0.5;
            let position = Point2::new(3.0, 5.0) + out * (distance(angle) + 3.46 * SIGMA * noise);
            Kept { sigma: SIGMA, weight: 1.0, ..Kept::new(position, left_of(&out), 1.0) }
        };
        (0..count).map(node).collect()
    }

    fn rounded(mut kept: Vec<Kept>) -> Vec<Kept> {
        let nodes = (0..kept.len() as u32).collect();
        let mut pieces = [Piece { nodes, closed: true }];
        round(&mut kept, &mut pieces);
        pieces[0].nodes.iter().map(|k| kept[*k as usize]).collect()
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
