//! A scanned sphere, robust against outliers: its centre with the radius known, and its radius with
//! nothing known.
//!
//! A wrong radius shifts the centre of a half sphere and hardly shows in what the points are off by
//! afterwards. So the radius is measured, too, and must be the stated one.

use super::SphereScan;
use super::solve::{BIWEIGHT_CUT, biweight, spread};
use crate::SensorError;
use nalgebra::{Matrix4, Vector4};
use transect_device::Point3;

/// Spheres tried through four points: with a third of the points outliers, one in five is clean.
const TRIALS: usize = 300;
const ROUNDS: usize = 30;

/// How many times the points must lie closer to a sphere of another radius for the stated one to be
/// wrong. No unit. Chosen by hand: a scanner's own errors leave a sphere of any radius as far off.
/// Doubled, radii that err by twice as much pass.
const CLEARLY_CLOSER: f64 = 2.0;

/// A sphere in the sensor frame.
#[derive(Debug, Clone, Copy)]
struct Sphere {
    center: Point3,
    radius: f64,
}

/// A scanned sphere.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scanned {
    /// Its centre in the sensor frame, if it has the stated radius.
    pub center: Point3,
    /// Standard deviation of the points about a sphere of any radius.
    pub noise: f64,
}

/// The sphere that points were scanned on.
///
/// `number` is that of the sphere in messages, from 1 on.
pub(super) fn scanned(scan: &SphereScan<'_>, number: usize) -> Result<Scanned, SensorError> {
    let points = scan.points_in_sensor;
    let (stated, _) = fit(points, start(points, Some(scan.radius))?, false);
    let (free, sigma) = fit(points, start(points, None)?, true);
    let [of_stated, noise] = [stated, free].map(|sphere| spread(&sphere.distances(points)));
    let is_other = (free.radius - scan.radius).abs() > BIWEIGHT_CUT * sigma * noise;
    if is_other && of_stated > CLEARLY_CLOSER * noise.max(super::ROUNDING * scan.radius) {
        let problem = format!(
            "the points on sphere {number} lie on one of radius {:.6}, the stated radius is {}",
            free.radius, scan.radius
        );
        return Err(SensorError::Contradicted { problem });
    }
    Ok(Scanned { center: stated.center, noise: noise.max(super::ROUNDING * scan.radius) })
}

/// The best of many spheres through four points: the points lie closest to it, if it has the given
/// radius.
fn start(points: &[Point3], radius: Option<f64>) -> Result<Sphere, SensorError> {
    let wanted = "points of several sweeps on each sphere";
    let undetermined = || SensorError::Undetermined { wanted };
    let mut best: Option<(f64, Sphere)> = None;
    let mut draw = Draw(1);
    for _ in 0..TRIALS {
        let four = [(); 4].map(|()| draw.one_of(points).copied());
        let [Some(a), Some(b), Some(c), Some(d)] = four else { return Err(undetermined()) };
        let Some(found) = Sphere::through([a, b, c, d]) else { continue };
        let sphere = Sphere { radius: radius.unwrap_or(found.radius), ..found };
        let misfit = spread(&sphere.distances(points));
        if best.is_none_or(|(least, _)| misfit < least) {
            best = Some((misfit, sphere));
        }
    }
    best.map(|(_, sphere)| sphere).ok_or_else(undetermined)
}

/// Gauss–Newton from a start on, with the radius `free` or known. Also the standard deviation of
/// the radius, if points had one of 1; a singular step leaves the sphere unchanged.
fn fit(points: &[Point3], mut sphere: Sphere, free: bool) -> (Sphere, f64) {
    let mut sigma = f64::INFINITY;
    for _ in 0..ROUNDS {
        let residuals = sphere.distances(points);
        let scale = spread(&residuals).max(sphere.radius * 1e-12);
        let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
        for (p, r) in points.iter().zip(&residuals) {
            let Some(outwards) = (p - sphere.center).try_normalize(0.0) else { continue };
            let slopes = outwards.push(if free { 1.0 } else { 0.0 });
            let weight = biweight(r / scale);
            normal += weight * slopes * slopes.transpose();
            right += weight * *r * slopes;
        }
        if !free {
            normal[(3, 3)] = 1.0;
        }
        let Some(solved) = normal.cholesky() else { break };
        let step = solved.solve(&right);
        sphere.center += step.xyz();
        sphere.radius += step.w;
        sigma = solved.inverse()[(3, 3)].sqrt();
        if step.norm() < 1e-13 * sphere.radius {
            break;
        }
    }
    (sphere, sigma)
}

impl Sphere {
    /// The sphere through four points: |p|² = 2 c · p + k.
    fn through(points: [Point3; 4]) -> Option<Self> {
        let [origin, ..] = points;
        // About one of them, for figures' sake.
        let row = |p: Point3| (p - origin).push(1.0).transpose();
        let system = Matrix4::from_rows(&points.map(row));
        let squares = Vector4::from_row_slice(&points.map(|p| (p - origin).norm_squared()));
        let from_origin = 0.5 * system.lu().solve(&squares)?.xyz();
        let radius = from_origin.norm();
        radius.is_finite().then_some(Self { center: origin + from_origin, radius })
    }

    /// Signed distances of points from it, positive outside.
    fn distances(&self, points: &[Point3]) -> Vec<f64> {
        points.iter().map(|p| (p - self.center).norm() - self.radius).collect()
    }
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
