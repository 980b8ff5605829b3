//! How fast the error of each subpixel solution falls with the spacing of the samples.

use crate::common::observed_orders;
use crate::dissertation_scene::*;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;
use transect_device::{DeviceFrame, ImageSize, Isometry3, Pixel, Point3, Vector3};
use transect_partial::dissertation::{DissertationOptions, partial_model};
use transect_partial::subpixel::Subpixel;
use transect_sensors::{AngularScan, ImagingRadar, Intrinsics, Pinhole, RayTable};

/// Samples per side of the images, coarse to fine.
const DENSITIES: [usize; 4] = [23, 32, 45, 64];

/// Half the field of view, in radians.
const FIELD: f64 = 0.45;

#[derive(Debug, Clone, Copy)]
enum Sensor {
    Radar,
    Camera,
    /// A camera given by its rays: neither angles nor straight rows help.
    Lens,
}

impl Sensor {
    /// A sensor of so many rows and columns over the same field.
    fn frame(self, n: usize) -> Arc<dyn DeviceFrame> {
        let size = ImageSize { rows: n, cols: n };
        let middle = 0.5 * (n - 1) as f64;
        match self {
            Self::Radar => {
                let step = FIELD / middle;
                let scan = AngularScan::from_radians(-FIELD, step);
                Arc::new(ImagingRadar::new(size, scan, scan).unwrap())
            }
            Self::Camera => {
                let f = middle / FIELD.tan();
                let k = Intrinsics { fx: f, fy: f, cx: middle, cy: middle };
                Arc::new(Pinhole::new(size, k).unwrap())
            }
            Self::Lens => {
                let ray = |k: usize| {
                    let at = |p: usize| (p as f64 - middle) / middle * FIELD;
                    let (x, y) = (at(k % n), at(k / n));
                    let out = 1.0 + 0.3 * (x * x + y * y);
                    Vector3::new(x * out, y * out, 1.0)
                };
                let rays = (0..size.pixels()).map(ray).collect();
                Arc::new(RayTable::new(size, rays, Default::default()).unwrap())
            }
        }
    }
}

/// A surface about 1 in front of the sensor, filling most of its field.
fn surfaces() -> [(&'static str, Solid); 3] {
    let axis = Vector3::new(0.3, 1.0, 0.2).normalize();
    let centre = Point3::new(0.02, -0.03, 1.4);
    [
        ("ball", Solid::Ball { centre, radius: 0.7 }),
        ("cylinder", Solid::Cylinder { on_axis: centre, axis, radius: 0.7 }),
        ("torus", Solid::Torus { centre, axis: Vector3::x(), radius: 0.5, tube: 0.4 }),
    ]
}

/// Root mean square distance of the nodes from the surface, where it is seen at no more than 50°.
/// Beyond, the surface's own curvature along the rows has no bound. Nodes within two pixels of the
/// image's border do not count: four points are not to be had there.
fn error(sensor: Sensor, solid: &Solid, subpixel: Subpixel, n: usize) -> f64 {
    let frame = sensor.frame(n);
    // Sensors look along z, the radar along x.
    let turn = match sensor {
        Sensor::Radar => nalgebra::UnitQuaternion::from_scaled_axis(-Vector3::y() * FRAC_PI_2),
        _ => nalgebra::UnitQuaternion::identity(),
    };
    let pose = Isometry3::from_parts(nalgebra::Translation3::identity(), turn);
    let view = look(frame, pose, &[*solid], |_| false).unwrap();
    let planes = planes_through(&Point3::new(0.0, 0.0, 1.0), Vector3::new(0.5, 0.8, 0.1), 0.021);
    let mut options = DissertationOptions::default();
    options.subpixel = subpixel;
    let model = partial_model(&view, &planes, &options).unwrap();
    let (mut sum, mut count) = (0.0, 0_usize);
    for plane in &model.planes {
        let to_world = planes.frame(plane.plane);
        let nodes = plane.curves.iter().flat_map(|c| c.curve.nodes().iter().zip(&c.pixels));
        for (node, pixel) in nodes {
            let within = 2..n - 2;
            if !(within.contains(&pixel.row) && within.contains(&pixel.col)) {
                continue;
            }
            let p = to_world.world_from_plane(&node.position);
            let incidence = -normal(&[*solid], &p).dot(&p.coords.normalize());
            if incidence > 50_f64.to_radians().cos() {
                sum += solid.distance(&p).powi(2);
                count += 1;
            }
        }
    }
    assert!(count > 300, "{count} nodes");
    (sum / count as f64).sqrt()
}

/// The errors over [`DENSITIES`], and the orders between them.
fn measured(sensor: Sensor, solid: &Solid, subpixel: Subpixel) -> (Vec<f64>, Vec<f64>) {
    let errors: Vec<f64> = DENSITIES.iter().map(|n| error(sensor, solid, subpixel, *n)).collect();
    let spacings = DENSITIES.map(|n| 2.0 * FIELD / (n - 1) as f64);
    let orders = observed_orders(&spacings, &errors);
    (errors, orders)
}

#[test]
fn linear_solutions_converge_with_the_square_and_four_points_with_the_fourth_power() {
    for sensor in [Sensor::Radar, Sensor::Camera, Sensor::Lens] {
        for (name, solid) in surfaces() {
            for subpixel in Subpixel::ALL {
                let (errors, orders) = measured(sensor, &solid, subpixel);
                let errors: Vec<_> = errors.iter().map(|e| format!("{e:.1e}")).collect();
                println!("{sensor:?} {name} {subpixel}: {} {orders:.2?}", errors.join(" "));
                let (least, most) =
                    if subpixel == Subpixel::FourPoint { (3.4, 4.7) } else { (1.8, 2.2) };
                let steps = (orders.len() as f64, orders.iter().sum::<f64>());
                let mean = steps.1 / steps.0;
                assert!((least..most).contains(&mean), "{sensor:?} {name} {subpixel}: {orders:?}");
            }
        }
    }
}

#[test]
fn every_solution_lies_on_the_plane_between_its_pixels() {
    use transect_partial::subpixel::{AngularGrid, PairLine, Solver};
    for sensor in [Sensor::Radar, Sensor::Camera, Sensor::Lens] {
        let frame = sensor.frame(23);
        let angles = AngularGrid::read(frame.as_ref());
        assert_eq!(angles.is_some(), matches!(sensor, Sensor::Radar));
        let (_, solid) = surfaces()[0];
        let turn = match sensor {
            Sensor::Radar => nalgebra::UnitQuaternion::from_scaled_axis(-Vector3::y() * FRAC_PI_2),
            _ => nalgebra::UnitQuaternion::identity(),
        };
        let pose = Isometry3::from_parts(nalgebra::Translation3::identity(), turn);
        let view = look(frame, pose, &[solid], |_| false).unwrap();
        let planes = planes_through(&Point3::new(0.0, 0.0, 1.0), Vector3::new(0.5, 0.8, 0.1), 0.02);
        let axes = transect_partial::SectionAxes::new(&view, &planes).unwrap();
        for (level, subpixel) in (-2..3).flat_map(|k| Subpixel::ALL.map(|s| (k, s))) {
            let plane = axes.sensor_plane(level);
            let solver = Solver::new(&view, plane, subpixel, angles.as_ref());
            let mut met = 0;
            for col in 2..22 {
                let at = |row, col| Pixel::new(row, col);
                for (first, second, before, after) in [
                    (at(11, col - 1), at(11, col), at(11, col - 2), at(11, col + 1)),
                    (at(col - 1, 11), at(col, 11), at(col - 2, 11), at(col + 1, 11)),
                ] {
                    let line = PairLine { before: Some(before), first, second, after: Some(after) };
                    let height = |p: Point3| plane.normal.dot(&p.coords) - plane.offset;
                    let ends = [first, second].map(|p| view.point_in_sensor(p).map(height));
                    let [Some(a), Some(b)] = ends else { continue };
                    if a * b > 0.0 {
                        continue;
                    }
                    let meeting = solver.meet(&line).unwrap();
                    assert!((0.0..=1.0).contains(&meeting.parameter));
                    // The generic curve–curve solution lies on the plane to second order only.
                    let exact = subpixel != Subpixel::DeviceCurves;
                    let allowed = if exact { 1e-12 } else { 1e-3 };
                    assert!(height(meeting.point).abs() < allowed, "{sensor:?} {subpixel}");
                    met += 1;
                }
            }
            assert!(met > 0, "{sensor:?} plane {level}");
        }
    }
}
