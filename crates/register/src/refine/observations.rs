//! The places where pieces of surface of one view lie over those of another.
//!
//! A piece is a patch of a cell, or the facet of a pixel where a cell has no patch.

use super::camera::Cameras;
use crate::coarse::{Cell, CoarseView, FacetMeeting, PatchMeeting};
use crate::scrambled::scrambled;
use crate::tuning::{ALIKE_DEGREES, FACETS, GATE};
use nalgebra::Vector6;
use transect_device::{Isometry3, Point3, Vector3};

/// The pieces of surface that observations compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pieces {
    Patches,
    /// Single pixels where there is no patch.
    Facets,
}

/// A patch or a facet that is looked up in another view.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    pub cell: usize,
    pub in_sensor: Point3,
    pub normal: Vector3,
    pub sigma: f64,
}

/// The patches of a view, in an order in which every beginning is spread over the image.
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

/// The facets of a view, in an order in which every beginning holds all their directions.
pub fn facet_samples(view: &CoarseView) -> Vec<Sample> {
    let facets = view.facets().samples(FACETS).into_iter();
    let sample = |(cell, in_sensor, normal, sigma)| Sample { cell, in_sensor, normal, sigma };
    facets.map(sample).collect()
}

/// A sample of view `a` over a patch or facet of view `b`.
#[derive(Debug, Clone, Copy)]
pub struct Observation {
    /// The cells of `a` and of `b`.
    pub cells: [usize; 2],
    /// Change of the distance with a motion of `a`: translation, then rotation about the origin.
    pub gradient: Vector6<f64>,
    /// Distance of the sample from the patch along the patch's normal, and from a facet along the
    /// mean of both normals.
    pub distance: f64,
    /// Change of the distance with the errors of the cameras; 0 where there is no depth camera.
    pub slopes: CameraSlopes,
    /// Variance of the distance from the noise of both patches.
    pub variance: f64,
    /// Its weight beside the other observations of the same surface: see [`Scene::share`].
    pub share: f64,
    /// Variance of the normal about each axis across it, in rad².
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

/// Views and their samples.
pub struct Scene<'a> {
    pub views: Vec<&'a CoarseView>,
    /// Of the patches of each view.
    pub samples: Vec<Vec<Sample>>,
    /// Of its facets.
    pub facets: Vec<Vec<Sample>>,
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
    /// The first samples of a view, without the error of its camera, by their place in the image:
    /// neighbours meet neighbours, which are still in the processor's cache.
    pub fn first_samples(
        &self,
        view: usize,
        of: Pieces,
        most: usize,
        cameras: &Cameras,
    ) -> Vec<Sample> {
        let corrected = |sample: &Sample| {
            let nodes = cameras.nodes(view, sample.cell);
            let point = sample.in_sensor;
            Sample { in_sensor: nodes.map_or(point, |n| cameras.corrected(&n, &point)), ..*sample }
        };
        let samples = match of {
            Pieces::Patches => &self.samples,
            Pieces::Facets => &self.facets,
        };
        let samples = samples.get(view).into_iter().flatten();
        let mut first: Vec<Sample> = samples.take(most).map(corrected).collect();
        first.sort_unstable_by_key(|sample| sample.cell);
        first
    }

    /// What samples of view `a` tell in view `b`.
    pub fn observe(
        &self,
        samples: &[Sample],
        (a, b): (usize, usize),
        of: Pieces,
        State { poses, cameras }: State<'_>,
        reach: Reach,
    ) -> Vec<Observation> {
        let Some(view) = self.views.get(b) else { return Vec::new() };
        let (Some(world_from_a), Some(world_from_b)) = (poses.get(a), poses.get(b)) else {
            return Vec::new();
        };
        let b_from_a = world_from_b.inverse() * world_from_a;
        let lookup = Lookup { scene: self, view, b, of, cameras, reach, b_from_a, world_from_b };
        let placed: Vec<Placed<'_>> = samples.iter().filter_map(|s| lookup.place(s)).collect();
        // Cells lie far apart in memory. A pass that only copies them waits for several at once.
        let copied = |placed: &Placed<'_>| view.cell(placed.cell).filter(|_| of == Pieces::Patches);
        let cells: Vec<_> = placed.iter().map(copied).collect();
        placed.iter().zip(cells).filter_map(|(placed, copy)| lookup.observe(placed, copy)).collect()
    }
}

/// Looks samples of view `a` up in view `b`.
struct Lookup<'a> {
    scene: &'a Scene<'a>,
    view: &'a CoarseView,
    b: usize,
    of: Pieces,
    cameras: &'a Cameras,
    reach: Reach,
    b_from_a: Isometry3,
    world_from_b: &'a Isometry3,
}

/// A sample of view `a` in the sensor frame of view `b`, and the cell of `b` that its ray passes.
struct Placed<'a> {
    sample: &'a Sample,
    in_b: Point3,
    cell: usize,
}

/// The piece of surface under a sample.
struct Met {
    distance: f64,
    /// The direction of that distance, in the sensor frame of `b`.
    normal: Vector3,
    sigma: f64,
    /// Variance of that direction about each axis across it, in rad².
    turned: f64,
}

impl Lookup<'_> {
    fn place<'s>(&self, sample: &'s Sample) -> Option<Placed<'s>> {
        let in_b = self.b_from_a * sample.in_sensor;
        // Errors of depths move a point along its ray, so the point stays in its cell.
        let cell = self.view.cell_of(&self.cameras.projected(self.b, &in_b))?;
        Some(Placed { sample, in_b, cell })
    }

    fn observe(&self, placed: &Placed<'_>, copy: Option<Cell>) -> Option<Observation> {
        let Placed { sample, in_b, cell } = placed;
        let met = self.met(placed, copy)?;
        let moved = self.reach.translation + self.reach.rotation * sample.in_sensor.coords.norm();
        let variance = sample.sigma.powi(2) + met.sigma.powi(2);
        let beyond = moved.powi(2).max(self.reach.unexplained);
        if met.distance.abs() > GATE * (beyond + variance).sqrt() {
            return None;
        }
        let slopes = (!self.cameras.list.is_empty())
            .then(|| CameraSlopes::new(placed, &met.normal, &self.b_from_a));
        let normal = self.world_from_b.rotation * met.normal;
        let arm = self.world_from_b * in_b - self.scene.origin;
        let turn = arm.cross(&normal);
        Some(Observation {
            cells: [sample.cell, *cell],
            gradient: Vector6::new(normal.x, normal.y, normal.z, turn.x, turn.y, turn.z),
            distance: met.distance,
            slopes: slopes.unwrap_or_default(),
            variance,
            share: 1.0,
            turned: met.turned as f32,
            arm: arm.map(|c| c as f32).into(),
        })
    }

    /// The patch or facet under a sample whose normal is alike.
    fn met(&self, placed: &Placed<'_>, copy: Option<Cell>) -> Option<Met> {
        let Placed { sample, in_b, cell } = placed;
        let (nodes, projected) =
            (self.cameras.nodes(self.b, *cell), self.cameras.projected(self.b, in_b));
        let measured = nodes.map_or(projected, |n| self.cameras.measured(&n, &projected));
        let own = self.b_from_a.rotation * sample.normal;
        match self.of {
            Pieces::Patches => {
                let met = self.view.meeting_with(&copy?, *cell, &measured)?;
                let PatchMeeting { distance, normal, sigma, .. } = met;
                let turned = (own - normal).norm_squared() / OF_DIFFERENCE;
                let alike = own.dot(&normal) >= ALIKE_DEGREES.to_radians().cos();
                alike.then_some(Met { distance, normal, sigma, turned })
            }
            Pieces::Facets => {
                let met = self.view.facets().meeting(*cell, &measured, &own)?;
                let FacetMeeting { distance, normal, sigma, spacing } = met;
                // The mean of two normals has half the variance of one.
                let turned = 0.5 * OF_SLOPE * (self.view.sigma() / spacing).powi(2);
                Some(Met { distance, normal, sigma, turned })
            }
        }
    }
}

/// The median square of the difference of two normals, over the variance of each about each of two
/// axes. Theory: 2 ln 2 of the variance of the difference, which is twice as large.
const OF_DIFFERENCE: f64 = 4.0 * std::f64::consts::LN_2;

/// Square of the distance between samples, times the variance of a slope over that of the samples,
/// for a plane through three rows of three. Theory.
const OF_SLOPE: f64 = 1.0 / 6.0;
