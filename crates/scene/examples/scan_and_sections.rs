//! A scene, the image a depth camera takes of it, and its exact sections.
//!
//! ```text
//! cargo run --release -p transect-scene --example scan_and_sections
//! ```

use std::error::Error;
use transect_device::{DeviceFrame, ImageSize, Pixel};
use transect_geometry::{Isometry3, PlaneFamily, PlaneIndex, Point3, StraightGuide, Vector3};
use transect_scene::{Scene, Shape, Solid};
use transect_sensors::{Intrinsics, Pinhole};

fn main() -> Result<(), Box<dyn Error>> {
    // A ball of radius 1 at the origin, on a plate below it. Lengths are in metres.
    let ball = Solid::new(Shape::ball(1.0)?, Isometry3::identity())?.named("ball");
    let below = Isometry3::translation(0.0, 0.0, -1.1);
    let plate = Solid::new(Shape::cuboid(Vector3::new(6.0, 6.0, 0.2))?, below)?.named("plate");
    let scene = Scene::new(vec![ball, plate]);

    // A camera 5 m above looks down: a half turn about x points its z axis downwards.
    let camera = Pinhole::new(
        ImageSize { rows: 101, cols: 101 },
        Intrinsics { fx: 120.0, fy: 120.0, cx: 50.0, cy: 50.0 },
    )?;
    let world_from_camera =
        Isometry3::new(Vector3::new(0.0, 0.0, 5.0), Vector3::x() * std::f64::consts::PI);
    let image = scene.cast(&camera, &world_from_camera)?;

    // Straight below the camera is the top of the ball, 4 m away. In the corner is the plate.
    let depth = |row, col| image.get(Pixel::new(row, col)).ok_or("missing");
    assert!((depth(50, 50)? - 4.0).abs() < 1e-6);
    assert!((depth(0, 0)? - 6.0).abs() < 1e-6);
    let ray = camera.ray(Pixel::new(50, 50)).ok_or("no ray")?;
    assert!((ray.direction - Vector3::z()).norm() < 1e-12);

    // Exact sections every 0.25 m: plane 0 cuts the ball at its equator.
    let planes = PlaneFamily::new(StraightGuide::along(Vector3::z())?, 0.0, 0.25)?;
    let sections = scene.sections(&planes, 1e-4)?;
    let equator = sections.get(&PlaneIndex(0)).ok_or("no section")?;
    let area: f64 = equator.iter().filter_map(|curve| curve.signed_area()).sum();
    assert!((area - std::f64::consts::PI).abs() < 1e-3, "{area}");
    assert!(scene.contains(&Point3::new(0.0, 0.0, 0.9)));
    Ok(())
}
