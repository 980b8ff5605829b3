//! Every solid against its distance function: rays, sections and areas.

use crate::common::winding;
use proptest::prelude::*;
use std::f64::consts::PI;
use transect_device::Ray;
use transect_geometry::{
    Curve, Isometry3, PlaneFamily, PlaneIndex, Point2, Point3, StraightGuide, Vector3,
};
use transect_scene::{Scene, Shape, Solid};

const CHORD_ERROR: f64 = 1e-5;

/// A shape with what is known of it without looking at its code.
struct Known {
    name: &'static str,
    shape: Shape,
    /// Never more than the distance from the surface, negative inside, 0 on the surface only.
    bound: fn(&Point3) -> f64,
    /// Area of its sections perpendicular to z, by height.
    area: fn(f64) -> f64,
    half_height: f64,
}

fn square(half: f64) -> Vec<Point2> {
    [[-half, -half], [half, -half], [half, half], [-half, half]].map(Point2::from).to_vec()
}

/// A star of five points, concave, whose top is smaller than its bottom.
fn star(outer: f64, inner: f64) -> Vec<Point2> {
    let corner = |k: u32| {
        let (sin, cos) = (PI * f64::from(k) / 5.0).sin_cos();
        Point2::new(cos, sin) * if k.is_multiple_of(2) { outer } else { inner }
    };
    (0..10).map(corner).collect()
}

/// Bound of a solid between z = -1 and 1 whose radius falls from 1.2 to a share of it.
fn frustum_bound(p: &Point3, top: f64) -> f64 {
    let slope = 0.5 * (top - 1.2);
    let radius = 0.5 * (1.2 + top) + slope * p.z;
    let mantle = (p.x.hypot(p.y) - radius) / (1.0 + slope * slope).sqrt();
    mantle.max(p.z.abs() - 1.0)
}

/// The star shrinks from 1 to 0.5 over its height, so each section is a scaled star.
fn star_bound(p: &Point3) -> f64 {
    let scale = 0.75 - 0.25 * p.z.clamp(-1.0, 1.0);
    let sector = PI / 5.0;
    let angle = (p.y.atan2(p.x) + sector).rem_euclid(2.0 * sector) - sector;
    let (q, radius) = (angle.abs(), p.x.hypot(p.y));
    // The edge from (1.4, 0) to 0.6 at 36°, as a line: n · q = d.
    let (sin, cos) = sector.sin_cos();
    let (edge_x, edge_y) = (0.6 * cos - 1.4, 0.6 * sin);
    let length = edge_x.hypot(edge_y);
    let (nx, ny) = (edge_y / length, -edge_x / length);
    let off = radius * (nx * q.cos() + ny * q.sin()) - scale * nx * 1.4;
    // Edges end in corners and lean inwards: a share of the distance is a safe bound.
    (0.4 * off).max(p.z.abs() - 1.0)
}

fn known() -> Vec<Known> {
    vec![
        Known {
            name: "cone",
            shape: Shape::cone(1.2, 2.0).unwrap(),
            bound: |p| frustum_bound(p, 0.0),
            area: |z| PI * (0.6 * (1.0 - z)).powi(2),
            half_height: 1.0,
        },
        Known {
            name: "frustum",
            shape: Shape::frustum(1.2, 0.5, 2.0).unwrap(),
            bound: |p| frustum_bound(p, 0.5),
            area: |z| PI * (0.85 - 0.35 * z).powi(2),
            half_height: 1.0,
        },
        Known {
            name: "funnel",
            shape: Shape::frustum(1.2, 1.7, 2.0).unwrap(),
            bound: |p| frustum_bound(p, 1.7),
            area: |z| PI * (1.45 + 0.25 * z).powi(2),
            half_height: 1.0,
        },
        Known {
            name: "torus",
            shape: Shape::torus(1.3, 0.5).unwrap(),
            bound: |p| (p.x.hypot(p.y) - 1.3).hypot(p.z) - 0.5,
            area: |z| 4.0 * PI * 1.3 * (0.25 - z * z).sqrt(),
            half_height: 0.5,
        },
        Known {
            name: "pyramid",
            shape: Shape::pyramid(Vector3::new(2.0, 1.6, 2.0)).unwrap(),
            bound: |p| {
                let side = |across: f64, half: f64| {
                    (across.abs() - half * 0.5 * (1.0 - p.z)) / (1.0 + 0.25 * half * half).sqrt()
                };
                side(p.x, 1.0).max(side(p.y, 0.8)).max(-1.0 - p.z)
            },
            area: |z| 3.2 * (0.5 * (1.0 - z)).powi(2),
            half_height: 1.0,
        },
        Known {
            name: "prism",
            shape: Shape::prism(&square(1.2), &square(0.7), 2.0).unwrap(),
            bound: |p| {
                let side = (p.x.abs().max(p.y.abs()) - 0.95 + 0.25 * p.z) / 1.0625f64.sqrt();
                side.max(p.z.abs() - 1.0)
            },
            area: |z| (1.9 - 0.5 * z).powi(2),
            half_height: 1.0,
        },
        Known {
            name: "star",
            shape: Shape::prism(&star(1.4, 0.6), &star(0.7, 0.3), 2.0).unwrap(),
            bound: star_bound,
            area: |z| 10.0 * 0.5 * 1.4 * 0.6 * (PI / 5.0).sin() * (0.75 - 0.25 * z).powi(2),
            half_height: 1.0,
        },
    ]
}

fn scene(shape: &Shape, pose: Isometry3) -> Scene {
    Scene::new(vec![Solid::new(shape.clone(), pose).unwrap()])
}

fn planes(normal: Vector3, offset: f64, interval: f64) -> PlaneFamily {
    PlaneFamily::new(StraightGuide::along(normal).unwrap(), offset, interval).unwrap()
}

#[test]
fn areas_are_those_of_closed_forms() {
    for Known { name, shape, area, half_height, .. } in known() {
        let family = planes(Vector3::z(), 0.0123, 0.05);
        let cut = scene(&shape, Isometry3::identity()).sections(&family, CHORD_ERROR).unwrap();
        assert_eq!(cut.len(), (2.0 * half_height / 0.05).round() as usize, "{name}");
        for (plane, curves) in &cut {
            assert!(curves.iter().all(Curve::is_closed), "{name}");
            let height = family.station(*plane);
            let (found, expected): (f64, _) =
                (curves.iter().filter_map(Curve::signed_area).sum(), area(height));
            // Round outlines lose circumference times chord error over the sine of the slope, which
            // is at worst that of the torus near its top.
            assert!((found - expected).abs() < 1e-3, "{name} at {height}: {found} {expected}");
        }
    }
}

#[test]
fn sections_wind_around_what_is_inside() {
    let pose = Isometry3::new(Vector3::new(0.3, -0.2, 0.1), Vector3::new(0.7, -0.4, 1.1));
    for Known { name, shape, bound, .. } in known() {
        let scene = scene(&shape, pose);
        let family = planes(Vector3::new(0.2, -0.3, 1.0), 0.0123, 0.2);
        let (mut inside, mut near) = (0, 0);
        for (plane, curves) in &scene.sections(&family, CHORD_ERROR).unwrap() {
            assert!(curves.iter().all(Curve::is_closed), "{name}");
            let frame = family.frame(*plane);
            for k in 0..60 * 60 {
                let p =
                    Point2::new(f64::from(k % 60) * 0.071 - 2.1, f64::from(k / 60) * 0.073 - 2.2);
                let in_world = frame.world_from_plane(&p);
                let off = bound(&pose.inverse_transform_point(&in_world));
                if off.abs() < CHORD_ERROR {
                    near += 1;
                    continue;
                }
                assert_eq!(winding(curves, p), i32::from(off < 0.0), "{name}: {in_world}");
                assert_eq!(scene.contains(&in_world), off < 0.0, "{name}: {in_world}");
                inside += i32::from(off < 0.0);
            }
        }
        assert!(inside > 200 && near < 10, "{name}: {inside} {near}");
    }
}

#[test]
fn one_plane_of_the_torus_has_two_rings() {
    let Known { shape, .. } = known().remove(3);
    let family = planes(Vector3::z(), 0.0, 10.0);
    let cut = scene(&shape, Isometry3::identity()).sections(&family, CHORD_ERROR).unwrap();
    let areas: Vec<_> = cut[&PlaneIndex(0)].iter().filter_map(Curve::signed_area).collect();
    assert_eq!(areas.len(), 2);
    assert!((areas[0] - PI * 1.8 * 1.8).abs() < 2e-4, "{areas:?}");
    assert!((areas[1] + PI * 0.8 * 0.8).abs() < 2e-4, "{areas:?}");
}

fn poses() -> impl Strategy<Value = Isometry3> {
    prop::array::uniform6(-1.5..1.5).prop_map(|[x, y, z, a, b, c]: [f64; 6]| {
        Isometry3::new(Vector3::new(x, y, z), Vector3::new(a, b, c))
    })
}

proptest! {
    #[test]
    fn hits_lie_on_the_surface_and_nothing_is_in_front_of_them(
        pose in poses(), azimuth in -3.0..3.0f64, height in -6.0..6.0f64,
        aim in prop::array::uniform3(-1.2..1.2),
    ) {
        let start = Point3::new(9.0 * azimuth.cos(), 9.0 * azimuth.sin(), height);
        let direction = (pose * Point3::from(aim) - start).normalize();
        for Known { name, shape, bound, .. } in known() {
            let off = |t: f64| bound(&pose.inverse_transform_point(&(start + direction * t)));
            let mut marched = 0.0;
            // Ends before the surface, since steps are never longer than the distance from it.
            for _ in 0..20_000 {
                let step = off(marched);
                if step < 1e-8 || marched > 30.0 {
                    break;
                }
                marched += step;
            }
            match scene(&shape, pose).hit(&Ray { start, direction }) {
                Some(hit) => {
                    prop_assert!(off(hit.distance).abs() < 1e-9, "{name}: {}", off(hit.distance));
                    prop_assert!(hit.normal_in_world.dot(&direction) <= 1e-9, "{name}");
                    prop_assert!((hit.normal_in_world.norm() - 1.0).abs() < 1e-9, "{name}");
                    let outside = hit.point_in_world + hit.normal_in_world * 1e-6;
                    prop_assert!(bound(&pose.inverse_transform_point(&outside)) > 0.0, "{name}");
                    prop_assert!(hit.distance - marched < 1e-4, "{name}: {marched}");
                }
                None => prop_assert!(marched > 13.0, "{name}: {marched}"),
            }
        }
    }
}
