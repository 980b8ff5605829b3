//! Sections of a ball from one range image: `cargo run -p transect-partial --example
//! ball_sections`.
//!
//! A camera sees a ball of radius 1 from a distance of 4. Every curve that comes out must lie on
//! the ball.
#![allow(clippy::print_stdout, reason = "an example that prints its result")]

use std::error::Error;
use std::sync::Arc;
use transect_device::{DeviceFrame, ImageSize, Isometry3, Pixel, RangeImage, Vector3, View};
use transect_geometry::{PlaneFamily, StraightGuide};
use transect_partial::{Method, partial_model};
use transect_sensors::{Intrinsics, Pinhole};

const DISTANCE: f64 = 4.0;

fn main() -> Result<(), Box<dyn Error>> {
    // The sensor: a pinhole camera that looks along +z of its frame.
    let size = ImageSize { rows: 120, cols: 160 };
    let camera = Pinhole::new(size, Intrinsics { fx: 180.0, fy: 180.0, cx: 79.5, cy: 59.5 })?;

    // The image: one value per pixel, NaN where the ray misses the ball.
    let pixels = size.all_pixels();
    let values = pixels.map(|pixel| depth(&camera, pixel).unwrap_or(f64::NAN) as f32).collect();
    let image = RangeImage::from_values(size, values)?;

    // The view: the image in the world, with the camera at the origin and no noise.
    let view = View::new("ball", image, Arc::new(camera), Isometry3::identity(), Some(0.0))?;

    // The planes: horizontal, 0.25 apart, through the centre of the ball.
    let planes = PlaneFamily::new(StraightGuide::along(Vector3::y())?, 0.0, 0.25)?;

    let model = partial_model(&view, &planes, &Method::default())?;
    for section in &model.planes {
        let frame = planes.frame(section.plane);
        let nodes = || section.curves.iter().flat_map(|c| c.curve.nodes());
        let error = |p| (frame.world_from_plane(p) - Vector3::z() * DISTANCE).coords.norm() - 1.0;
        let worst = nodes().map(|n| error(&n.position).abs()).fold(0.0, f64::max);
        println!("plane {:2}: {} nodes, error {worst:.5}", section.plane.0, nodes().count());
        assert!(worst < 0.01, "a node is {worst} away from the ball");
    }
    assert_eq!(model.planes.len(), 7, "planes at -0.75, -0.5, ... 0.75");
    Ok(())
}

/// Depth of the ball along a pixel's ray.
fn depth(camera: &Pinhole, pixel: Pixel) -> Option<f64> {
    let ray = camera.ray(pixel)?.direction;
    let along = DISTANCE * ray.z;
    let half_chord = (1.0 - (DISTANCE * DISTANCE - along * along)).max(0.0).sqrt();
    let hit = ray * (along - half_chord);
    (half_chord > 0.0).then(|| camera.device_point(&hit.into()).map(|p| p.d3)).flatten()
}
