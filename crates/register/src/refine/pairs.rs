//! Where the patches of one view lie over those of another: the observations of a refinement.

use super::camera::Cameras;
use crate::CoarseView;
use crate::tuning::{
    ALIKE_DEGREES, BLOCKS, GATE, LEAST_MEETINGS, MOST_REPRESENTED, OVERLAP_SAMPLES, PARTNERS,
    QUANTILE_SAMPLES,
};
use nalgebra::Vector6;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BTreeSet;
use transect_device::{ImageSize, Isometry3, Point3, Vector3};

/// A patch as an observation.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    pub cell: usize,
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
    let sample = |(cell, patch): &(usize, crate::Patch)| Sample {
        cell: *cell,
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
    /// The cells of `a` and of `b`.
    pub cells: [usize; 2],
    /// Change of the distance with a motion of `a`: translation, then rotation about the origin.
    pub gradient: Vector6<f64>,
    /// Distance of the sample from the patch along the patch's normal.
    pub distance: f64,
    /// Change of the distance with the errors of the cameras; 0 where there is no depth camera.
    pub slopes: CameraSlopes,
    /// Variance of the distance from the noise of both patches.
    pub variance: f64,
    /// Its weight beside the other observations of the same surface: see [`Scene::share`].
    pub share: f64,
    /// Squared difference of the normals of both patches.
    pub turned: f32,
    /// The sample, from the origin of the rotations.
    pub arm: [f32; 3],
}

/// Change of a distance with the errors of cameras, at the cell of `a` and at that of `b`.
#[derive(Debug, Clone, Copy, Default)]
pub struct CameraSlopes {
    /// With a relative change of 1 / depth.
    pub change: [f32; 2],
    /// The depths. Times these, the slopes are those over an offset of 1 / depth.
    pub depths: [f32; 2],
    /// With the relative errors of `fx` and `fy`.
    pub focal: [[f32; 2]; 2],
}

impl CameraSlopes {
    /// Those of a sample over a patch with this normal in the sensor frame of `b`.
    fn new(placed: &Placed<'_>, normal: &Vector3, b_from_a: &Isometry3) -> Self {
        let (in_a, in_b) = (placed.sample.in_sensor, placed.in_b);
        let ray = in_b.coords - b_from_a.translation.vector;
        let at_a = b_from_a.rotation.inverse_transform_vector(normal);
        let focal = [[at_a.x * in_a.x, at_a.y * in_a.y], [-normal.x * in_b.x, -normal.y * in_b.y]];
        Self {
            change: [-normal.dot(&ray), normal.dot(&in_b.coords)].map(|slope| slope as f32),
            depths: [in_a.z, in_b.z].map(|depth| depth as f32),
            focal: focal.map(|both| both.map(|slope| slope as f32)),
        }
    }
}

/// The observations of an ordered pair of views.
#[derive(Debug, Clone)]
pub struct Pair {
    pub a: usize,
    pub b: usize,
    pub observations: Vec<Observation>,
    /// Variance that the noise does not explain.
    pub excess: f64,
    /// Variance of the direction of a patch's normal about each axis across it, in rad².
    pub turned: f64,
}

/// The observations of a pair, or half of them.
#[derive(Debug, Clone, Copy)]
pub struct Portion<'a> {
    pub pair: &'a Pair,
    /// The half, and the cells of the view whose image is halved.
    pub half: Option<(usize, ImageSize)>,
}

impl<'a> From<&'a Pair> for Portion<'a> {
    fn from(pair: &'a Pair) -> Self {
        Self { pair, half: None }
    }
}

impl<'a> Portion<'a> {
    /// The observations: blocks of two colours, as on a chess board, make the two halves.
    ///
    /// Both directions of a pair see a surface, so the image of the same view halves both.
    pub fn observations(self) -> impl Iterator<Item = &'a Observation> {
        let side = usize::from(self.pair.a > self.pair.b);
        self.pair.observations.iter().filter(move |o| {
            self.half.is_none_or(|(half, size)| {
                let (row, col) = (o.cells[side] / size.cols, o.cells[side] % size.cols);
                (row * BLOCKS / size.rows + col * BLOCKS / size.cols) % 2 == half
            })
        })
    }
}

/// Views and their samples.
pub struct Scene<'a> {
    pub views: Vec<&'a CoarseView>,
    pub samples: Vec<Vec<Sample>>,
    /// Origin of the rotations, in the world: the middle of everything.
    pub origin: Point3,
}

/// How far a sample may lie from a patch: as far as both poses may be wrong, and at least as far as
/// typical pairs differ.
#[derive(Debug, Clone, Copy)]
pub struct Reach {
    pub rotation: f64,
    pub translation: f64,
    /// Variance of a typical pair that its noise leaves unexplained.
    pub unexplained: f64,
}

/// Where the views are, and what their cameras err.
#[derive(Debug, Clone, Copy)]
pub struct State<'a> {
    pub poses: &'a [Isometry3],
    pub cameras: &'a Cameras,
}

impl Scene<'_> {
    /// The ordered pairs of views that may overlap: of each view, those with most of its surface in
    /// common.
    pub fn pairs(&self, state: State<'_>, reach: Reach) -> Vec<(usize, usize)> {
        let n = self.views.len();
        let probes: Vec<Vec<Sample>> = (0..n)
            .into_par_iter()
            .map(|a| self.first_samples(a, OVERLAP_SAMPLES, state.cameras))
            .collect();
        let common = |k: usize| {
            let (a, b) = (k % n, k / n);
            let Some(probes) = probes.get(a).filter(|_| a != b) else { return 0 };
            let met = self.observe(probes, (a, b), state, reach).len();
            if met * 50 >= probes.len().max(50) { met } else { 0 }
        };
        let common: Vec<usize> = (0..n * n).into_par_iter().map(common).collect();
        let both = |a: usize, b: usize| common[b * n + a] + common[a * n + b];
        let partners = |a: usize| {
            let mut others: Vec<usize> = (0..n).filter(|&b| both(a, b) > 0).collect();
            others.sort_by_key(|&b| (Reverse(both(a, b)), b));
            others.into_iter().take(PARTNERS).collect()
        };
        let partners: Vec<BTreeSet<usize>> = (0..n).map(partners).collect();
        let all = (0..n * n).filter(|&k| common[k] > 0).map(|k| (k % n, k / n));
        all.filter(|(a, b)| partners[*a].contains(b) || partners[*b].contains(a)).collect()
    }

    /// The observations of the given pairs at the given poses.
    pub fn observe_all(
        &self,
        pairs: &[(usize, usize)],
        state: State<'_>,
        reach: Reach,
        most: usize,
        spread: Spread,
    ) -> Vec<Pair> {
        let first = |a| self.first_samples(a, most, state.cameras);
        let samples: Vec<Vec<Sample>> = (0..self.views.len()).into_par_iter().map(first).collect();
        let observe = |&(a, b): &(usize, usize)| {
            let samples = samples.get(a).map_or(&[][..], Vec::as_slice);
            let observations = self.observe(samples, (a, b), state, reach);
            let (excess, turned) = (excess(&observations, spread), turned(&observations));
            Pair { a, b, observations, excess, turned }
        };
        let pairs: Vec<Pair> = pairs.par_iter().map(observe).collect();
        let met = pairs.into_iter().filter(|p| p.observations.len() >= LEAST_MEETINGS);
        let mut pairs: Vec<Pair> = met.collect();
        // Pairs are in the order of their second view.
        pairs.par_chunk_by_mut(|x, y| x.b == y.b).for_each(|seen_by_b| self.share(seen_by_b, most));
        pairs
    }

    /// Finds the share of each observation of one view's patches.
    ///
    /// A surface that `k` views see gives `k (k - 1)` ordered pairs, whose squares add up to `k`
    /// times those of the views against their mean. So each counts as `1 / k`. Where two views
    /// alone hold the others together, they count most.
    ///
    /// With a limit on the samples, an observation represents several samples. Other observations
    /// of its surface count as often as they represent samples, so that `k` does not depend on the
    /// limit. The observation itself counts [`MOST_REPRESENTED`] times at most: its weight would
    /// fall with the square of the thinning otherwise.
    fn share(&self, pairs: &mut [Pair], most: usize) {
        let view = pairs.first().and_then(|pair| self.views.get(pair.b));
        let mut seen = vec![1.0; view.map_or(0, |view| view.size().pixels())];
        let each = |pair: &Pair| {
            self.samples.get(pair.a).map_or(1.0, |s| (s.len() as f64 / most as f64).max(1.0))
        };
        for pair in pairs.iter() {
            for o in &pair.observations {
                if let Some(views) = seen.get_mut(o.cells[1]) {
                    *views += each(pair);
                }
            }
        }
        for pair in pairs {
            let each = each(pair);
            for o in &mut pair.observations {
                let others = seen.get(o.cells[1]).map_or(1.0, |views| views - each);
                o.share = 1.0 / (others + each.min(MOST_REPRESENTED));
            }
        }
    }

    /// The first samples of a view, without the error of its camera, by their place in the image:
    /// neighbours meet neighbours, which are still in the processor's cache.
    fn first_samples(&self, view: usize, most: usize, cameras: &Cameras) -> Vec<Sample> {
        let corrected = |sample: &Sample| {
            let nodes = cameras.nodes(view, sample.cell);
            let point = sample.in_sensor;
            Sample { in_sensor: nodes.map_or(point, |n| cameras.corrected(&n, &point)), ..*sample }
        };
        let samples = self.samples.get(view).into_iter().flatten();
        let mut first: Vec<Sample> = samples.take(most).map(corrected).collect();
        first.sort_unstable_by_key(|sample| sample.cell);
        first
    }

    fn observe(
        &self,
        samples: &[Sample],
        (a, b): (usize, usize),
        State { poses, cameras }: State<'_>,
        reach: Reach,
    ) -> Vec<Observation> {
        let Some(view) = self.views.get(b) else { return Vec::new() };
        let (Some(world_from_a), Some(world_from_b)) = (poses.get(a), poses.get(b)) else {
            return Vec::new();
        };
        let b_from_a = world_from_b.inverse() * world_from_a;
        let alike = ALIKE_DEGREES.to_radians().cos();
        let has_cameras = !cameras.list.is_empty();
        let placed = samples.iter().filter_map(|sample| {
            let in_b = b_from_a * sample.in_sensor;
            // Errors of depths move a point along its ray, so the point stays in its cell.
            let cell = view.cell_of(&cameras.projected(b, &in_b))?;
            Some(Placed { sample, in_b, cell })
        });
        let placed: Vec<Placed<'_>> = placed.collect();
        // Cells lie far apart in memory. A pass that only copies them waits for several at once.
        let cells: Vec<_> = placed.iter().map(|placed| view.cell(placed.cell)).collect();
        let observe = |(placed, copy): (&Placed<'_>, Option<_>)| {
            let Placed { sample, in_b, cell } = placed;
            let (nodes, projected) = (cameras.nodes(b, *cell), cameras.projected(b, in_b));
            let measured = nodes.map_or(projected, |n| cameras.measured(&n, &projected));
            let meeting = view.meeting_with(&copy?, *cell, &measured)?;
            let normal = b_from_a.rotation * sample.normal;
            let moved = reach.translation + reach.rotation * sample.in_sensor.coords.norm();
            let variance = sample.sigma.powi(2) + meeting.sigma.powi(2);
            let beyond = moved.powi(2).max(reach.unexplained);
            let gate = GATE * (beyond + variance).sqrt();
            if meeting.distance.abs() > gate || normal.dot(&meeting.normal) < alike {
                return None;
            }
            let slopes = has_cameras.then(|| CameraSlopes::new(placed, &meeting.normal, &b_from_a));
            let slopes = slopes.unwrap_or_default();
            let turned = (normal - meeting.normal).norm_squared() as f32;
            let normal = world_from_b.rotation * meeting.normal;
            let arm = world_from_b * in_b - self.origin;
            let turn = arm.cross(&normal);
            let gradient = Vector6::new(normal.x, normal.y, normal.z, turn.x, turn.y, turn.z);
            let (cells, distance) = ([sample.cell, meeting.cell], meeting.distance);
            let share = 1.0;
            let arm = arm.map(|c| c as f32).into();
            Some(Observation { cells, gradient, distance, slopes, variance, share, turned, arm })
        };
        placed.iter().zip(cells).filter_map(observe).collect()
    }
}

/// A sample of view `a` in the sensor frame of view `b`, and the cell of `b` that its ray passes.
struct Placed<'a> {
    sample: &'a Sample,
    in_b: Point3,
    cell: usize,
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
    let step = observations.len().div_ceil(QUANTILE_SAMPLES).max(1);
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

/// The variance of normals about each of two axes, from the median square of the differences of
/// both views' normals. That of two normal variables is 2 ln 2 times the variance of each, which is
/// twice that of one normal. A median leaves creases and other surfaces out.
fn turned(observations: &[Observation]) -> f64 {
    let step = observations.len().div_ceil(QUANTILE_SAMPLES).max(1);
    let mut squares: Vec<f32> = observations.iter().step_by(step).map(|o| o.turned).collect();
    let middle = squares.len() / 2;
    if squares.is_empty() {
        return 0.0;
    }
    let (_, median, _) = squares.select_nth_unstable_by(middle, f32::total_cmp);
    f64::from(*median) / (4.0 * std::f64::consts::LN_2)
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

    /// The slopes of an observation over the unknowns of the cameras that are free, and their
    /// number.
    pub fn camera_terms(&self, o: &Observation, cameras: &Cameras) -> ([(usize, f64); 14], usize) {
        let (mut terms, mut count) = ([(0, 0.0); 14], 0);
        for (side, view) in [self.a, self.b].into_iter().enumerate() {
            let Some(nodes) = cameras.nodes(view, o.cells[side]) else { continue };
            let slope = f64::from(o.slopes.change[side]);
            let depth = f64::from(o.slopes.depths[side]);
            let offsets = nodes.map(|(node, share)| (node, share * slope * depth));
            let scale = cameras.free_scale(&nodes).map(|unknown| (unknown, slope));
            let focal = cameras.free_focal(&nodes).into_iter().flatten();
            let focal = focal.zip(o.slopes.focal[side].map(f64::from));
            let all = offsets.into_iter().chain(scale).chain(focal).zip(&mut terms[count..]);
            count += all.map(|(from, to)| *to = from).count();
        }
        (terms, count)
    }
}
