//! Where the scanner is, from scans of the machine table and of spheres (dissertation, 4.7.1).
//!
//! The result is the pose `world_from_sensor` of robust least squares. It lays the points scanned
//! on the table onto the table, and those scanned on spheres of known radius onto the spheres.
//!
//! The linear axis of the machine is a direction known in both frames: the pose may only turn about
//! it, by the tilt. The table then determines the tilt, one sphere the place
//! ([`Turning::AboutAxis`]).
//! Without that knowledge two or more spheres are needed, out of line with the table's normal
//! ([`Turning::Free`]).
//!
//! 1. Each sphere's centre in the sensor frame: the best of many four-point spheres, then robust
//!    least squares with the radius known. The radius that its points have by themselves, and the
//!    distances between the centres, must be those stated.
//! 2. The turn about the known direction (the axis, or the line of two centres) which lays the
//!    table best, by trial in 2.5° and then 0.1° steps. The spheres' centres give the shift.
//! 3. All points together: Gauss–Newton on the signed distances from table and spheres, with
//!    Tukey's biweight at the residuals' own median spread.
//! 4. Most points of each surface must lie on it.
//!
//! Under-determined poses show in the smallest eigenvalue of step 3's normal matrix, rotations
//! weighed by the points' own extent. Only places come out: what the table or the sphere's holder
//! does under load, and errors of the tables the points came through, stay in the residual.

mod solve;
mod sphere;

use super::filter::median;
use crate::SensorError;
use nalgebra::{Translation3, Unit, UnitQuaternion};
use solve::{BIWEIGHT_CUT, Surface};
use std::f64::consts::TAU;
use transect_device::{Isometry3, Point3, Vector3};

/// Relative rounding error of centres. Chosen by hand, far above rounding and below any scan.
/// Doubled, nothing changes.
const ROUNDING: f64 = 1e-9;

/// A scan of the machine table.
#[derive(Debug, Clone, Copy)]
pub struct PlaneScan<'a> {
    /// Points scanned on the table, in the sensor frame.
    pub points_in_sensor: &'a [Point3],
    /// The table's normal in the world, of any length but 0.
    pub normal_in_world: Vector3,
    /// A point of the table in the world.
    pub point_in_world: Point3,
}

/// A scan of a sphere.
#[derive(Debug, Clone, Copy)]
pub struct SphereScan<'a> {
    /// Points scanned on the sphere, in the sensor frame.
    pub points_in_sensor: &'a [Point3],
    /// The sphere's centre in the world.
    pub center_in_world: Point3,
    /// The sphere's radius, a length.
    pub radius: f64,
}

/// The known part of the rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Turning {
    /// One direction is known in both frames, as the linear axis is: one sphere is enough.
    AboutAxis {
        /// The direction in the sensor frame, of any length but 0.
        in_sensor: Vector3,
        /// The same direction in the world.
        in_world: Vector3,
    },
    /// The rotation is unknown: at least two spheres are needed.
    Free,
}

/// An alignment and how well it fits.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Alignment {
    /// The pose: world coordinates from sensor coordinates.
    pub world_from_sensor: Isometry3,
    /// Root mean square distance of the points used from their surface, a length. The pose's
    /// degrees of freedom are taken off. If all is well, it is about the noise across the surfaces.
    pub residual_rms: f64,
    /// The noise of the points on the spheres, each taken by itself and of any radius: the largest.
    /// A residual far above it shows that the stated places contradict each other, or that the
    /// scanner errs.
    pub sphere_noise: f64,
    /// How many points were used.
    pub used: usize,
    /// How many were outliers.
    pub rejected: usize,
}

/// The pose that lays scanned points onto the table and the spheres.
///
/// # Errors
/// [`SensorError::BadParameter`] naming `table`, `spheres`, `radius`, `normal` or `axis` for too
/// few points, no sphere, or values that are not finite or zero; [`SensorError::Undetermined`] if
/// the points leave a motion free; [`SensorError::Contradicted`] if they do not lie on the table or
/// a sphere as stated.
pub fn align(
    table: &PlaneScan<'_>,
    spheres: &[SphereScan<'_>],
    turning: Turning,
) -> Result<Alignment, SensorError> {
    let surfaces = surfaces(table, spheres)?;
    let scanned = spheres.iter().zip(1..).map(|(scan, number)| sphere::scanned(scan, number));
    let scanned: Vec<sphere::Scanned> = scanned.collect::<Result<_, _>>()?;
    let centers: Vec<Point3> = scanned.iter().map(|sphere| sphere.center).collect();
    let noises: Vec<f64> = scanned.iter().map(|sphere| sphere.noise).collect();
    check_distances(spheres, &centers, &noises)?;
    let (in_sensor, in_world) = known_direction(turning, spheres, &centers)?;
    let start = start(table, &surfaces, spheres, &centers, &(in_sensor, in_world));
    let axis = match turning {
        Turning::AboutAxis { .. } => Some(in_world),
        Turning::Free => None,
    };
    let sphere_noise = noises.into_iter().fold(0.0, f64::max);
    Ok(Alignment { sphere_noise, ..solve::refine(&surfaces, start, axis)? })
}

/// Checks the distances between the spheres' centres, which do not depend on the pose. They are
/// known better than single points are.
fn check_distances(
    spheres: &[SphereScan<'_>],
    centers: &[Point3],
    noises: &[f64],
) -> Result<(), SensorError> {
    for i in 0..spheres.len() {
        for j in 0..i {
            let stated = (spheres[i].center_in_world - spheres[j].center_in_world).norm();
            let scanned = (centers[i] - centers[j]).norm();
            let noise = BIWEIGHT_CUT * (noises[i] + noises[j]);
            if (stated - scanned).abs() > noise + ROUNDING * scanned {
                let problem = format!(
                    "the scanned centres of spheres {} and {} are {scanned:.6} apart, the stated \
                     ones {stated:.6}",
                    j + 1,
                    i + 1
                );
                return Err(SensorError::Contradicted { problem });
            }
        }
    }
    Ok(())
}

fn surfaces<'a>(
    table: &PlaneScan<'a>,
    spheres: &[SphereScan<'a>],
) -> Result<Vec<Surface<'a>>, SensorError> {
    check_points("table", table.points_in_sensor, 3)?;
    let normal = direction("normal", &table.normal_in_world)?;
    check_point("table", &table.point_in_world)?;
    let offset = normal.dot(&table.point_in_world.coords);
    let mut all = vec![Surface::plane(table.points_in_sensor, normal, offset)];
    if spheres.is_empty() {
        return Err(bad("spheres", 0.0, "at least one sphere"));
    }
    for s in spheres {
        check_points("spheres", s.points_in_sensor, 4)?;
        check_point("spheres", &s.center_in_world)?;
        crate::error::require("radius", s.radius, s.radius > 0.0, "a positive length")?;
        all.push(Surface::sphere(s.points_in_sensor, s.center_in_world, s.radius));
    }
    Ok(all)
}

fn bad(key: &'static str, value: f64, wanted: &'static str) -> SensorError {
    SensorError::BadParameter { key, value, wanted }
}

fn check_points(key: &'static str, points: &[Point3], least: usize) -> Result<(), SensorError> {
    crate::error::require(key, points.len() as f64, points.len() >= least, "more scanned points")?;
    points.iter().try_for_each(|p| check_point(key, p))
}

fn check_point(key: &'static str, p: &Point3) -> Result<(), SensorError> {
    crate::error::require(key, p.coords.sum(), true, "finite points").map(|_| ())
}

fn direction(key: &'static str, v: &Vector3) -> Result<Vector3, SensorError> {
    let length = crate::error::require(key, v.norm(), v.norm() > 0.0, "a direction")?;
    Ok(v / length)
}

/// A direction known in both frames: the axis, or from the first sphere to the one farthest off.
fn known_direction(
    turning: Turning,
    spheres: &[SphereScan<'_>],
    centers: &[Point3],
) -> Result<(Vector3, Vector3), SensorError> {
    if let Turning::AboutAxis { in_sensor, in_world } = turning {
        return Ok((direction("axis", &in_sensor)?, direction("axis", &in_world)?));
    }
    let pairs = spheres.iter().map(|s| s.center_in_world).zip(centers.iter().copied());
    let undetermined = SensorError::Undetermined { wanted: "a second sphere, or a known axis" };
    let (first_world, first_sensor) = pairs.clone().next().ok_or(undetermined.clone())?;
    let apart = |p: &(Point3, Point3)| (p.0 - first_world).norm();
    let far = pairs.max_by(|a, b| apart(a).total_cmp(&apart(b))).ok_or(undetermined.clone())?;
    let in_world = (far.0 - first_world).try_normalize(0.0).ok_or(undetermined.clone())?;
    let in_sensor = (far.1 - first_sensor).try_normalize(0.0).ok_or(undetermined)?;
    Ok((in_sensor, in_world))
}

/// Step 2: the best turn about the known direction, with the shift the spheres give.
fn start(
    table: &PlaneScan<'_>,
    surfaces: &[Surface<'_>],
    spheres: &[SphereScan<'_>],
    centers: &[Point3],
    (in_sensor, in_world): &(Vector3, Vector3),
) -> Isometry3 {
    // Opposite directions: any half-turn does, since every turn about the axis is tried.
    let aligned = UnitQuaternion::rotation_between(in_sensor, in_world).unwrap_or_else(|| {
        let across = if in_world.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        UnitQuaternion::new(in_world.cross(&across).normalize() * (0.5 * TAU))
    });
    let axis = Unit::new_unchecked(*in_world);
    let pose = |turn: f64| {
        let rotation = UnitQuaternion::from_axis_angle(&axis, turn) * aligned;
        let shift = |(s, c): (&SphereScan<'_>, &Point3)| s.center_in_world - rotation * c;
        let sum: Vector3 = spheres.iter().zip(centers).map(shift).sum();
        Isometry3::from_parts(Translation3::from(sum / spheres.len() as f64), rotation)
    };
    // Some hundred points give a good start for the turn.
    let stride = table.points_in_sensor.len().div_ceil(400);
    let misfit = |turn: f64| {
        let pose = pose(turn);
        let few = table.points_in_sensor.iter().step_by(stride);
        let distance = |p: &Point3| surfaces.first().map_or(0.0, |t| t.distance(&(pose * p)).abs());
        median(few.map(distance).collect())
    };
    let best = |turns: Vec<f64>| {
        let tried = turns.into_iter().map(|t| (misfit(t), t));
        tried.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |t| t.1)
    };
    let coarse = best((0..144).map(|k| f64::from(k) * TAU / 144.0).collect());
    pose(best((-30..=30).map(|k| coarse + f64::from(k) * TAU / 3600.0).collect()))
}
