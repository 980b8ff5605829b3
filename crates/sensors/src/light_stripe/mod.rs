//! Light stripe: a laser sheet turned by a mirror, watched by a camera (dissertation, sections 4.3
//! and 4.6, SmartEye).
//!
//! ```text
//!                      P                 seen from above; Y points out of the page
//!                     /  \
//!   Z                /     \             laser sheet  z = tan θ (x + B_b)           (4.15)
//!   |    laser sheet/        \ seen      row plane    f y + y_row z - y_row f = 0   (4.16)
//!   |              /           \
//!   |    ray: P0  +- - - - - - - F       F = (0, 0, f)  focal point, P0 = (f/tan θ - B_b, 0, f)
//!   |            / θ             : \
//!   O--> X  ====M================O===+=  camera array in the plane z = 0, image point at x_plane
//!               |<- B_b = B + b(θ) ->|
//! ```
//!
//! Axes: right-handed; X along the base line from laser to camera, Z into the scene, the camera's
//! focal point F on Z. Everything is in the model's length unit except image positions, which are
//! counted in camera cells, and angles, which are in radians.
//!
//! * **Row `i`** ↔ `y_frame`: the camera's row; whole numbers are the centres of its cells.
//! * **Column `j`** ↔ `θ_laser`: the `j`-th scanning angle, between X and the laser sheet.
//! * **`d3`** is `x_frame`, the place of the stripe along the camera's row, in cells **from the
//!   left edge of the array**. Cell `c` covers `c … c + 1` and its centre is at `c + 0.5`. So every
//!   place on the array is positive, as a range image requires. It grows with range.
//!
//! Equations: `x_plane = (x_center - x_frame) · cell_width` (4.8),
//! `y_plane = (y_center - y_frame) · cell_height` (4.9), `S` (4.10, errata) with
//! `φ = atan2(f, x_plane)` (4.11, errata), and `P = (1 - t)(x_plane, y_plane, 0) + t F` with
//! `t = S / √(x_plane² + f²)` (4.12–4.14). With the sines written out the root cancels, and per
//! column a base `k = B_b - f/tan θ` is all that is needed:
//!
//! ```text
//!   depth in front of F     w = f k / (x_plane + f / tan θ),   d3 = x_center - x_plane/cell_width
//!   point                   P = (-k, 0, f) + w (1/tan θ, -y_plane/f, 1)
//! ```
//!
//! The second line is the ray of a pixel: the line in which planes 4.15 and 4.16 meet. All rays of
//! a column start in one point P0 = (-k, 0, f), which is not the camera. A section plane meets that
//! line at some `w`, hence the plane value; the inverse F solves 4.15 for θ.
//!
//! * **Mirror**: the laser runs along X towards the camera and meets a mirror whose axis lies `g`
//!   behind it at x = -B and whose face is `R` from that axis. At `θ_m = θ/2` the spot is at
//!   x = -(B + b), `b = (R - g cos θ_m) / sin θ_m` (4.3.2, errata).
//! * **Monotone** in range when `B_b sin θ > f cos θ` (4.3.3, errata), that is `k > 0`: checked for
//!   every column when built. So is that no two sheets cross where the camera sees them, or a point
//!   would have several angles.
//! * **Missing** (no point, no value): rays that do not converge, `sin(θ + φ) <= 0` (errata);
//!   points beyond [`LightStripeParameters::farthest`]; points outside the fan of the line lens.
//! * **Handedness**: the image is upside down and mirrored, as in any camera without a second
//!   lens. With angles that increase, rays turn towards -X from column to column and towards +Y
//!   from row to row: [`Handedness::ColumnsLeft`]; with angles that decrease, the other one.
//! * **Noise** is an error of `d3`: of where the stripe is found in its row, in cells. Along the
//!   ray a cell is worth `w² · cell_width / (f k)` of depth: it grows with the square of the range.
//!
//! Departures from the source: `x_frame` is counted from the array's edge. The angles are a table,
//! not necessarily equal steps. Samples end at a farthest depth and at the edge of the fan, whose
//! apex is taken to be the spot on the mirror. Light really starts there and not in P0; the two are
//! `f / sin θ` apart, which only matters for objects between the laser and a point.
//!
//! [`stripe`] finds the stripe in the camera's intensity images.

mod angles;
mod parameters;
pub mod stripe;
#[cfg(test)]
mod tests;

pub use angles::LaserAngles;
pub use parameters::LightStripeParameters;

use crate::SensorError;
use transect_device::{
    DeviceFrame, DevicePoint, Handedness, ImageSize, Pixel, Point3, Ray, SensorPlane, Vector3,
};

/// The laser sheet of a column, which all its pixels share.
#[derive(Debug, Clone, Copy)]
struct Sheet {
    sin: f64,
    /// 1 / tan θ.
    cot: f64,
    /// `k = B_b - f / tan θ`: the distance of the ray's start P0 from the focal point.
    base: f64,
}

/// The device frame of a light-stripe range finder; see the module's page.
///
/// ```
/// use transect_device::{DeviceFrame, Pixel};
/// use transect_sensors::LightStripe;
///
/// let frame = LightStripe::smart_eye()?; // millimetres
/// // The stripe of laser angle 100 in the camera's row 247, in the middle of the array.
/// let p = frame.point(Pixel::new(247, 100), 384.0).ok_or("no point")?;
/// assert!(p.x.abs() < 1e-9 && (p.z - 735.2).abs() < 0.1, "straight ahead: {p}");
/// let d = frame.device_point(&p).ok_or("not seen")?;
/// assert!((d.d3 - 384.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct LightStripe {
    parameters: LightStripeParameters,
    sheets: Vec<Sheet>,
    /// Half the fan's opening, as a tangent.
    fan: f64,
}

impl LightStripe {
    /// A range finder with one column per laser angle and one row per camera row.
    ///
    /// # Errors
    /// [`SensorError::BadParameter`] naming the key. Refused are lengths that are not positive,
    /// angles that are unsorted or not between 0° and 180°, and a base line under which `x_frame`
    /// is not monotone in range. So are sheets that the camera never sees before the farthest
    /// depth, or that cross where it does.
    pub fn new(parameters: LightStripeParameters) -> Result<Self, SensorError> {
        parameters.check()?;
        let sheets = parameters.theta_laser.as_radians().iter().map(|&theta| Sheet {
            sin: theta.sin(),
            cot: theta.cos() / theta.sin(),
            base: parameters.base_line(theta) - parameters.focal_length * theta.cos() / theta.sin(),
        });
        let frame =
            Self { sheets: sheets.collect(), fan: (parameters.fan_angle / 2.0).tan(), parameters };
        frame.check_columns()?;
        Ok(frame)
    }

    /// The dissertation's range finder, **in millimetres**; see
    /// [`LightStripeParameters::smart_eye`].
    ///
    /// # Errors
    /// None in practice; the parameters are checked like any others.
    pub fn smart_eye() -> Result<Self, SensorError> {
        Self::new(LightStripeParameters::smart_eye())
    }

    /// The parameters of the range finder.
    pub fn parameters(&self) -> &LightStripeParameters {
        &self.parameters
    }

    /// The camera's focal point, through which it sees everything.
    fn focal_point(&self) -> Point3 {
        Point3::new(0.0, 0.0, self.parameters.focal_length)
    }

    /// Checks every column; see the module's page.
    fn check_columns(&self) -> Result<(), SensorError> {
        let angles = self.parameters.theta_laser.as_radians();
        let bad = |key, value, wanted| Err(SensorError::BadParameter { key, value, wanted });
        // How far from F each sheet meets the first ray of sight, where sheets lie closest.
        let mut nearest: Option<f64> = None;
        let ascending = self.parameters.theta_laser.ascending();
        let limit = self.parameters.farthest - self.parameters.focal_length;
        for (sheet, &theta) in self.sheets.iter().zip(angles) {
            if sheet.base <= 0.0 {
                let base_line = self.parameters.base_line(theta);
                return bad("baseline", base_line, "more than f / tan θ at every laser angle");
            }
            let met = self.depth(sheet, self.x_plane(0.0)).filter(|d| *d <= limit);
            let Some(depth) = met else {
                return bad("theta_laser", theta, "laser sheets that cross the camera's field");
            };
            if nearest.is_some_and(|before| (depth > before) != ascending) {
                let wanted = "a mirror whose laser sheets do not cross in the camera's field";
                return bad("mirror_face", self.parameters.mirror_face, wanted);
            }
            nearest = Some(depth);
        }
        Ok(())
    }

    /// Eq. 4.8.
    fn x_plane(&self, x_frame: f64) -> f64 {
        (self.parameters.x_center - x_frame) * self.parameters.cell_width
    }

    /// Eq. 4.8, solved for `x_frame`.
    fn x_frame(&self, x_plane: f64) -> f64 {
        self.parameters.x_center - x_plane / self.parameters.cell_width
    }

    /// Eq. 4.9.
    fn y_plane(&self, y_frame: f64) -> f64 {
        (self.parameters.y_center - y_frame) * self.parameters.cell_height
    }

    /// Depth in front of the focal point; `None` unless laser and line of sight converge.
    ///
    /// Eq. 4.10–4.14 (errata): `sin(θ + φ)` has the sign of `x_plane + f / tan θ`.
    fn depth(&self, sheet: &Sheet, x_plane: f64) -> Option<f64> {
        let f = self.parameters.focal_length;
        let closing = x_plane + f * sheet.cot;
        (closing > 0.0).then(|| f * sheet.base / closing)
    }

    /// The largest depth in front of the focal point at which the laser lights a row's ray.
    ///
    /// Light reaches as far from the ray's middle as the fan opens: `|y| sin θ <= fan · z`.
    fn reach(&self, sheet: &Sheet, y_plane: f64) -> f64 {
        let f = self.parameters.focal_length;
        let limit = self.parameters.farthest - f;
        let outwards = y_plane.abs() / f * sheet.sin - self.fan;
        if outwards > 0.0 { limit.min(self.fan * f / outwards) } else { limit }
    }

    fn start(&self, sheet: &Sheet) -> Point3 {
        Point3::new(-sheet.base, 0.0, self.parameters.focal_length)
    }

    /// The ray's direction, per unit of depth.
    fn per_depth(&self, sheet: &Sheet, y_plane: f64) -> Vector3 {
        Vector3::new(sheet.cot, -y_plane / self.parameters.focal_length, 1.0)
    }

    fn sheet_and_y(&self, pixel: Pixel) -> Option<(&Sheet, f64)> {
        let inside = pixel.row < self.parameters.camera_rows;
        let sheet = self.sheets.get(pixel.col).filter(|_| inside)?;
        Some((sheet, self.y_plane(pixel.row as f64)))
    }
}

impl DeviceFrame for LightStripe {
    fn size(&self) -> ImageSize {
        ImageSize { rows: self.parameters.camera_rows, cols: self.sheets.len() }
    }

    fn kind(&self) -> &'static str {
        "LightStripe"
    }

    fn handedness(&self) -> Handedness {
        // ∂ray/∂θ = (-1/sin²θ, 0, 0) and ∂ray/∂row = (0, cell_height/f, 0): turned against z.
        Handedness::of(if self.parameters.theta_laser.ascending() { -1.0 } else { 1.0 })
    }

    fn ray(&self, pixel: Pixel) -> Option<Ray> {
        let (sheet, y_plane) = self.sheet_and_y(pixel)?;
        let direction = self.per_depth(sheet, y_plane).normalize();
        Some(Ray { start: self.start(sheet), direction })
    }

    /// The camera's focal point.
    fn second_viewpoint(&self, pixel: Pixel) -> Option<Point3> {
        self.sheet_and_y(pixel).map(|_| self.focal_point())
    }

    fn point(&self, pixel: Pixel, d3: f64) -> Option<Point3> {
        let (sheet, y_plane) = self.sheet_and_y(pixel)?;
        let depth = self.depth(sheet, self.x_plane(d3))?;
        let lit = depth <= self.reach(sheet, y_plane);
        lit.then(|| self.start(sheet) + self.per_depth(sheet, y_plane) * depth)
    }

    /// `None` also where the point's image falls beside the array on its left or right, and more
    /// than half a column outside the scanned angles.
    fn device_point(&self, in_sensor: &Point3) -> Option<DevicePoint> {
        let p = &self.parameters;
        let depth = in_sensor.z - p.focal_length;
        if !(in_sensor.coords.iter().all(|c| c.is_finite()) && depth > 0.0) {
            return None;
        }
        // The line of sight through F meets the array at z = 0.
        let x_plane = -in_sensor.x * p.focal_length / depth;
        let y_plane = -in_sensor.y * p.focal_length / depth;
        let d3 = self.x_frame(x_plane);
        let theta = p.theta_at(in_sensor)?;
        let col = p.theta_laser.column(theta)?;
        let lit =
            in_sensor.z <= p.farthest && in_sensor.y.abs() * theta.sin() <= self.fan * in_sensor.z;
        let seen = lit && d3 > 0.0 && d3 <= p.camera_cols as f64;
        seen.then(|| DevicePoint { row: p.y_center - y_plane / p.cell_height, col, d3 })
    }

    /// From three planes: the section plane, the laser sheet (4.15) and the row plane (4.16).
    ///
    /// A plane too near for the camera's field has a value of 0 or less, so that it still counts as
    /// nearer than every sample. One too far for it, or met where there is no light, has none.
    fn plane_value(&self, pixel: Pixel, plane: &SensorPlane) -> Option<f64> {
        let (sheet, y_plane) = self.sheet_and_y(pixel)?;
        let ahead = plane.offset - plane.normal.dot(&self.start(sheet).coords);
        let depth = ahead / plane.normal.dot(&self.per_depth(sheet, y_plane));
        if !(depth > 0.0 && depth <= self.reach(sheet, y_plane)) {
            return None;
        }
        let f = self.parameters.focal_length;
        let value = self.x_frame(f * sheet.base / depth - f * sheet.cot);
        (value.is_finite() && value <= self.parameters.camera_cols as f64).then_some(value)
    }

    /// The corners of every column's part of the truncated prism (4.3.3).
    ///
    /// Exact except for the fan: these are the corners of the trapezoid that a column's points
    /// fill. Infinite if [`LightStripeParameters::farthest`] is infinite and a column has no other
    /// limit.
    fn extent(&self, direction: &Vector3, nearest: f64, farthest: f64) -> (f64, f64) {
        let p = &self.parameters;
        let limit = p.farthest - p.focal_length;
        let last_row = p.camera_rows as f64 - 1.0;
        let mut extremes = (f64::INFINITY, f64::NEG_INFINITY);
        for sheet in &self.sheets {
            let Some(near) = self.depth(sheet, self.x_plane(nearest)).filter(|n| *n <= limit)
            else {
                continue;
            };
            let far = self.depth(sheet, self.x_plane(farthest)).unwrap_or(limit).min(limit);
            let start = direction.dot(&self.start(sheet).coords);
            for row in [0.0, last_row] {
                let slope = direction.dot(&self.per_depth(sheet, self.y_plane(row)));
                for depth in [near, far] {
                    let way = if slope == 0.0 { 0.0 } else { slope * depth };
                    extremes = (extremes.0.min(start + way), extremes.1.max(start + way));
                }
            }
        }
        extremes
    }
}
