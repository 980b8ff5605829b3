//! The benchmark's own view: a room with bumpy walls and furniture, seen by an imaging radar.
//!
//! The room is a distance field; ranges are found by stepping along each ray by the distance to the
//! nearest surface. Surfaces are smooth, flat, round, saddle-shaped and behind each other, and the
//! planes are oblique to all of them, so that no pixel row or column is special.

use rayon::prelude::*;
use std::sync::Arc;
use transect_device::{ImageSize, Isometry3, RangeImage, Vector3, View};
use transect_geometry::{PlaneFamily, StraightGuide};
use transect_sensors::{AngularScan, ImagingRadar};

/// Share of the pixels that are missing.
const MISSING: f64 = 0.02;

/// Size of the room, in metres.
const ROOM: [f64; 3] = [8.0, 6.0, 3.0];
/// Where the sensor stands.
const SENSOR: [f64; 3] = [1.1, 0.9, 1.4];
/// Width and height of the field of view, in degrees.
const FIELD: f64 = 80.0;

/// The field's view of the room.
pub fn view(size: usize) -> Option<View> {
    let step = FIELD / size as f64;
    let theta = AngularScan::from_degrees(40.0 - 0.5 * FIELD, step);
    let phi = AngularScan::from_degrees(-0.5 * FIELD, step);
    let shape = ImageSize { rows: size, cols: size };
    let radar = ImagingRadar::new(shape, theta, phi).ok()?;
    let row = |i: usize| {
        let (sin_phi, cos_phi) = phi.angle(i).sin_cos();
        let ray = move |j: usize| {
            let (sin, cos) = theta.angle(j).sin_cos();
            range(Vector3::new(cos_phi * cos, cos_phi * sin, sin_phi))
        };
        (0..size).map(ray).collect::<Vec<f32>>()
    };
    let mut values: Vec<f32> = (0..size).into_par_iter().flat_map_iter(row).collect();
    punch(&mut values);
    let image = RangeImage::from_values(shape, values).ok()?;
    let pose = Isometry3::translation(SENSOR[0], SENSOR[1], SENSOR[2]);
    View::new("bench", image, Arc::new(radar), pose, Some(0.0)).ok()
}

/// A family of oblique planes of which a number cross what the view sees.
pub fn planes(view: &View, count: usize) -> Option<PlaneFamily> {
    let normal = Vector3::new(0.35, 0.2, 0.91).normalize();
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let ImageSize { rows, cols } = view.image().size();
    for (row, col) in (0..rows).flat_map(|row| (0..cols).map(move |col| (row, col))) {
        if let Some(p) = view.point_in_sensor(transect_device::Pixel::new(row, col)) {
            let height = normal.dot(&(view.world_from_sensor() * p).coords);
            (low, high) = (low.min(height), high.max(height));
        }
    }
    let interval = (high - low) / count as f64;
    PlaneFamily::new(StraightGuide::along(normal).ok()?, low + 0.5 * interval, interval).ok()
}

/// The range along a ray from the sensor.
fn range(direction: Vector3) -> f32 {
    let mut range = 0.05;
    for _ in 0..200 {
        let p = Vector3::new(SENSOR[0], SENSOR[1], SENSOR[2]) + direction * range;
        let distance = distance(&p);
        range += 0.9 * distance;
        if distance < 1e-6 * range {
            break;
        }
    }
    range as f32
}

/// Distance to the nearest surface; a little short of it near the bumps.
fn distance(p: &Vector3) -> f64 {
    let bumps = 0.02 * (2.1 * p.x).sin() * (2.7 * p.y).sin() * (3.3 * p.z).sin();
    let walls = (0..3).map(|k| p[k].min(ROOM[k] - p[k])).fold(f64::INFINITY, f64::min) - bumps;
    let ball = |x, y, z, r: f64| (p - Vector3::new(x, y, z)).norm() - r;
    let balls =
        ball(4.2, 2.1, 1.3, 0.45).min(ball(3.2, 3.9, 0.5, 0.5)).min(ball(5.9, 3.6, 2.2, 0.3));
    let pillar = ((p.x - 5.2).hypot(p.y - 4.6) - 0.25).max(0.0);
    let ring = Vector3::new(p.x - 6.1, p.y - 2.2, p.z - 1.1);
    let ring = (ring.y.hypot(ring.z) - 0.5).hypot(ring.x) - 0.15;
    let table = cuboid(p, [4.6, 3.2, 0.72], [0.9, 0.5, 0.04]);
    let cabinet = cuboid(p, [2.4, 5.2, 0.9], [0.5, 0.35, 0.9]);
    walls.min(balls).min(pillar).min(ring).min(table).min(cabinet)
}

fn cuboid(p: &Vector3, centre: [f64; 3], half: [f64; 3]) -> f64 {
    let d = Vector3::from_fn(|k, _| ((p[k] - centre[k]).abs() - half[k]).max(0.0));
    d.norm()
}

/// Makes single pixels missing, the same ones every time.
fn punch(values: &mut [f32]) {
    let mut state = 88_172_645_463_325_252_u64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as usize % below
    };
    for _ in 0..(MISSING * values.len() as f64) as usize {
        let pixel = random(values.len());
        values[pixel] = f32::NAN;
    }
}
