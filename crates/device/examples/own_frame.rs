//! A sensor of one's own: a camera with parallel rays, and a view that it measured.
//!
//! ```text
//! cargo run -p transect-device --example own_frame
//! ```

use std::error::Error;
use std::sync::Arc;
use transect_device::{
    DeviceFrame, DevicePoint, Handedness, ImageSize, Isometry3, Pixel, Point3, RangeImage, Ray,
    SensorPlane, Vector3, View,
};

/// Rays along z, one every `step` in x (columns) and in y (rows, downwards). d3 is z.
#[derive(Debug)]
struct ParallelCamera {
    size: ImageSize,
    step: f64,
}

impl DeviceFrame for ParallelCamera {
    fn size(&self) -> ImageSize {
        self.size
    }

    fn kind(&self) -> &'static str {
        "ParallelCamera"
    }

    /// ∂p/∂column × ∂p/∂row = x × y = z, which is the rays' direction.
    fn handedness(&self) -> Handedness {
        Handedness::ColumnsRight
    }

    fn ray(&self, pixel: Pixel) -> Option<Ray> {
        let inside = pixel.row < self.size.rows && pixel.col < self.size.cols;
        let start = Point3::new(pixel.col as f64 * self.step, pixel.row as f64 * self.step, 0.0);
        inside.then_some(Ray { start, direction: Vector3::z() })
    }

    fn point(&self, pixel: Pixel, d3: f64) -> Option<Point3> {
        self.ray(pixel).map(|ray| ray.start + ray.direction * d3)
    }

    fn device_point(&self, p: &Point3) -> Option<DevicePoint> {
        (p.z > 0.0).then_some(DevicePoint { row: p.y / self.step, col: p.x / self.step, d3: p.z })
    }

    fn plane_value(&self, pixel: Pixel, plane: &SensorPlane) -> Option<f64> {
        let start = self.ray(pixel)?.start;
        let d3 = (plane.offset - plane.normal.dot(&start.coords)) / plane.normal.z;
        (d3.is_finite() && d3 > 0.0).then_some(d3)
    }

    /// The corners of the box of all points.
    fn extent(&self, direction: &Vector3, nearest: f64, farthest: f64) -> (f64, f64) {
        let last_row = (self.size.rows - 1) as f64 * self.step;
        let last_col = (self.size.cols - 1) as f64 * self.step;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for z in [nearest, farthest] {
            for (x, y) in [(0.0, 0.0), (last_col, 0.0), (0.0, last_row), (last_col, last_row)] {
                let along = direction.dot(&Vector3::new(x, y, z));
                (low, high) = (low.min(along), high.max(along));
            }
        }
        (low, high)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let camera = ParallelCamera { size: ImageSize { rows: 2, cols: 3 }, step: 0.5 };

    // f and F are inverse to each other.
    let pixel = Pixel::new(1, 2);
    let p = camera.point(pixel, 4.0).ok_or("no point")?;
    assert_eq!(p, Point3::new(1.0, 0.5, 4.0));
    let back = camera.device_point(&p).ok_or("not seen")?;
    assert_eq!((back.row, back.col, back.d3), (1.0, 2.0, 4.0));

    // Zero and NaN are missing pixels.
    let values = vec![4.0, 4.0, 0.0, 4.5, f32::NAN, 4.5];
    let image = RangeImage::from_values(camera.size, values)?;
    assert_eq!(image.valid_count(), 4);

    // The view puts image and frame into the world.
    let world_from_sensor = Isometry3::translation(10.0, 0.0, 0.0);
    let view = View::new("own", image, Arc::new(camera), world_from_sensor, Some(0.01))?;
    let seen = view.point_in_sensor(Pixel::new(0, 1)).ok_or("missing")?;
    assert_eq!(view.world_from_sensor() * seen, Point3::new(10.5, 0.0, 4.0));
    assert_eq!(view.point_in_sensor(Pixel::new(1, 1)), None);
    Ok(())
}
