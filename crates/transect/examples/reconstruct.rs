//! Views in, cross-section model out: two depth cameras look at a ball from opposite sides.
//!
//! Run it with `cargo run --example reconstruct`.

use std::sync::Arc;
use transect::device::{DeviceFrame, Pixel};
use transect::geometry::Point3;
use transect::model::Location;
use transect::sensors::{Intrinsics, Pinhole};
use transect::{
    ImageSize, Isometry3, LengthUnit, PlaneFamily, RangeImage, Setup, StraightGuide, Unwatched,
    Vector3, View, reconstruct,
};

/// Radius of the ball, in metres.
const RADIUS: f64 = 0.5;

/// The depth image of the ball, whose centre is 2 m before the camera. Rays that miss the ball
/// have no return, which is NaN.
fn depths(camera: &Pinhole, size: ImageSize) -> Vec<f32> {
    let centre = Point3::new(0.0, 0.0, 2.0);
    let pixels = (0..size.rows).flat_map(|row| (0..size.cols).map(move |c| Pixel::new(row, c)));
    let depth = |pixel| {
        let ray = camera.ray(pixel)?;
        let direction = ray.direction.normalize();
        let along = direction.dot(&(centre - ray.start));
        let miss = (centre - ray.start).norm_squared() - along * along;
        let half_chord = (RADIUS * RADIUS - miss).sqrt();
        Some(((along - half_chord) * direction.z) as f32)
    };
    pixels.map(|pixel| depth(pixel).unwrap_or(f32::NAN)).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let size = ImageSize { rows: 120, cols: 120 };
    let camera = Pinhole::new(size, Intrinsics { fx: 200.0, fy: 200.0, cx: 59.5, cy: 59.5 })?;
    let image = RangeImage::from_values(size, depths(&camera, size))?;

    // The first camera is the world's origin. The second one is 4 m ahead, turned by 180°.
    let turned = Isometry3::new(Vector3::new(0.0, 0.0, 4.0), Vector3::y() * std::f64::consts::PI);
    let camera: Arc<dyn DeviceFrame> = Arc::new(camera);
    let views = [
        View::new("front", image.clone(), camera.clone(), Isometry3::identity(), None)?,
        View::new("back", image, camera, turned, None)?,
    ];

    // Sections every 5 cm, perpendicular to the axis on which the cameras look down.
    let guide = StraightGuide::along(Vector3::y())?;
    let setup = Setup::new(LengthUnit::Metre, PlaneFamily::new(guide, 0.025, 0.05)?);
    let result = reconstruct(&views, &setup, &Unwatched)?;

    // Every node lies on the ball, to within a millimetre.
    let centre = Point3::new(0.0, 0.0, 2.0);
    let planes = result.model.planes();
    for (plane, section) in result.model.sections() {
        for node in section.curves().flat_map(|curve| curve.nodes()) {
            let point = planes.frame(plane).world_from_plane(&node.position);
            assert!(((point - centre).norm() - RADIUS).abs() < 1e-3, "{point}");
        }
    }
    // The solid is on the left of every curve, so the model knows inside from outside.
    assert_eq!(result.model.locate(&centre).location, Location::Inside);
    let beside = Point3::new(0.0, 0.0, 1.2);
    assert_eq!(result.model.locate(&beside).location, Location::Outside);
    assert!(result.report.warnings().is_empty());
    Ok(())
}
