//! The bundled scenes: what their stations see, and their sections against their solids.

use crate::common::{views, winding};
use transect_geometry::{Curve, Envelope, Point3, Vector2};
use transect_scene::{BUNDLED_SCENES, Description, Noise};

/// Largest distance of a truth curve from the round solids, as a share of the plane interval.
const CHORD_SHARE: f64 = 1e-4;

fn described() -> impl Iterator<Item = (&'static str, Description)> {
    // The room has tests of its own.
    let others = BUNDLED_SCENES.into_iter().filter(|(name, _)| *name != "room");
    others.map(|(name, toml)| (name, Description::parse(toml).unwrap()))
}

#[test]
fn every_station_stands_free_and_sees_the_scene() {
    for (name, description) in described() {
        let scene = description.scene();
        for view in views(&description, &Noise::NONE) {
            let place = Point3::from(view.world_from_sensor().translation.vector);
            assert!(!scene.contains(&place), "{name}: {}", view.name());
            let size = view.image().size();
            let share = view.image().valid_count() as f64 / size.pixels() as f64;
            assert!(share > 0.12, "{name}: {} sees {share}", view.name());
            for k in (0..size.pixels()).step_by(61) {
                let pixel = size.pixel(k);
                let Some(point) = view.point_in_sensor(pixel) else { continue };
                let mut ray = view.frame().ray(pixel).unwrap();
                let range = (point - ray.start).norm();
                ray.start = view.world_from_sensor() * ray.start;
                ray.direction = view.world_from_sensor() * ray.direction;
                let hit = scene.hit(&ray).unwrap();
                // Stored as f32.
                let rounding = 1e-6 * hit.distance;
                assert!((hit.distance - range).abs() < rounding, "{name}: {pixel}");
                assert!(
                    scene.contains(&(hit.point_in_world - hit.normal_in_world * 1e-6)),
                    "{name}"
                );
            }
        }
    }
}

#[test]
fn noisy_views_lose_some_pixels_and_state_their_sigma() {
    for (name, description) in described() {
        let clean = views(&description, &Noise::NONE);
        for (noisy, clean) in views(&description, &description.noise).iter().zip(&clean) {
            let kept = noisy.image().valid_count() as f64 / clean.image().valid_count() as f64;
            assert!((0.7..=1.0).contains(&kept), "{name}: {kept}");
            // Errors that pixels share have no sigma to state.
            assert_eq!(noisy.sigma().is_none(), name == "kitchen", "{name}");
            assert!(noisy.sigma().is_none_or(|s| s >= description.noise.sigma), "{name}");
        }
    }
}

#[test]
fn sections_are_closed_and_wind_around_the_solids() {
    for (name, description) in described() {
        let (scene, planes) = (description.scene(), &description.planes);
        let cut = scene.sections(planes, CHORD_SHARE * planes.interval()).unwrap();
        assert!(cut.len() >= 40, "{name}: {} planes", cut.len());
        for (plane, curves) in cut.iter().step_by(5) {
            assert!(curves.iter().all(Curve::is_closed), "{name}");
            let around = curves.iter().map(Curve::envelope);
            let Some(around) = around.reduce(|a, b| Envelope::merged(&a, &b)) else {
                continue;
            };
            let frame = planes.frame(*plane);
            let (mut inside, mut differ) = (0, 0);
            for k in 0..50 * 50 {
                let share = |i: i32| f64::from(i) / 49.0 * 1.0377 - 0.0189;
                let across = around.size();
                let p =
                    around.min + Vector2::new(across.x * share(k % 50), across.y * share(k / 50));
                let solid = scene.contains(&frame.world_from_plane(&p));
                inside += i32::from(solid);
                differ += i32::from(winding(curves, p) != i32::from(solid));
            }
            // Points within a chord error of a round solid may differ; none should turn up.
            assert!(differ == 0 && inside > 0, "{name}, plane {plane}: {differ} of {inside}");
        }
    }
}

#[test]
fn truth_meshes_are_closed() {
    for (name, description) in described() {
        let mesh = description.scene().mesh(0.1 * description.planes.interval()).unwrap();
        assert_eq!(mesh.check_closed(), Ok(()), "{name}");
    }
}
