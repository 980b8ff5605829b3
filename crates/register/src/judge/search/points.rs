//! Surfaces as points with normals.

use super::super::pair::Placing;
use crate::coarse::{CoarseView, Patch};
use crate::scrambled::scrambled;
use std::collections::HashSet;
use transect_device::{Isometry3, Point3, Vector3, median};

/// Distance of the points over the median distance from their middle. No unit. Chosen by hand: some
/// 600 points of a view are left. Doubled, least squares begin too far off.
const SPACING: f64 = 0.1;

/// A point of a surface, with its normal.
#[derive(Debug, Clone, Copy)]
pub struct Oriented {
    pub point: Point3,
    pub normal: Vector3,
}

impl Oriented {
    pub fn moved(&self, pose: &Isometry3) -> Self {
        Self { point: pose * self.point, normal: pose.rotation * self.normal }
    }

    /// The cube of a grid that it lies in, and which of six ways it faces. Two sides of a plate
    /// share a cube.
    pub fn cube(&self, spacing: f64) -> [i64; 4] {
        let at = self.point.coords.map(|c| (c / spacing).floor() as i64);
        let axis = self.normal.iamax();
        let way = 2 * axis as i64 + i64::from(self.normal[axis] < 0.0);
        [at.x, at.y, at.z, way]
    }
}

/// The patches of a view in the world.
pub fn of_view(view: &CoarseView, placing: Placing) -> Vec<Oriented> {
    let oriented = |(_, patch): (usize, Patch)| Oriented {
        point: placing.to_world(&patch.point()),
        normal: placing.world_from_sensor.rotation * patch.steady_normal(),
    };
    view.patches().map(oriented).collect()
}

/// How far points are thinned; `None` without an extent.
pub fn spacing(points: &[Oriented]) -> Option<f64> {
    let sum: Vector3 = points.iter().map(|p| p.point.coords).sum();
    let middle = sum / points.len().max(1) as f64;
    let spread = median(points.iter().map(|p| (p.point.coords - middle).norm()))?;
    (spread > 0.0).then_some(SPACING * spread)
}

/// The first point in each cube, in an order in which every beginning is spread over all.
pub fn thinned(points: &[Oriented], spacing: f64) -> Vec<Oriented> {
    let mut seen = HashSet::new();
    let first = points.iter().filter(|p| seen.insert(p.cube(spacing))).enumerate();
    let mut first: Vec<(u32, Oriented)> = first.map(|(k, p)| (scrambled(k as u32), *p)).collect();
    first.sort_unstable_by_key(|(order, _)| *order);
    first.into_iter().map(|(_, p)| p).collect()
}
