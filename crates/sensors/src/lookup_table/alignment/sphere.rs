//! The centre of a scanned sphere of known radius, robust against outliers.

use super::SphereScan;
use super::solve::{Surface, biweight, spread};
use crate::SensorError;
use nalgebra::{Matrix3, Matrix4, Vector4};
use transect_device::{Point3, Vector3};

/// Spheres tried through four points: with a third of the points outliers, one in five is clean.
const TRIALS: usize = 300;
const ROUNDS: usize = 30;

/// The centre in the sensor frame.
pub(super) fn center(scan: &SphereScan<'_>) -> Result<Point3, SensorError> {
    let points = scan.points_in_sensor;
    let wanted = "points of several sweeps on each sphere";
    let undetermined = || SensorError::Undetermined { wanted };
    let mut best: Option<(f64, Point3)> = None;
    let mut draw = Draw(1);
    for _ in 0..TRIALS {
        let four = [(); 4].map(|()| draw.one_of(points).copied());
        let [Some(a), Some(b), Some(c), Some(d)] = four else { return Err(undetermined()) };
        let Some(center) = center_of_four([a, b, c, d]) else { continue };
        let misfit = spread(&distances(points, &center, scan.radius));
        if best.is_none_or(|(least, _)| misfit < least) {
            best = Some((misfit, center));
        }
    }
    let (_, start) = best.ok_or_else(undetermined)?;
    Ok(refine(scan, start))
}

/// Gauss–Newton with the radius known; a singular step leaves the centre unchanged.
fn refine(scan: &SphereScan<'_>, mut center: Point3) -> Point3 {
    for _ in 0..ROUNDS {
        let residuals = distances(scan.points_in_sensor, &center, scan.radius);
        let scale = spread(&residuals).max(scan.radius * 1e-12);
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (p, r) in scan.points_in_sensor.iter().zip(&residuals) {
            let Some(outwards) = (p - center).try_normalize(0.0) else { continue };
            let weight = biweight(r / scale);
            normal += weight * outwards * outwards.transpose();
            right += weight * r * outwards;
        }
        let Some(step) = normal.cholesky().map(|c| c.solve(&right)) else { return center };
        center += step;
        if step.norm() < 1e-13 * scan.radius {
            break;
        }
    }
    center
}

fn distances(points: &[Point3], center: &Point3, radius: f64) -> Vec<f64> {
    let sphere = Surface::sphere(points, *center, radius);
    points.iter().map(|p| sphere.distance(p)).collect()
}

/// The sphere through four points: |p|² = 2 c · p + k.
fn center_of_four(points: [Point3; 4]) -> Option<Point3> {
    let [origin, ..] = points;
    // About one of them, for figures' sake.
    let row = |p: Point3| (p - origin).push(1.0).transpose();
    let system = Matrix4::from_rows(&points.map(row));
    let squares = Vector4::from_row_slice(&points.map(|p| (p - origin).norm_squared()));
    let solved = system.lu().solve(&squares)?;
    let center = origin + 0.5 * solved.xyz();
    center.coords.iter().all(|c| c.is_finite()).then_some(center)
}

/// A fixed sequence of picks (Knuth's MMIX generator): same points, same centre.
struct Draw(u64);

impl Draw {
    fn one_of<'a>(&mut self, points: &'a [Point3]) -> Option<&'a Point3> {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        points.get(((self.0 >> 33) as usize).checked_rem(points.len())?)
    }
}
