//! The device frame of a sensor (dissertation, section 3.3): the trait every backend implements.

use crate::{
    ImageSize, PinholeScale, Pixel, Point3, RangeImage, RayProducts, SeparableForm, Vector3,
};
use std::sync::Arc;

/// The ray of one pixel in the sensor frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Start `P0`. With central projection, all rays have the same start.
    pub start: Point3,
    /// Unit direction, away from the sensor.
    pub direction: Vector3,
}

/// A point in device coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DevicePoint {
    /// First scanning variable in rows; whole numbers are pixel centres.
    pub row: f64,
    /// Second scanning variable in columns; whole numbers are pixel centres.
    pub col: f64,
    /// The range-related value.
    pub d3: f64,
}

/// The orientation of the image grid, seen from the sensor.
///
/// The sign of `(∂p/∂column × ∂p/∂row) · ray` for points `p` of one surface that faces the sensor.
/// Curve directions follow from it alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Handedness {
    /// Positive: seen from the sensor with rows running down, columns run to the right.
    ColumnsRight,
    /// Negative: the mirror image of that.
    ColumnsLeft,
}

impl Handedness {
    /// The orientation of a grid by that sign.
    pub fn of(turn: f64) -> Self {
        if turn > 0.0 { Self::ColumnsRight } else { Self::ColumnsLeft }
    }
}

/// An affine function of a sensor-frame point: `gradient · p + constant`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearForm {
    /// Change of the value per length unit along each sensor axis.
    pub gradient: Vector3,
    /// Value at the sensor frame's origin.
    pub constant: f64,
}

impl LinearForm {
    /// The value at a point.
    #[inline]
    pub fn at(&self, p: &Point3) -> f64 {
        self.gradient.dot(&p.coords) + self.constant
    }
}

/// A plane in the sensor frame: `normal · p = offset` with a unit normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorPlane {
    /// Unit normal.
    pub normal: Vector3,
    /// Signed distance of the plane from the sensor frame's origin, along the normal.
    pub offset: f64,
}

/// The second pixel of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Neighbour {
    /// The pixel in the same column of the row before.
    Up,
    /// The pixel in the same row of the column before (the last one for column 0 of a full circle).
    Left,
}

/// The offset between two neighbouring samples. Both numbers are NaN if either pixel is missing.
///
/// Their ratio is the tangent of the angle of incidence of a surface through both samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairGeometry {
    /// Distance between the samples along the ray, in the model's length unit; never negative.
    pub range_step: f32,
    /// Distance between the samples across the ray, in the model's length unit; never negative.
    pub lateral: f32,
}

impl PairGeometry {
    /// A pair with a missing pixel.
    pub const MISSING: Self = Self { range_step: f32::NAN, lateral: f32::NAN };

    /// The geometry of two samples, seen along the unit direction of the first one's ray.
    #[inline]
    pub fn between(a: &Point3, b: &Point3, ray: &Vector3) -> Self {
        let d = b - a;
        let along = d.dot(ray);
        let lateral = (d - ray * along).norm();
        Self { range_step: along.abs() as f32, lateral: lateral as f32 }
    }
}

/// A sensor's grid of rays and the scale on them, in the sensor's own Cartesian frame.
///
/// The required methods work on one pixel. The `*_row` methods have defaults that call them. A
/// backend may override the defaults for speed; its tests then compare both.
///
/// A backend documents its axes, handedness, pixel centre, unit, missing value, the meaning of its
/// noise, and its equations.
///
/// A camera with parallel rays along z, one per unit of x and y:
///
/// ```
/// use transect_device::{
///     DeviceFrame, DevicePoint, Handedness, ImageSize, Pixel, Point3, Ray, SensorPlane, Vector3,
/// };
///
/// #[derive(Debug)]
/// struct Parallel(ImageSize);
///
/// impl DeviceFrame for Parallel {
///     fn size(&self) -> ImageSize {
///         self.0
///     }
///     fn kind(&self) -> &'static str {
///         "Parallel"
///     }
///     fn handedness(&self) -> Handedness {
///         Handedness::ColumnsRight
///     }
///     fn ray(&self, pixel: Pixel) -> Option<Ray> {
///         let start = Point3::new(pixel.col as f64, pixel.row as f64, 0.0);
///         let inside = pixel.row < self.0.rows && pixel.col < self.0.cols;
///         inside.then_some(Ray { start, direction: Vector3::z() })
///     }
///     fn point(&self, pixel: Pixel, d3: f64) -> Option<Point3> {
///         self.ray(pixel).map(|ray| ray.start + ray.direction * d3)
///     }
///     fn device_point(&self, p: &Point3) -> Option<DevicePoint> {
///         (p.z > 0.0).then_some(DevicePoint { row: p.y, col: p.x, d3: p.z })
///     }
///     fn plane_value(&self, pixel: Pixel, plane: &SensorPlane) -> Option<f64> {
///         let start = self.ray(pixel)?.start;
///         let d3 = (plane.offset - plane.normal.dot(&start.coords)) / plane.normal.z;
///         (d3.is_finite() && d3 > 0.0).then_some(d3)
///     }
///     fn extent(&self, direction: &Vector3, nearest: f64, farthest: f64) -> (f64, f64) {
///         // Wider than needed: a ball around the origin that holds all points.
///         let reach = farthest.max(nearest) + (self.0.rows + self.0.cols) as f64;
///         (-reach * direction.norm(), reach * direction.norm())
///     }
/// }
///
/// let frame = Parallel(ImageSize { rows: 3, cols: 4 });
/// let p = frame.point(Pixel::new(1, 2), 5.0).ok_or("no point")?;
/// assert_eq!(p, Point3::new(2.0, 1.0, 5.0));
/// let wall = SensorPlane { normal: Vector3::z(), offset: 5.0 };
/// assert_eq!(frame.plane_value(Pixel::new(1, 2), &wall), Some(5.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait DeviceFrame: std::fmt::Debug + Send + Sync {
    /// Rows and columns of the frame's images.
    fn size(&self) -> ImageSize;

    /// The kind of sensor, for lists of views: a word such as the name of its type. Model stores
    /// keep it, so it must not change from version to version.
    fn kind(&self) -> &'static str;

    /// The orientation of the grid, seen from the sensor.
    fn handedness(&self) -> Handedness;

    /// Whether the last column's right neighbour is column 0 (a full circle).
    fn columns_wrap(&self) -> bool {
        false
    }

    /// The largest angle among the sensor's parameters, in radians, for a check of its unit; `None`
    /// without angles whose range the sensor leaves open.
    fn largest_angle(&self) -> Option<f64> {
        None
    }

    /// The length that pixels hold, of a camera whose files may hold another one; `None` of other
    /// sensors.
    fn pinhole_scale(&self) -> Option<PinholeScale> {
        None
    }

    /// The ray of a pixel; `None` outside the image, or where the sensor has no ray.
    fn ray(&self, pixel: Pixel) -> Option<Ray>;

    /// The point from which the sensor sees a pixel's ray, if that is not the ray's start.
    ///
    /// A triangulation sensor lights a spot along one path and sees it along another. Both paths
    /// must be free. `None` for sensors whose light returns along the ray.
    fn second_viewpoint(&self, _pixel: Pixel) -> Option<Point3> {
        None
    }

    /// `f`: the sensor-frame point of a value at a pixel; `None` if the value has no point.
    fn point(&self, pixel: Pixel, d3: f64) -> Option<Point3>;

    /// `F`: the device coordinates of a sensor-frame point, which may lie between pixels or
    /// outside the image; `None` where the sensor cannot see, or if the frame has no inverse.
    fn device_point(&self, in_sensor: &Point3) -> Option<DevicePoint>;

    /// The value a plane would have at a pixel; `None` if the pixel's ray misses it.
    fn plane_value(&self, pixel: Pixel, plane: &SensorPlane) -> Option<f64>;

    /// Bounds of `direction · p` over the points of an image of this frame whose values run from
    /// `nearest` to `farthest`.
    ///
    /// Conservative: no such point lies outside them (dissertation, section 4.2.4). The caller
    /// derives from them which section planes a view can involve.
    fn extent(&self, direction: &Vector3, nearest: f64, farthest: f64) -> (f64, f64);

    /// The frame of every other row and column, from row 0 and column 0 on: its pixel `(i, j)` is
    /// `(2 i, 2 j)` of this one. `None` if the sensor has no such frame.
    fn halved(&self) -> Option<Arc<dyn DeviceFrame>> {
        None
    }

    /// The form's value at every pixel of a row, NaN where missing.
    ///
    /// `out` has one place per column. Values are rounded to `f32` at the end only.
    fn form_row(&self, image: &RangeImage, row: usize, form: &LinearForm, out: &mut [f32]) {
        for (col, (value, &d3)) in out.iter_mut().zip(image.row(row)).enumerate() {
            let point = some_value(d3).and_then(|d3| self.point(Pixel::new(row, col), d3));
            *value = point.map_or(f32::NAN, |p| form.at(&p) as f32);
        }
    }

    /// The geometry of every pixel of a row and its neighbour; missing where there is no neighbour.
    fn pair_row(
        &self,
        image: &RangeImage,
        row: usize,
        neighbour: Neighbour,
        out: &mut [PairGeometry],
    ) {
        for (col, pair) in out.iter_mut().enumerate() {
            let pixel = Pixel::new(row, col);
            let other = self.neighbour(pixel, neighbour);
            *pair = other.and_then(|o| self.pair(image, pixel, o)).unwrap_or(PairGeometry::MISSING);
        }
    }

    /// A linear form of this sensor's samples as products of row and column numbers; `None` if the
    /// form has no such products. With them, whole images are computed in `f32` without a call per
    /// row.
    fn separable_form(&self, _form: &LinearForm) -> Option<SeparableForm> {
        None
    }

    /// Products of neighbouring rays as sums of row and column numbers; `None` if the sensor has no
    /// such sums. With them, pairs of whole images are tested in `f32` without a call per row.
    fn ray_products(&self, _neighbour: Neighbour) -> Option<RayProducts> {
        None
    }

    /// The geometry of two samples; `None` if either is missing.
    fn pair(&self, image: &RangeImage, pixel: Pixel, other: Pixel) -> Option<PairGeometry> {
        let a = self.point(pixel, f64::from(image.get(pixel)?))?;
        let b = self.point(other, f64::from(image.get(other)?))?;
        Some(PairGeometry::between(&a, &b, &self.ray(pixel)?.direction))
    }

    /// The neighbouring pixel, across the seam of a full circle if there is one.
    fn neighbour(&self, pixel: Pixel, neighbour: Neighbour) -> Option<Pixel> {
        let Pixel { row, col } = pixel;
        match neighbour {
            Neighbour::Up => row.checked_sub(1).map(|row| Pixel { row, col }),
            Neighbour::Left if col == 0 && self.columns_wrap() => {
                Some(Pixel { row, col: self.size().cols.checked_sub(1)? })
            }
            Neighbour::Left => col.checked_sub(1).map(|col| Pixel { row, col }),
        }
    }
}

fn some_value(d3: f32) -> Option<f64> {
    (!d3.is_nan()).then_some(f64::from(d3))
}
