//! Imaging radar: two scanning angles and a range (dissertation, section 4.2, ERIM).
//!
//! ```text
//!        z                 x = r cos φ cos θ      (4.1)
//!        |   . P           y = r cos φ sin θ      (4.2)
//!        | r/              z = r sin φ            (4.3)
//!        | / φ
//!        |/______ y        row i    ↔ φ = φ₀ + i Δφ   (nodding mirror)
//!       / θ                column j ↔ θ = θ₀ + j Δθ   (polygon mirror)
//!      x
//! ```
//!
//! Axes: right-handed, z up when φ is the elevation. `d3` is the range `r` from the sensor, in the
//! model's length unit; rays all start at the origin. Noise is an error of `r` along the ray.
//! Steps may be negative (a scan from top to bottom). Steps that fill a full circle in θ make the
//! last column a neighbour of the first.
//!
//! Departures from the source, after its errata: θ comes from `atan2` and is unwrapped into the
//! scan (Eq. 4.6 prints `asin`, which folds the rear half-space onto the front). The extent comes
//! from the rays, since the eleven planes of section 4.2.4 miss planes.

use crate::central::{central_extent, central_plane_value};
use crate::error::{SensorError, require};
use std::f64::consts::{FRAC_PI_2, TAU};
use transect_device::{
    DeviceFrame, DevicePoint, Handedness, ImageSize, LinearForm, Neighbour, Pixel, Point3,
    RangeImage, Ray, RayProduct, RayProducts, SensorPlane, SeparableForm, Vector3,
};

/// Equal angular steps: sample `k` looks along `first + k · step`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AngularScan {
    first: f64,
    step: f64,
}

impl AngularScan {
    /// Angles in radians.
    pub fn from_radians(first: f64, step: f64) -> Self {
        Self { first, step }
    }

    /// Angles in degrees.
    pub fn from_degrees(first: f64, step: f64) -> Self {
        Self { first: first.to_radians(), step: step.to_radians() }
    }

    /// Angle of sample `k`, in radians.
    pub fn angle(&self, k: usize) -> f64 {
        self.first + k as f64 * self.step
    }

    fn range(&self, count: usize) -> (f64, f64) {
        let (a, b) = (self.first, self.angle(count.saturating_sub(1)));
        (a.min(b), a.max(b))
    }

    fn table(&self, count: usize) -> Vec<SinCos> {
        (0..count).map(|k| SinCos::of(self.angle(k))).collect()
    }
}

#[derive(Debug, Clone, Copy)]
struct SinCos {
    sin: f64,
    cos: f64,
}

impl SinCos {
    fn of(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { sin, cos }
    }
}

/// The device frame of an imaging radar; see the module's page.
///
/// ```
/// use transect_device::{DeviceFrame, ImageSize, Pixel, Point3};
/// use transect_sensors::{AngularScan, ImagingRadar};
///
/// // Once round in steps of 1°, from 30° above the horizon downwards.
/// let (theta, phi) = (AngularScan::from_degrees(0.0, 1.0), AngularScan::from_degrees(30.0, -1.0));
/// let radar = ImagingRadar::new(ImageSize { rows: 61, cols: 360 }, theta, phi)?;
/// assert!(radar.columns_wrap());
/// let p = radar.point(Pixel::new(30, 90), 5.0).ok_or("no point")?;
/// assert!((p - Point3::new(0.0, 5.0, 0.0)).norm() < 1e-12, "level, along y");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct ImagingRadar {
    size: ImageSize,
    theta: AngularScan,
    phi: AngularScan,
    columns: Vec<SinCos>,
    rows: Vec<SinCos>,
}

impl ImagingRadar {
    /// A scanner with one column per step of `theta` and one row per step of `phi`.
    ///
    /// # Errors
    /// [`SensorError::BadParameter`] for angles that are not finite, zero steps, columns that cover
    /// more than a full circle, or rows outside ±90°.
    pub fn new(size: ImageSize, theta: AngularScan, phi: AngularScan) -> Result<Self, SensorError> {
        size.check()?;
        require("theta0", theta.first, true, "an angle")?;
        require("phi0", phi.first, true, "an angle")?;
        require("dtheta", theta.step, theta.step != 0.0, "a step other than 0")?;
        require("dphi", phi.step, phi.step != 0.0, "a step other than 0")?;
        let circle = theta.step.abs() * size.cols as f64;
        // A full circle given with few decimals may come out a little long.
        let fits = circle < TAU + 0.5 * theta.step.abs();
        require("dtheta", theta.step, fits, "columns within one full circle (angles in radians)")?;
        let (low, high) = phi.range(size.rows);
        let upright = low >= -FRAC_PI_2 - 1e-9 && high <= FRAC_PI_2 + 1e-9;
        require("phi0", phi.first, upright, "rows between -90° and 90° (angles in radians)")?;
        let (columns, rows) = (theta.table(size.cols), phi.table(size.rows));
        Ok(Self { size, theta, phi, columns, rows })
    }

    fn direction(&self, pixel: Pixel) -> Option<Vector3> {
        let (phi, theta) = (self.rows.get(pixel.row)?, self.columns.get(pixel.col)?);
        Some(Vector3::new(phi.cos * theta.cos, phi.cos * theta.sin, phi.sin))
    }

    /// The angle between a row's rays and their neighbours.
    fn angle_between(&self, phi: &SinCos, neighbour: Neighbour) -> SinCos {
        match neighbour {
            Neighbour::Up => SinCos::of(self.phi.step.abs()),
            Neighbour::Left => {
                let cos = phi.cos * phi.cos * self.theta.step.cos() + phi.sin * phi.sin;
                SinCos { cos, sin: (1.0 - cos * cos).max(0.0).sqrt() }
            }
        }
    }
}

impl DeviceFrame for ImagingRadar {
    fn size(&self) -> ImageSize {
        self.size
    }

    fn kind(&self) -> &'static str {
        "ImagingRadar"
    }

    fn handedness(&self) -> Handedness {
        // ∂ray/∂θ × ∂ray/∂φ is cos φ times the ray, so only the signs of the steps matter.
        Handedness::of(self.theta.step * self.phi.step)
    }

    fn columns_wrap(&self) -> bool {
        (self.theta.step.abs() * self.size.cols as f64 - TAU).abs() < 0.5 * self.theta.step.abs()
    }

    fn largest_angle(&self) -> Option<f64> {
        // The elevations are within ±90°.
        Some(self.theta.first)
    }

    fn ray(&self, pixel: Pixel) -> Option<Ray> {
        Some(Ray { start: Point3::origin(), direction: self.direction(pixel)? })
    }

    fn point(&self, pixel: Pixel, d3: f64) -> Option<Point3> {
        Some(Point3::from(self.direction(pixel)? * d3))
    }

    fn device_point(&self, in_sensor: &Point3) -> Option<DevicePoint> {
        let d3 = in_sensor.coords.norm();
        if !(d3.is_finite() && d3 > 0.0) {
            return None;
        }
        let phi = (in_sensor.z / d3).asin();
        let theta = in_sensor.y.atan2(in_sensor.x);
        let period = TAU / self.theta.step.abs();
        // Into the scan: from half a pixel before the first column on.
        let col = ((theta - self.theta.first) / self.theta.step + 0.5).rem_euclid(period) - 0.5;
        Some(DevicePoint { row: (phi - self.phi.first) / self.phi.step, col, d3 })
    }

    /// Eq. 4.7: `r = offset / (n · ray)`.
    fn plane_value(&self, pixel: Pixel, plane: &SensorPlane) -> Option<f64> {
        central_plane_value(&self.direction(pixel)?, plane)
    }

    /// Exact: cos φ is not negative, so the same two columns are extreme in every row.
    fn extent(&self, direction: &Vector3, nearest: f64, farthest: f64) -> (f64, f64) {
        let across = |t: &SinCos| direction.x * t.cos + direction.y * t.sin;
        let columns = || self.columns.iter().enumerate().map(|(col, t)| (across(t), col));
        let ends = [
            columns().min_by(|a, b| a.0.total_cmp(&b.0)),
            columns().max_by(|a, b| a.0.total_cmp(&b.0)),
        ];
        let pixel = |row| ends.into_iter().flatten().map(move |(_, col)| Pixel::new(row, col));
        let rays = (0..self.size.rows).flat_map(pixel).filter_map(|p| self.direction(p));
        central_extent(rays, direction, nearest, farthest)
    }

    fn form_row(&self, image: &RangeImage, row: usize, form: &LinearForm, out: &mut [f32]) {
        let Some(phi) = self.rows.get(row) else { return out.fill(f32::NAN) };
        let gradient = form.gradient;
        let (x, y, z) = (phi.cos * gradient.x, phi.cos * gradient.y, phi.sin * gradient.z);
        let samples = image.row(row).iter().zip(&self.columns);
        for (value, (&d3, theta)) in out.iter_mut().zip(samples) {
            let per_range = x * theta.cos + y * theta.sin + z;
            *value = (f64::from(d3) * per_range + form.constant) as f32;
        }
    }

    fn separable_form(&self, form: &LinearForm) -> Option<SeparableForm> {
        let LinearForm { gradient, constant } = form;
        let row = |phi: &SinCos| [phi.cos as f32, (gradient.z * phi.sin) as f32];
        let column = |theta: &SinCos| (gradient.x * theta.cos + gradient.y * theta.sin) as f32;
        Some(SeparableForm {
            rows: self.rows.iter().map(row).collect(),
            columns: self.columns.iter().map(column).collect(),
            constant: *constant as f32,
        })
    }

    fn ray_products(&self, neighbour: Neighbour) -> Option<RayProducts> {
        let product = |phi: &SinCos| {
            let angle = self.angle_between(phi, neighbour);
            RayProduct { here: 1.0, other: angle.cos as f32, across: angle.sin as f32 }
        };
        Some(RayProducts { rows: self.rows.iter().map(product).collect(), columns: Vec::new() })
    }
}
