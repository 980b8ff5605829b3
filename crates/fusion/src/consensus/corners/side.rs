//! One side of a corner: the line or parabola that its nodes follow, extended to where the other side
//! meets it.

use super::super::Kept;
use super::super::window::left_of;
use transect_geometry::{Point2, Vector2};

/// Fewest nodes of a side that may bend.
const FEWEST_BENT: usize = 6;

/// A side is bent if its bend exceeds this many of its standard deviations.
const BENT_SIGMAS: f64 = 4.0;

/// Nodes lie on a side if they are no farther from it than this many standard deviations, and this
/// share of their footprint.
const ON_SIGMAS: f64 = 3.0;
const ON_FOOTPRINTS: f64 = 0.02;

/// A straight line or a parabola through nodes in the order of a piece: x along, y to the left.
///
/// The parabola is a sum of polynomials that are orthogonal over the nodes, so each coefficient has
/// an error of its own: `y = Σ c_k p_k(x)`, `var y = Σ p_k(x)² / Σ w p_k²`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side {
    origin: Point2,
    along: Vector2,
    /// Mean of x, and the mean and slope that make `p_2 = x² − slope p_1 − mean` orthogonal.
    centre: f64,
    slope: f64,
    mean: f64,
    coefficients: [f64; 3],
    variances: [f64; 3],
    /// Curvature, positive to the left, and its standard deviation, whether it counts or not.
    pub bend: (f64, f64),
    /// Where the last of its nodes lies along; the first is at 0.
    pub length: f64,
    /// Mean footprint of its nodes.
    pub footprint: f64,
}

/// A place on a side or on its extension.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub position: Point2,
    /// Unit direction of the piece.
    pub direction: Vector2,
    /// Standard deviation across.
    pub sigma: f64,
}

impl Side {
    /// The side through at least two nodes; `None` if they are all in one place.
    pub fn new(nodes: &[&Kept], bent: bool) -> Option<Self> {
        let (first, last) = (nodes.first()?, nodes.last()?);
        let chord = last.position - first.position;
        let along = chord.try_normalize(0.0)?;
        let step = chord.norm() / (nodes.len() - 1) as f64;
        let frame = (first.position, along);
        let samples: Vec<[f64; 3]> = nodes.iter().map(|k| sample(k, frame, step)).collect();
        let mut side = Self::fit(&samples, bent)?;
        (side.origin, side.along, side.length) = (first.position, along, chord.norm());
        side.footprint = nodes.iter().map(|k| k.footprint).sum::<f64>() / nodes.len() as f64;
        Some(side)
    }

    /// A straight side through nodes, about in a direction: slopes have this standard deviation before
    /// any node is known. `None` unless the nodes go that way.
    pub fn leading(nodes: &[&Kept], along: Vector2, slopes: f64) -> Option<Self> {
        let (first, last) = (nodes.first()?, nodes.last()?);
        let length = (last.position - first.position).dot(&along);
        let step =
            if nodes.len() > 1 { length / (nodes.len() - 1) as f64 } else { first.footprint };
        let frame = (first.position, along);
        let samples: Vec<[f64; 3]> = nodes.iter().map(|k| sample(k, frame, step)).collect();
        let sum = |f: &dyn Fn(&[f64; 3]) -> f64| samples.iter().map(f).sum::<f64>();
        let weight = sum(&|s| s[2]);
        let [centre, place] = [0, 1].map(|k| sum(&|s| s[2] * s[k]) / weight);
        let squares = sum(&|s| s[2] * (s[0] - centre).powi(2)) + slopes.powi(-2);
        let slope = sum(&|s| s[2] * (s[0] - centre) * (s[1] - place)) / squares;
        let footprint = nodes.iter().map(|k| k.footprint).sum::<f64>() / nodes.len() as f64;
        let side = Self {
            origin: first.position,
            along,
            centre,
            slope: 0.0,
            mean: 0.0,
            coefficients: [place, slope, 0.0],
            variances: [1.0 / weight, 1.0 / squares, 0.0],
            bend: (0.0, 0.0),
            length,
            footprint,
        };
        let finite = side.coefficients.iter().chain(&side.variances).all(|c| c.is_finite());
        (length >= 0.0 && finite).then_some(side)
    }

    /// Fits samples of x, y and weight.
    fn fit(samples: &[[f64; 3]], bent: bool) -> Option<Self> {
        let sum = |f: &dyn Fn(f64) -> f64| samples.iter().map(|[x, _, w]| w * f(*x)).sum::<f64>();
        let weight = sum(&|_| 1.0);
        let centre = sum(&|x| x) / weight;
        let squares = sum(&|x| (x - centre).powi(2));
        let mut side = Self {
            origin: Point2::origin(),
            along: Vector2::x(),
            centre,
            slope: sum(&|x| x * x * (x - centre)) / squares,
            mean: sum(&|x| x * x) / weight,
            coefficients: [0.0; 3],
            variances: [0.0; 3],
            bend: (0.0, 0.0),
            length: 0.0,
            footprint: 0.0,
        };
        for k in 0..3 {
            let p = |x: f64| side.polynomials(x)[k];
            let norm = sum(&|x| p(x).powi(2));
            let product: f64 = samples.iter().map(|[x, y, w]| w * y * p(*x)).sum();
            let (coefficient, variance) = (product / norm, 1.0 / norm);
            if k == 2 {
                side.bend = (2.0 * coefficient, 2.0 * variance.sqrt());
            }
            let told = samples.len() >= FEWEST_BENT
                && coefficient.powi(2) > BENT_SIGMAS * BENT_SIGMAS * variance;
            if k < 2 || (told && bent) {
                (side.coefficients[k], side.variances[k]) = (coefficient, variance);
            }
        }
        side.coefficients.iter().chain(&side.variances).all(|c| c.is_finite()).then_some(side)
    }

    fn polynomials(&self, x: f64) -> [f64; 3] {
        let first = x - self.centre;
        [1.0, first, x * x - self.slope * first - self.mean]
    }

    /// How far a place lies along, from the first node, and across from the side.
    pub fn offsets(&self, place: &Point2) -> (f64, f64) {
        let d = place - self.origin;
        let x = d.dot(&self.along);
        (x, d.dot(&left_of(&self.along)) - self.across(x))
    }

    fn across(&self, x: f64) -> f64 {
        self.polynomials(x).iter().zip(&self.coefficients).map(|(p, c)| p * c).sum()
    }

    /// How far a node lies off the side, as a share of what still counts as on it.
    pub fn off(&self, k: &Kept) -> f64 {
        let (x, across) = self.offsets(&k.position);
        across.abs() / (ON_SIGMAS * k.sigma.hypot(self.at(x).sigma) + ON_FOOTPRINTS * k.footprint)
    }

    /// The place that lies so far along.
    pub fn at(&self, x: f64) -> Place {
        let normal = left_of(&self.along);
        let [_, c1, c2] = self.coefficients;
        let slope = c1 + c2 * (2.0 * x - self.slope);
        let variance: f64 =
            self.polynomials(x).iter().zip(&self.variances).map(|(p, v)| p * p * v).sum();
        Place {
            position: self.origin + self.along * x + normal * self.across(x),
            direction: (self.along + normal * slope).normalize(),
            sigma: variance.sqrt(),
        }
    }

    /// Where this side, extended forwards, meets one that follows it, extended backwards: how far
    /// along each. `None` if they do not meet at an angle.
    pub fn meeting(&self, next: &Self) -> Option<[f64; 2]> {
        const STEPS: usize = 4;
        const SMALLEST_SINE: f64 = 0.3;
        let mut along = [self.length, 0.0];
        for _ in 0..STEPS {
            let (a, b) = (self.at(along[0]), next.at(along[1]));
            let (gap, turn) = (b.position - a.position, a.direction.perp(&b.direction));
            if turn.abs() < SMALLEST_SINE {
                return None;
            }
            let steps = [gap.perp(&b.direction) / turn, gap.perp(&a.direction) / turn];
            // A step on the tangent, seen along the frame's x.
            along[0] += steps[0] * a.direction.dot(&self.along);
            along[1] += steps[1] * b.direction.dot(&next.along);
        }
        along.iter().all(|x| x.is_finite()).then_some(along)
    }
}

/// Place and weight of a node. Nodes that share their errors say less.
fn sample(k: &Kept, (origin, along): (Point2, Vector2), step: f64) -> [f64; 3] {
    let d = k.position - origin;
    let shared = (k.correlation / step).max(1.0);
    [d.dot(&along), d.dot(&left_of(&along)), 1.0 / (k.sigma * k.sigma * shared)]
}
