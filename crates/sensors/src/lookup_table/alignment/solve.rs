//! Step 3 of the alignment: all points at once, by weighted Gauss–Newton.

use super::super::filter::median;
use super::Alignment;
use crate::SensorError;
use nalgebra::{DMatrix, DVector, Matrix6, SymmetricEigen, UnitQuaternion, Vector6};
use transect_device::{Isometry3, Point3, Vector3};

const ROUNDS: usize = 50;

/// Residuals beyond this many spreads get weight 0. Theory: 95 % efficiency for Gaussian noise
/// (Tukey's biweight). Doubled, outliers of up to nine spreads keep some weight.
pub(super) const BIWEIGHT_CUT: f64 = 4.685;

/// Weakest motion against the strongest, as eigenvalues: a thousandth of the certainty.
const WEAKEST: f64 = 1e-6;

/// Tukey's biweight of a residual in spreads: 1 at 0, 0 from the cut on.
pub(super) fn biweight(r: f64) -> f64 {
    let x = r / BIWEIGHT_CUT;
    if x.abs() < 1.0 { (1.0 - x * x) * (1.0 - x * x) } else { 0.0 }
}

/// Standard deviation of Gaussian residuals about 0, from the median of their sizes.
pub(super) fn spread(residuals: &[f64]) -> f64 {
    1.4826 * median(residuals.iter().map(|r| r.abs()).collect())
}

enum Shape {
    Plane { normal: Vector3, offset: f64 },
    Sphere { center: Point3, radius: f64 },
}

/// A surface at its place in the world, and the points scanned on it.
pub(super) struct Surface<'a> {
    points_in_sensor: &'a [Point3],
    shape: Shape,
}

impl<'a> Surface<'a> {
    pub(super) fn plane(points_in_sensor: &'a [Point3], normal: Vector3, offset: f64) -> Self {
        Self { points_in_sensor, shape: Shape::Plane { normal, offset } }
    }

    pub(super) fn sphere(points_in_sensor: &'a [Point3], center: Point3, radius: f64) -> Self {
        Self { points_in_sensor, shape: Shape::Sphere { center, radius } }
    }

    /// Signed distance of a point from the surface.
    pub(super) fn distance(&self, p: &Point3) -> f64 {
        match &self.shape {
            Shape::Plane { normal, offset } => normal.dot(&p.coords) - offset,
            Shape::Sphere { center, radius } => (p - center).norm() - radius,
        }
    }

    /// The distance's gradient, a unit vector (0 at a sphere's centre).
    fn gradient(&self, p: &Point3) -> Vector3 {
        match &self.shape {
            Shape::Plane { normal, .. } => *normal,
            Shape::Sphere { center, .. } => {
                (p - center).try_normalize(0.0).unwrap_or_else(Vector3::zeros)
            }
        }
    }
}

/// Middle and root mean square extent of all points: the pivot and the arm of rotations.
struct Cloud {
    middle_in_sensor: Point3,
    arm: f64,
}

impl Cloud {
    fn of(surfaces: &[Surface<'_>]) -> Self {
        let points = || surfaces.iter().flat_map(|s| s.points_in_sensor);
        let count = points().count() as f64;
        let sum: Vector3 = points().map(|p| p.coords).sum();
        let middle_in_sensor = Point3::from(sum / count);
        let squares: f64 = points().map(|p| (p - middle_in_sensor).norm_squared()).sum();
        Self { middle_in_sensor, arm: (squares / count).sqrt() }
    }

    /// Spread of residuals, at least the rounding of coordinates.
    fn scale(&self, residuals: &[f64]) -> f64 {
        let extent = self.arm + self.middle_in_sensor.coords.norm();
        spread(residuals).max(1e-12 * extent)
    }
}

/// The pose of least weighted squares from a start, turning about an axis only if one is given.
pub(super) fn refine(
    surfaces: &[Surface<'_>],
    start: Isometry3,
    axis_in_world: Option<Vector3>,
) -> Result<Alignment, SensorError> {
    let cloud = Cloud::of(surfaces);
    let free = motions(axis_in_world);
    let mut pose = start;
    for _ in 0..ROUNDS {
        let (normal, right) = normal_equations(surfaces, &pose, &cloud);
        let normal = free.transpose() * normal * &free;
        let right = free.transpose() * right;
        let solved = check_determined(&normal).and_then(|()| {
            let wanted = "scans that fit the table and the spheres";
            let solved = normal.cholesky().map(|c| c.solve(&right));
            solved.ok_or(SensorError::Undetermined { wanted })
        });
        // Outliers determine nothing: what is wrong with them comes first.
        let step = solved.or_else(|undetermined| {
            check_fit(surfaces, &pose, &cloud)?;
            Err(undetermined)
        })?;
        pose = moved(&pose, &(&free * &step), &cloud);
        if step.norm() < 1e-13 * cloud.arm {
            break;
        }
    }
    let alignment = report(surfaces, pose, free.ncols(), &cloud);
    check_fit(surfaces, &pose, &cloud)?;
    Ok(alignment)
}

/// Checks that most points of every surface lie on it. A wrong place or radius makes outliers of a
/// whole surface, and the others alone leave a small residual.
fn check_fit(surfaces: &[Surface<'_>], pose: &Isometry3, cloud: &Cloud) -> Result<(), SensorError> {
    let within = BIWEIGHT_CUT * cloud.scale(&residuals(surfaces, pose));
    for (number, surface) in surfaces.iter().enumerate() {
        let distances =
            surface.points_in_sensor.iter().map(|p| surface.distance(&(pose * p)).abs());
        let distance = median(distances.collect());
        if distance > within {
            let surface = match &surface.shape {
                Shape::Plane { .. } => "the table".to_owned(),
                Shape::Sphere { center: c, radius } => {
                    format!("sphere {number} (centre {}, {}, {}, radius {radius})", c.x, c.y, c.z)
                }
            };
            let problem = format!(
                "half of the points of {surface} lie {distance:.6} and more off it, where {within:.6} \
                 counts as noise"
            );
            return Err(SensorError::Contradicted { problem });
        }
    }
    Ok(())
}

/// Columns: the motions left free, as rotation (times the arm) over shift.
fn motions(axis_in_world: Option<Vector3>) -> DMatrix<f64> {
    let Some(axis) = axis_in_world else { return DMatrix::identity(6, 6) };
    let mut free = DMatrix::zeros(6, 4);
    free.view_mut((0, 0), (3, 1)).copy_from(&axis);
    free.view_mut((3, 1), (3, 3)).fill_with_identity();
    free
}

/// The equations of the small motion that takes residuals away.
fn normal_equations(
    surfaces: &[Surface<'_>],
    pose: &Isometry3,
    cloud: &Cloud,
) -> (DMatrix<f64>, DVector<f64>) {
    let scale = cloud.scale(&residuals(surfaces, pose));
    let pivot = pose * cloud.middle_in_sensor;
    let (mut normal, mut right) = (Matrix6::<f64>::zeros(), Vector6::<f64>::zeros());
    for surface in surfaces {
        for p in surface.points_in_sensor {
            let p = pose * p;
            let (r, gradient) = (surface.distance(&p), surface.gradient(&p));
            // A turn ω moves p by ω × (p − pivot), so the distance by ω · ((p − pivot) × gradient).
            let turn = (p - pivot).cross(&gradient) / cloud.arm;
            let j = Vector6::new(turn.x, turn.y, turn.z, gradient.x, gradient.y, gradient.z);
            let weight = biweight(r / scale);
            normal += weight * j * j.transpose();
            right -= weight * r * j;
        }
    }
    let normal = DMatrix::from_column_slice(6, 6, normal.as_slice());
    (normal, DVector::from_column_slice(right.as_slice()))
}

fn check_determined(normal: &DMatrix<f64>) -> Result<(), SensorError> {
    let strengths = SymmetricEigen::new(normal.clone()).eigenvalues;
    if strengths.min() > WEAKEST * strengths.max() {
        return Ok(());
    }
    let wanted = "a table that is not square to the axis, spheres seen over several sweeps, and \
                  without a known axis two spheres off the table's normal";
    Err(SensorError::Undetermined { wanted })
}

fn moved(pose: &Isometry3, step: &DVector<f64>, cloud: &Cloud) -> Isometry3 {
    let part = |from: usize| Vector3::from_iterator(step.iter().skip(from).take(3).copied());
    let pivot = pose * cloud.middle_in_sensor;
    let rotation = UnitQuaternion::new(part(0) / cloud.arm) * pose.rotation;
    let middle = pivot + part(3);
    let shift = middle - rotation * cloud.middle_in_sensor;
    Isometry3::from_parts(shift.into(), rotation)
}

fn residuals(surfaces: &[Surface<'_>], pose: &Isometry3) -> Vec<f64> {
    let of = |s: &Surface<'_>| {
        s.points_in_sensor.iter().map(|p| s.distance(&(pose * p))).collect::<Vec<_>>()
    };
    surfaces.iter().flat_map(of).collect()
}

fn report(surfaces: &[Surface<'_>], pose: Isometry3, freedoms: usize, cloud: &Cloud) -> Alignment {
    let all = residuals(surfaces, &pose);
    let cut = BIWEIGHT_CUT * cloud.scale(&all);
    let squares: Vec<f64> = all.iter().filter(|r| r.abs() <= cut).map(|r| r * r).collect();
    let degrees = squares.len().saturating_sub(freedoms).max(1);
    Alignment {
        world_from_sensor: pose,
        sphere_noise: 0.0,
        residual_rms: (squares.iter().sum::<f64>() / degrees as f64).sqrt(),
        used: squares.len(),
        rejected: all.len() - squares.len(),
    }
}
