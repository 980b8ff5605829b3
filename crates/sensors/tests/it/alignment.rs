//! Alignment of a lookup-table scanner by scanning the machine table and a sphere.

use crate::noise::Noise;
use transect_device::{Isometry3, Point3, Vector3};
use transect_sensors::lookup_table::alignment::{Alignment, PlaneScan, SphereScan, Turning, align};

const SIGMA: f64 = 0.03;
const RADIUS: f64 = 12.7;
const LINEAR: Turning = Turning::AboutAxis {
    in_sensor: Vector3::new(0.0, 1.0, 0.0),
    in_world: Vector3::new(0.0, 2.0, 0.0),
};

/// Looks down on the table with a tilt of 20°: the linear axis y stays y.
fn pose() -> Isometry3 {
    let turn = std::f64::consts::PI - 20.0_f64.to_radians();
    Isometry3::new(Vector3::new(310.0, -45.0, 170.0), Vector3::y() * turn)
}

/// Points in the sensor frame of points in the world, with noise; one in `outliers` is far off.
fn scan(points: Vec<Point3>, pose: &Isometry3, noise: &mut Noise, outliers: usize) -> Vec<Point3> {
    let shaken = |(k, p): (usize, Point3)| {
        let gross = if outliers > 0 && k % outliers == 0 { 8.0 } else { 0.0 };
        let mut shake = || (SIGMA + gross) * noise.gauss();
        pose.inverse() * (p + Vector3::new(shake(), shake(), shake()))
    };
    points.into_iter().enumerate().map(shaken).collect()
}

fn table(sweeps: usize) -> Vec<Point3> {
    let places = (0..sweeps).flat_map(|i| (0..60).map(move |j| (i, j)));
    places.map(|(i, j)| Point3::new(280.0 + j as f64, -45.0 + 2.0 * i as f64, 0.0)).collect()
}

/// The upper part of a sphere, up to 60° off its top.
fn sphere(center: Point3) -> Vec<Point3> {
    let places = (1..20).flat_map(|i| (0..40).map(move |j| (i, j)));
    let point = |(i, j): (usize, usize)| {
        let (polar, turn) = (i as f64 * 0.055, j as f64 * 0.157);
        let (sin, cos) = polar.sin_cos();
        center + RADIUS * Vector3::new(sin * turn.cos(), sin * turn.sin(), cos)
    };
    places.map(point).collect()
}

struct Scans {
    table: Vec<Point3>,
    spheres: Vec<(Point3, Vec<Point3>)>,
}

impl Scans {
    fn new(
        pose: &Isometry3,
        sweeps: usize,
        centers: &[Point3],
        seed: u64,
        outliers: usize,
    ) -> Self {
        let mut noise = Noise(seed);
        let table = scan(table(sweeps), pose, &mut noise, outliers);
        let spheres =
            centers.iter().map(|c| (*c, scan(sphere(*c), pose, &mut noise, outliers))).collect();
        Self { table, spheres }
    }

    fn align(&self, turning: Turning) -> Result<Alignment, transect_sensors::SensorError> {
        let table = PlaneScan {
            points_in_sensor: &self.table,
            normal_in_world: Vector3::z() * 3.0,
            point_in_world: Point3::new(5.0, 5.0, 0.0),
        };
        let sphere = |(center, points): &(Point3, Vec<Point3>)| (*center, points.clone());
        let spheres: Vec<_> = self.spheres.iter().map(sphere).collect();
        let spheres: Vec<_> = spheres
            .iter()
            .map(|(center, points)| SphereScan {
                points_in_sensor: points,
                center_in_world: *center,
                radius: RADIUS,
            })
            .collect();
        align(&table, &spheres, turning)
    }
}

/// Largest error at places of the sensing volume, and of the tilt in degrees.
fn errors(found: &Isometry3, pose: &Isometry3) -> (f64, f64) {
    let volume = [(-50.0, 110.0), (50.0, 110.0), (-50.0, 200.0), (50.0, 200.0)];
    let off = |(x, z): (f64, f64)| {
        let p = Point3::new(x, 0.0, z);
        (found * p - pose * p).norm()
    };
    let angle = found.rotation.angle_to(&pose.rotation).to_degrees();
    (volume.into_iter().map(off).fold(0.0, f64::max), angle)
}

const ONE: [Point3; 1] = [Point3::new(300.0, -20.0, 20.0)];
const TWO: [Point3; 2] = [Point3::new(290.0, -30.0, 20.0), Point3::new(320.0, -10.0, 35.0)];

#[test]
fn a_table_and_a_sphere_give_the_pose() {
    for seed in 0..5 {
        for outliers in [0, 25] {
            let scans = Scans::new(&pose(), 25, &ONE, seed, outliers);
            let found = scans.align(LINEAR).unwrap();
            let (length, angle) = errors(&found.world_from_sensor, &pose());
            println!("off by {length:.4} mm, {angle:.4}°, residual {:.4} mm", found.residual_rms);
            assert!(length < 0.5 * SIGMA && angle < 0.01, "{length} {angle}");
            assert!((found.residual_rms / SIGMA - 1.0).abs() < 0.1, "{}", found.residual_rms);
            assert!((found.sphere_noise / SIGMA - 1.0).abs() < 0.2, "{}", found.sphere_noise);
            let axis = found.world_from_sensor * Vector3::y();
            assert!((axis - Vector3::y()).norm() < 1e-12, "the linear axis stays");
            let gross = scans.table.len() / 25;
            assert!(outliers == 0 || found.rejected > gross, "{} rejected", found.rejected);
        }
    }
}

#[test]
fn without_noise_the_pose_is_exact() {
    let mut scans = Scans::new(&pose(), 3, &ONE, 0, 0);
    scans.table = table(3).iter().map(|p| pose().inverse() * p).collect();
    for (center, points) in &mut scans.spheres {
        *points = sphere(*center).iter().map(|p| pose().inverse() * p).collect();
    }
    let found = scans.align(LINEAR).unwrap();
    let (length, _) = errors(&found.world_from_sensor, &pose());
    assert!(length < 1e-9 && found.residual_rms < 1e-10, "{length} {}", found.residual_rms);
    assert_eq!(found.rejected, 0, "rounding is no outlier");
}

#[test]
fn two_spheres_give_the_pose_without_knowing_the_axis() {
    let turned = Isometry3::new(Vector3::new(310.0, -45.0, 170.0), Vector3::new(0.4, 2.9, -0.3));
    for pose in [pose(), turned] {
        let scans = Scans::new(&pose, 25, &TWO, 3, 30);
        let found = scans.align(Turning::Free).unwrap();
        let (length, angle) = errors(&found.world_from_sensor, &pose);
        assert!(length < 2.0 * SIGMA && angle < 0.03, "{length} {angle}");
        assert!((found.residual_rms / SIGMA - 1.0).abs() < 0.1, "{}", found.residual_rms);
    }
}

#[test]
fn one_sweep_of_the_table_tells_the_tilt_but_not_a_free_rotation() {
    let scans = Scans::new(&pose(), 1, &ONE, 7, 0);
    let (length, _) = errors(&scans.align(LINEAR).unwrap().world_from_sensor, &pose());
    assert!(length < 3.0 * SIGMA, "{length}");
    let free = scans.align(Turning::Free).unwrap_err().to_string();
    assert!(free.contains("undetermined") && free.contains("a second sphere"), "{free}");
}

#[test]
fn scans_that_leave_a_motion_free_are_refused() {
    // An axis square to the table: turning about it changes nothing, with one sphere.
    let upright = Isometry3::translation(10.0, 20.0, 30.0);
    let scans = Scans::new(&upright, 25, &ONE, 1, 0);
    let along_normal = Turning::AboutAxis { in_sensor: Vector3::z(), in_world: Vector3::z() };
    let error = scans.align(along_normal).unwrap_err().to_string();
    assert!(error.contains("undetermined"), "{error}");
    // Two spheres above each other: turning about the line through them changes nothing.
    let stacked = [Point3::new(300.0, -20.0, 20.0), Point3::new(300.0, -20.0, 60.0)];
    let scans = Scans::new(&pose(), 25, &stacked, 1, 0);
    let error = scans.align(Turning::Free).unwrap_err().to_string();
    assert!(error.contains("undetermined"), "{error}");
}

#[test]
fn wrong_places_and_radii_are_named() {
    let sound = Scans::new(&pose(), 25, &TWO, 3, 30);
    let moved = |by: Vector3| {
        let mut scans = Scans::new(&pose(), 25, &TWO, 3, 30);
        scans.spheres[1].0 += by;
        scans.align(Turning::Free).unwrap_err().to_string()
    };
    assert!(sound.align(Turning::Free).is_ok());
    let apart = moved(Vector3::new(1.0, 0.0, 0.0));
    assert!(apart.contains("spheres 1 and 2 are 39.") && apart.contains("stated ones 39."));
    // The same distance between the spheres, and another one from the table.
    let mut lifted = Scans::new(&pose(), 25, &TWO, 3, 30);
    for (turning, lift) in [(Turning::Free, 1.0), (LINEAR, 1.0), (LINEAR, 9.0)] {
        lifted.spheres.iter_mut().zip(TWO).for_each(|((center, _), true_)| {
            center.z = true_.z + lift;
        });
        match lifted.align(turning) {
            Ok(found) => assert!(found.residual_rms > 10.0 * found.sphere_noise, "{found:?}"),
            Err(error) => assert!(error.to_string().contains("half of the points of"), "{error}"),
        }
    }
    let mut swapped = Scans::new(&pose(), 25, &TWO, 3, 30);
    let first = swapped.spheres[0].0;
    swapped.spheres[0].0 = std::mem::replace(&mut swapped.spheres[1].0, first);
    let error = swapped.align(Turning::Free).unwrap_err().to_string();
    assert!(error.contains("which file belongs to which"), "{error}");
}

#[test]
fn wrong_radii_are_named() {
    let scans = Scans::new(&pose(), 25, &TWO, 3, 30);
    let with_radius = |radius: f64| {
        let table = PlaneScan {
            points_in_sensor: &scans.table,
            normal_in_world: Vector3::z(),
            point_in_world: Point3::origin(),
        };
        let sphere = |(center, points)| SphereScan {
            points_in_sensor: points,
            center_in_world: center,
            radius,
        };
        let spheres = scans.spheres.iter().map(|(center, points)| sphere((*center, points)));
        align(&table, &spheres.collect::<Vec<_>>(), Turning::Free)
    };
    assert!(with_radius(RADIUS).is_ok());
    for wrong in [0.5 * RADIUS, RADIUS - 20.0 * SIGMA, RADIUS + 20.0 * SIGMA, 2.0 * RADIUS] {
        let error = with_radius(wrong).unwrap_err().to_string();
        let told = error.contains("the points on sphere 1 lie on one of radius")
            && error.contains(&format!("the stated radius is {wrong}"));
        assert!(told, "{wrong}: {error}");
    }
}

#[test]
fn bad_scans_are_named() {
    let scans = Scans::new(&pose(), 5, &ONE, 1, 0);
    let message = |scans: &Scans, turning| scans.align(turning).unwrap_err().to_string();
    let none = Scans { table: scans.table.clone(), spheres: Vec::new() };
    assert_eq!(message(&none, LINEAR), "spheres = 0: at least one sphere");
    let few = Scans { table: scans.table[..2].to_vec(), spheres: scans.spheres.clone() };
    assert_eq!(message(&few, LINEAR), "table = 2: more scanned points");
    let mut odd = Scans { table: scans.table.clone(), spheres: scans.spheres.clone() };
    odd.spheres[0].1[3].x = f64::NAN;
    assert_eq!(message(&odd, LINEAR), "spheres = NaN: finite points");
    let no_axis = Turning::AboutAxis { in_sensor: Vector3::zeros(), in_world: Vector3::y() };
    assert_eq!(message(&scans, no_axis), "axis = 0: a direction");
}
