//! Where the patches of one view lie over those of another: the observations of a refinement.

use crate::CoarseView;
use crate::tuning::{ALIKE_DEGREES, GATE, LEAST_MEETINGS, PROBES};
use nalgebra::{Matrix6, Vector6};
use rayon::prelude::*;
use transect_device::{Isometry3, Point3, Vector3};

/// A patch as an observation.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    pub in_sensor: Point3,
    pub normal: Vector3,
    pub sigma: f64,
}

/// The samples of a view, in an order in which every beginning is spread over the image.
pub fn samples(view: &CoarseView, most: usize) -> Vec<Sample> {
    let all: Vec<_> = view.patches().collect();
    let mut order: Vec<(u32, usize)> = (0..all.len()).map(|k| (scrambled(k as u32), k)).collect();
    order.sort_unstable();
    let taken = order.iter().take(most).filter_map(|(_, k)| all.get(*k));
    let sample = |(_, patch): &(usize, &crate::Patch)| Sample {
        in_sensor: patch.point(),
        normal: patch.steady_normal(),
        sigma: patch.sigma(),
    };
    taken.map(sample).collect()
}

/// A number that looks random, different for every input (multiplication by an odd number is a
/// bijection; the constants are those of a common integer hash).
pub fn scrambled(k: u32) -> u32 {
    let x = (k ^ (k >> 16)).wrapping_mul(0x45d9_f3b5);
    (x ^ (x >> 16)).wrapping_mul(0x45d9_f3b5)
}

/// A sample of view `a` over a patch of view `b`.
#[derive(Debug, Clone, Copy)]
pub struct Observation {
    /// The cell of `b`.
    pub cell: usize,
    /// Change of the distance with a motion of `a`: translation, then rotation about the origin.
    pub gradient: Vector6<f64>,
    /// Distance of the sample from the patch along the patch's normal.
    pub distance: f64,
    /// Variance of the distance from the noise of both patches.
    pub variance: f64,
}

/// The observations of an ordered pair of views.
#[derive(Debug, Clone)]
pub struct Pair {
    pub a: usize,
    pub b: usize,
    pub observations: Vec<Observation>,
    /// Variance that the noise does not explain.
    pub excess: f64,
}

/// Views and their samples.
pub struct Scene<'a> {
    pub views: Vec<&'a CoarseView>,
    pub samples: Vec<Vec<Sample>>,
    /// Origin of the rotations, in the world: the middle of everything.
    pub origin: Point3,
}

/// How far a sample may lie from a patch: as far as both poses may be wrong.
#[derive(Debug, Clone, Copy)]
pub struct Reach {
    pub rotation: f64,
    pub translation: f64,
}

impl Scene<'_> {
    /// The ordered pairs of views that may overlap.
    pub fn pairs(&self, poses: &[Isometry3], reach: Reach) -> Vec<(usize, usize)> {
        let n = self.views.len();
        let all: Vec<_> = (0..n).flat_map(|a| (0..n).map(move |b| (a, b))).collect();
        let meets = |&(a, b): &(usize, usize)| {
            let probes = self.samples.get(a).map_or(0, |s| s.len().min(PROBES));
            a != b && self.observe(a, b, poses, reach, PROBES).len() * 50 >= probes.max(50)
        };
        all.into_par_iter().filter(meets).collect()
    }

    /// The observations of the given pairs at the given poses.
    pub fn observe_all(
        &self,
        pairs: &[(usize, usize)],
        poses: &[Isometry3],
        reach: Reach,
        most: usize,
        spread: Spread,
    ) -> Vec<Pair> {
        let observe = |&(a, b): &(usize, usize)| {
            let observations = self.observe(a, b, poses, reach, most);
            let excess = excess(&observations, spread);
            Pair { a, b, observations, excess }
        };
        let pairs: Vec<Pair> = pairs.par_iter().map(observe).collect();
        pairs.into_iter().filter(|p| p.observations.len() >= LEAST_MEETINGS).collect()
    }

    fn observe(
        &self,
        a: usize,
        b: usize,
        poses: &[Isometry3],
        reach: Reach,
        most: usize,
    ) -> Vec<Observation> {
        let (Some(view), Some(samples)) = (self.views.get(b), self.samples.get(a)) else {
            return Vec::new();
        };
        let (Some(world_from_a), Some(world_from_b)) = (poses.get(a), poses.get(b)) else {
            return Vec::new();
        };
        let b_from_a = world_from_b.inverse() * world_from_a;
        let alike = ALIKE_DEGREES.to_radians().cos();
        let observe = |sample: &Sample| {
            let in_b = b_from_a * sample.in_sensor;
            let meeting = view.meeting(&in_b)?;
            let normal = b_from_a.rotation * sample.normal;
            let moved = reach.translation + reach.rotation * sample.in_sensor.coords.norm();
            let variance = sample.sigma.powi(2) + meeting.sigma.powi(2);
            let gate = GATE * (moved.powi(2) + variance).sqrt();
            if meeting.distance.abs() > gate || normal.dot(&meeting.normal) < alike {
                return None;
            }
            let normal = world_from_b.rotation * meeting.normal;
            let arm = world_from_b * in_b - self.origin;
            let turn = arm.cross(&normal);
            let gradient = Vector6::new(normal.x, normal.y, normal.z, turn.x, turn.y, turn.z);
            Some(Observation { cell: meeting.cell, gradient, distance: meeting.distance, variance })
        };
        samples.iter().take(most).filter_map(observe).collect()
    }
}

/// How the variance that noise leaves unexplained is found.
///
/// A displaced view contradicts another one on part of its surfaces only: on one wall of three if
/// it is shifted along that wall's normal. A median would take that wall for an outlier.
#[derive(Debug, Clone, Copy)]
pub enum Spread {
    /// From the 90 % quantile, while poses may be far off.
    Wide,
    /// From the median, once they have settled.
    Narrow,
}

impl Spread {
    /// A share, and the square of a normal variable of variance 1 below which that share lies.
    /// Theory.
    fn quantile(self) -> (f64, f64) {
        match self {
            Self::Wide => (0.9, 2.7055),
            Self::Narrow => (0.5, 0.4549),
        }
    }
}

/// The variance that the noise leaves unexplained: with it, the quantile of the squared distances
/// over their variances is that of a normal variable.
fn excess(observations: &[Observation], spread: Spread) -> f64 {
    // As many as tell a quantile to a few per cent.
    let step = observations.len().div_ceil(PROBES).max(1);
    let observations: Vec<_> = observations.iter().step_by(step).collect();
    let (share, normal) = spread.quantile();
    let mut ratios: Vec<f64> = Vec::with_capacity(observations.len());
    let mut quantile = |excess: f64| {
        ratios.clear();
        ratios.extend(observations.iter().map(|o| o.distance.powi(2) / (o.variance + excess)));
        let at = (ratios.len() as f64 * share) as usize;
        if ratios.is_empty() { 0.0 } else { *ratios.select_nth_unstable_by(at, f64::total_cmp).1 }
    };
    if quantile(0.0) <= normal {
        return 0.0;
    }
    let largest = observations.iter().map(|o| o.distance.powi(2)).fold(0.0, f64::max);
    let (mut low, mut high) = (0.0, largest / normal);
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        if quantile(middle) > normal { low = middle } else { high = middle }
    }
    high
}

/// Tukey's constant, for 95 % efficiency with normal errors. Theory.
const BIWEIGHT: f64 = 4.685;

impl Pair {
    /// The weight of an observation: Tukey's biweight over the variance.
    pub fn weight(&self, o: &Observation) -> f64 {
        let variance = o.variance + self.excess;
        let share = o.distance.powi(2) / (BIWEIGHT.powi(2) * variance);
        if share < 1.0 { (1.0 - share).powi(2) / variance } else { 0.0 }
    }

    /// The sums of weighted gradients.
    pub fn sums(&self) -> Sums {
        let mut sums = Sums { a: self.a, b: self.b, ..Sums::default() };
        for o in &self.observations {
            let weight = self.weight(o);
            sums.matrix.syger(weight, &o.gradient, &o.gradient, 1.0);
            sums.vector.axpy(weight * o.distance, &o.gradient, 1.0);
            sums.square += weight * o.distance.powi(2);
        }
        sums.matrix.fill_upper_triangle_with_lower_triangle();
        sums
    }
}

/// What a pair of views says about its relative motion: a quadratic form.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sums {
    pub a: usize,
    pub b: usize,
    pub matrix: Matrix6<f64>,
    pub vector: Vector6<f64>,
    /// Sum of the weighted squares.
    pub square: f64,
}
