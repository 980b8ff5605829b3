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
//! or the length of the ray, see [`PinholeScale`], in the model's length unit; all rays start at
//! the origin. Pixel `(i, j)` is sampled at its centre, `(cx, cy)` in the same counting. Missing
//! pixels are missing values. Noise is an error along the ray.
//!
//! A lens that bends rays is a [`RayTable`]: one unit ray per pixel in the same frame.

mod ray_table;

pub use ray_table::RayTable;

use crate::central::{central_extent, central_plane_value};
use crate::error::{SensorError, require};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use transect_device::{
    DeviceFrame, DevicePoint, Handedness, ImageSize, LinearForm, Neighbour, PinholeScale, Pixel,
    Point3, RangeImage, Ray, RayProduct, RayProducts, SensorPlane, SeparableForm, Vector3,
};

/// Focal lengths and principal point, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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
///
/// ```
/// use transect_device::{DeviceFrame, ImageSize, Pixel, Point3};
/// use transect_sensors::{Intrinsics, Pinhole};
///
/// let intrinsics = Intrinsics { fx: 500.0, fy: 500.0, cx: 319.5, cy: 239.5 };
/// let camera = Pinhole::new(ImageSize { rows: 480, cols: 640 }, intrinsics)?;
/// let seen = camera.device_point(&Point3::new(0.1, 0.0, 2.0)).ok_or("not seen")?;
/// assert_eq!((seen.row, seen.col, seen.d3), (239.5, 319.5 + 25.0, 2.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Pinhole {
    size: ImageSize,
    intrinsics: Intrinsics,
    scale: PinholeScale,
}

impl Pinhole {
    /// A camera without lens distortion whose values are depths.
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
        Ok(Self { size, intrinsics, scale: PinholeScale::Depth })
    }

    /// The same camera, with another meaning of its values.
    #[must_use]
    pub fn with_scale(self, scale: PinholeScale) -> Self {
        Self { scale, ..self }
    }

    /// The pixel's ray, scaled to depth 1.
    fn ray_at_depth_one(&self, row: f64, col: f64) -> Vector3 {
        let Intrinsics { fx, fy, cx, cy } = self.intrinsics;
        Vector3::new((col - cx) / fx, (row - cy) / fy, 1.0)
    }

    /// The pixel's ray, scaled to value 1.
    fn inside(&self, pixel: Pixel) -> Option<Vector3> {
        self.size.index(pixel)?;
        Some(self.scale.per_value(self.ray_at_depth_one(pixel.row as f64, pixel.col as f64)))
    }
}

impl DeviceFrame for Pinhole {
    fn size(&self) -> ImageSize {
        self.size
    }

    fn kind(&self) -> &'static str {
        "Pinhole"
    }

    fn handedness(&self) -> Handedness {
        Handedness::ColumnsRight
    }

    fn pinhole_scale(&self) -> Option<PinholeScale> {
        Some(self.scale)
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
            d3: self.scale.value(in_sensor),
        })
    }

    fn plane_value(&self, pixel: Pixel, plane: &SensorPlane) -> Option<f64> {
        central_plane_value(&self.inside(pixel)?, plane)
    }

    fn halved(&self) -> Option<Arc<dyn DeviceFrame>> {
        let Intrinsics { fx, fy, cx, cy } = self.intrinsics;
        let [fx, fy, cx, cy] = [fx, fy, cx, cy].map(|pixels| pixels / 2.0);
        let intrinsics = Intrinsics { fx, fy, cx, cy };
        Some(Arc::new(Self { size: self.size.halved(), intrinsics, ..*self }))
    }

    /// Exact. Rays of depth 1 fill a rectangle, whose corners are extreme; those of length 1 bulge.
    fn extent(&self, direction: &Vector3, nearest: f64, farthest: f64) -> (f64, f64) {
        let (last_row, last_col) = (self.size.rows - 1, self.size.cols - 1);
        let steps = match self.scale {
            PinholeScale::Depth => (last_row.max(1), last_col.max(1)),
            PinholeScale::RayLength => (1, 1),
        };
        let columns = |row| (0..=last_col).step_by(steps.1).map(move |col| Pixel::new(row, col));
        let pixels = (0..=last_row).step_by(steps.0).flat_map(columns);
        central_extent(pixels.filter_map(|p| self.inside(p)), direction, nearest, farthest)
    }

    fn form_row(&self, image: &RangeImage, row: usize, form: &LinearForm, out: &mut [f32]) {
        let first = self.ray_at_depth_one(row as f64, 0.0);
        for (col, (value, &d3)) in out.iter_mut().zip(image.row(row)).enumerate() {
            let ray = Vector3::new(first.x + col as f64 / self.intrinsics.fx, first.y, 1.0);
            let per_value = form.gradient.dot(&self.scale.per_value(ray));
            *value = (f64::from(d3) * per_value + form.constant) as f32;
        }
    }

    fn separable_form(&self, form: &LinearForm) -> Option<SeparableForm> {
        if self.scale == PinholeScale::RayLength {
            return None;
        }
        let LinearForm { gradient, constant } = form;
        let ray = |row: usize, col: usize| self.ray_at_depth_one(row as f64, col as f64);
        let row = |i| [1.0, (gradient.y * ray(i, 0).y + gradient.z) as f32];
        Some(SeparableForm {
            rows: (0..self.size.rows).map(row).collect(),
            columns: (0..self.size.cols).map(|j| (gradient.x * ray(0, j).x) as f32).collect(),
            constant: *constant as f32,
        })
    }

    /// With rays `(x, y, 1)`: `a · a = (1 + y²) + x²`; a neighbour differs by one pixel in x or y.
    fn ray_products(&self, neighbour: Neighbour) -> Option<RayProducts> {
        if self.scale == PinholeScale::RayLength {
            return None;
        }
        let Intrinsics { fx, fy, .. } = self.intrinsics;
        let left = neighbour == Neighbour::Left;
        let product = |here: f64, less: f64, across: f64| RayProduct {
            here: here as f32,
            other: (here - less) as f32,
            across: across as f32,
        };
        let row = |i: usize| {
            let y = self.ray_at_depth_one(i as f64, 0.0).y;
            let here = 1.0 + y * y;
            if left { product(here, 0.0, here.sqrt() / fx) } else { product(here, y / fy, 0.0) }
        };
        let column = |j: usize| {
            let x = self.ray_at_depth_one(0.0, j as f64).x;
            let across = (1.0 + x * x).sqrt() / fy;
            if left { product(x * x, x / fx, 0.0) } else { product(x * x, 0.0, across) }
        };
        Some(RayProducts {
            rows: (0..self.size.rows).map(row).collect(),
            columns: (0..self.size.cols).map(column).collect(),
        })
    }
}
