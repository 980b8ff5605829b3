//! Pinhole depth camera.
//!
//! ```text
//!         .------> x, columns j          ray of pixel (i, j): ((j - cx)/fx, (i - cy)/fy, 1)
//!        /|                              point: depth z times that
//!   z  <- |   (z into the scene)         pixel (i, j) = (cy + fy y/z, cx + fx x/z)
//!         v
//!         y, rows i
//! ```
//!
//! Axes: x right, y down, z forward, right-handed, seen from the camera. `d3` is the depth along z
//! (not the ray's length), in the model's length unit; all rays start at the origin. Pixel `(i, j)`
//! is sampled at its centre, `(cx, cy)` in the same counting. Noise is an error along the ray.

use crate::{SensorError, require};
use transect_device::{
    DeviceFrame, DevicePoint, Handedness, ImageSize, LinearForm, Pixel, Point3, RangeImage, Ray,
    SensorPlane, Vector3,
};

/// Focal lengths and principal point, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intrinsics {
    /// Focal length along the columns' direction.
    pub fx: f64,
    /// Focal length along the rows' direction.
    pub fy: f64,
    /// Column of the optical axis.
    pub cx: f64,
    /// Row of the optical axis.
    pub cy: f64,
}

/// The device frame of a depth camera; see the module's page.
#[derive(Debug, Clone, Copy)]
pub struct Pinhole {
    size: ImageSize,
    intrinsics: Intrinsics,
}

impl Pinhole {
    /// A camera without lens distortion.
    ///
    /// # Errors
    /// [`SensorError::BadParameter`] unless the focal lengths are positive and all are finite.
    pub fn new(size: ImageSize, intrinsics: Intrinsics) -> Result<Self, SensorError> {
        size.check()?;
        let Intrinsics { fx, fy, cx, cy } = intrinsics;
        require("fx", fx, fx > 0.0, "a positive focal length in pixels")?;
        require("fy", fy, fy > 0.0, "a positive focal length in pixels")?;
        require("cx", cx, true, "a column")?;
        require("cy", cy, true, "a row")?;
        Ok(Self { size, intrinsics })
    }

    /// The pixel's ray, scaled to depth 1.
    fn ray_at_depth_one(&self, row: f64, col: f64) -> Vector3 {
        let Intrinsics { fx, fy, cx, cy } = self.intrinsics;
        Vector3::new((col - cx) / fx, (row - cy) / fy, 1.0)
    }

    fn inside(&self, pixel: Pixel) -> Option<Vector3> {
        let inside = pixel.row < self.size.rows && pixel.col < self.size.cols;
        inside.then(|| self.ray_at_depth_one(pixel.row as f64, pixel.col as f64))
    }
}

impl DeviceFrame for Pinhole {
    fn size(&self) -> ImageSize {
        self.size
    }

    fn handedness(&self) -> Handedness {
        Handedness::ColumnsRight
    }

    fn ray(&self, pixel: Pixel) -> Option<Ray> {
        Some(Ray { start: Point3::origin(), direction: self.inside(pixel)?.normalize() })
    }

    fn point(&self, pixel: Pixel, d3: f64) -> Option<Point3> {
        Some(Point3::from(self.inside(pixel)? * d3))
    }

    fn device_point(&self, in_sensor: &Point3) -> Option<DevicePoint> {
        let Intrinsics { fx, fy, cx, cy } = self.intrinsics;
        let z = in_sensor.z;
        let seen = z > 0.0 && in_sensor.coords.iter().all(|c| c.is_finite());
        seen.then(|| DevicePoint {
            row: cy + fy * in_sensor.y / z,
            col: cx + fx * in_sensor.x / z,
            d3: z,
        })
    }

    fn plane_value(&self, pixel: Pixel, plane: &SensorPlane) -> Option<f64> {
        let depth = plane.offset / plane.normal.dot(&self.inside(pixel)?);
        (depth.is_finite() && depth > 0.0).then_some(depth)
    }

    /// The eight corners of the frustum: the volume is their convex hull.
    fn extent(&self, direction: &Vector3, nearest: f64, farthest: f64) -> (f64, f64) {
        let (last_row, last_col) = (self.size.rows as f64 - 1.0, self.size.cols as f64 - 1.0);
        let mut extremes = (f64::INFINITY, f64::NEG_INFINITY);
        for (row, col) in [(0.0, 0.0), (0.0, last_col), (last_row, 0.0), (last_row, last_col)] {
            let per_depth = direction.dot(&self.ray_at_depth_one(row, col));
            for value in [per_depth * nearest, per_depth * farthest] {
                extremes = (value.min(extremes.0), value.max(extremes.1));
            }
        }
        extremes
    }

    fn form_row(&self, image: &RangeImage, row: usize, form: &LinearForm, out: &mut [f32]) {
        let first = form.gradient.dot(&self.ray_at_depth_one(row as f64, 0.0));
        let per_column = form.gradient.x / self.intrinsics.fx;
        for (col, (value, &depth)) in out.iter_mut().zip(image.row(row)).enumerate() {
            let per_depth = first + per_column * col as f64;
            *value = (f64::from(depth) * per_depth + form.constant) as f32;
        }
    }
}
