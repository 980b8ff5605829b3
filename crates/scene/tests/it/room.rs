//! The bundled room as a whole: rays against truth, and how fast rays are.

use crate::common::{views, winding};
use std::time::Instant;
use transect_geometry::{Curve, Point2, Point3};
use transect_scene::{BUNDLED_ROOM, Description, Noise};

/// Largest distance of a truth curve's surface from the round solids, in metres.
const CHORD_ERROR: f64 = 1e-5;

#[test]
fn every_clean_ray_ends_on_the_surface_of_the_room() {
    let room = Description::parse(BUNDLED_ROOM).unwrap();
    let scene = room.scene();
    for view in views(&room, &Noise::NONE) {
        let size = view.image().size();
        assert_eq!(
            view.image().valid_count(),
            size.pixels(),
            "{}: the room is closed",
            view.name()
        );
        for k in (0..size.pixels()).step_by(7) {
            let pixel = size.pixel(k);
            let mut ray = view.frame().ray(pixel).unwrap();
            ray.start = view.world_from_sensor() * ray.start;
            ray.direction = view.world_from_sensor() * ray.direction;
            let hit = scene.hit(&ray).unwrap();
            let range = view.point_in_sensor(pixel).unwrap().coords.norm();
            // Stored as f32: 5e-7 m at 8 m.
            assert!((hit.distance - range).abs() < 5e-7, "{pixel} of {}", view.name());
            assert!(scene.contains(&(hit.point_in_world - hit.normal_in_world * 1e-7)));
            assert!(!scene.contains(&(hit.point_in_world - ray.direction * 1e-7)));
        }
    }
}

#[test]
fn sections_agree_with_the_solids_on_every_plane() {
    let room = Description::parse(BUNDLED_ROOM).unwrap();
    let (scene, sections) =
        (room.scene(), room.scene().sections(&room.planes, CHORD_ERROR).unwrap());
    assert_eq!(sections.len(), 64, "3.2 m from floor to roof");
    for (plane, curves) in &sections {
        assert!(curves.iter().all(Curve::is_closed));
        let frame = room.planes.frame(*plane);
        let (mut inside, mut places) = (0, 0);
        for row in 0..135 {
            for col in 0..160 {
                let p =
                    Point2::new(-0.1931 + 0.04 * f64::from(col), -0.1937 + 0.04 * f64::from(row));
                let solid = scene.contains(&frame.world_from_plane(&p));
                assert_eq!(winding(curves, p), i32::from(solid), "{p} on plane {plane}");
                inside += i32::from(solid);
                places += 1;
            }
        }
        let area: f64 = curves.iter().filter_map(Curve::signed_area).sum();
        let counted = f64::from(inside) / f64::from(places) * 6.4 * 5.4;
        assert!((area - counted).abs() < 0.35, "plane {plane}: {area} against {counted}");
    }
}

#[test]
fn areas_above_the_furniture_are_walls_pillar_and_lamp() {
    let room = Description::parse(BUNDLED_ROOM).unwrap();
    let sections = room.scene().sections(&room.planes, CHORD_ERROR).unwrap();
    let pi = std::f64::consts::PI;
    let walls_and_pillar = 6.4 * 5.4 - 6.0 * 5.0 + pi * 0.22 * 0.22;
    for (plane, curves) in &sections {
        let height = room.planes.station(*plane);
        let off_lamp = height - 2.05f64;
        let hung = match height {
            h if (1.3..1.87).contains(&h) => 0.0,
            h if (1.87..2.19).contains(&h) => pi * (0.18 * 0.18 - off_lamp * off_lamp),
            h if (2.23..2.8).contains(&h) => pi * 0.015 * 0.015,
            _ => continue,
        };
        let area: f64 = curves.iter().filter_map(Curve::signed_area).sum();
        // Round outlines lose at most circumference times chord error, over the sine of the slope.
        assert!((area - walls_and_pillar - hung).abs() < 5e-5, "{height}: {area}");
    }
    let floor: f64 =
        sections.values().next().into_iter().flatten().filter_map(Curve::signed_area).sum();
    assert!((floor - 6.4 * 5.4).abs() < 1e-7);
}

#[test]
fn truth_mesh_is_closed_per_solid() {
    let room = Description::parse(BUNDLED_ROOM).unwrap();
    let mesh = room.scene().mesh(1e-3).unwrap();
    assert_eq!(mesh.check_closed(), Ok(()));
    assert!(mesh.vertices.iter().all(|p: &Point3| p.coords.amax() < 6.3));
}

#[test]
fn four_noisy_views_are_cast_in_well_under_a_second() {
    let room = Description::parse(BUNDLED_ROOM).unwrap();
    let rays: usize = room.stations.iter().map(|s| s.size.pixels()).sum();
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        let views = views(&room, &room.noise);
        best = best.min(start.elapsed().as_secs_f64());
        let share =
            views.iter().map(|v| v.image().valid_count()).sum::<usize>() as f64 / rays as f64;
        assert!((share - 0.98).abs() < 0.001, "{share}");
        assert_eq!(views[0].sigma(), Some(0.002));
    }
    println!("{rays} rays in {best:.3} s: {:.2} million rays per second", rays as f64 / best / 1e6);
}
