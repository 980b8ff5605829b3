//! The parameters of a light-stripe range finder, and those of the dissertation's own.

use super::LaserAngles;
use crate::error::{SensorError, require};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use transect_device::{ImageSize, Point3};

/// Newton steps for a scanning angle; each halves the interval at least, and five are usual.
const MAX_STEPS: usize = 80;

/// Parameters of a light-stripe range finder.
///
/// # Units
/// Lengths in the model's unit, angles in radians, image positions in camera cells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LightStripeParameters {
    /// Rows of the camera, which are the range image's.
    pub camera_rows: usize,
    /// Columns of the camera. The range image has a column per laser angle.
    pub camera_cols: usize,
    /// `f`: distance of the focal point from the array; a length.
    pub focal_length: f64,
    /// `aspect_ratio_x`: from one cell to the next along a row; a length.
    pub cell_width: f64,
    /// `aspect_ratio_y`: from one row to the next; a length.
    pub cell_height: f64,
    /// Place where the optical axis meets the row, in cells **from the array's left edge**, like
    /// `d3`: half the number of columns for a centred lens.
    pub x_center: f64,
    /// Row of the optical axis; whole numbers are the centres of rows, so (rows − 1)/2 for a
    /// centred lens.
    pub y_center: f64,
    /// `B`: distance along X from the mirror's axis to the focal point; a length.
    pub baseline: f64,
    /// `g`: distance of the mirror's axis from the laser's axis; a length, positive when the
    /// mirror's axis lies behind the laser beam as seen from the scene.
    #[serde(default)]
    pub mirror_axis: f64,
    /// `R`: distance of the mirror's face from its axis; a length. 0 with `mirror_axis` 0 for a
    /// sheet that turns about a fixed line.
    #[serde(default)]
    pub mirror_face: f64,
    /// Full opening angle of the line lens; radians, under π.
    pub fan_angle: f64,
    /// Largest z at which the stripe is bright enough to be found; a length, or infinite.
    #[serde(default = "unlimited", skip_serializing_if = "is_unlimited")]
    pub farthest: f64,
    /// `θ_laser` of every column. Files state the angles in several forms, so it is not among the
    /// serialized fields.
    #[serde(skip)]
    pub theta_laser: LaserAngles,
}

/// No largest depth. Infinity is not a number in JSON, so files leave the field out.
fn unlimited() -> f64 {
    f64::INFINITY
}

fn is_unlimited(depth: &f64) -> bool {
    *depth == f64::INFINITY
}

impl LightStripeParameters {
    /// The dissertation's range finder (4.6.1), **in millimetres**.
    ///
    /// From the text: a camera of 768 × 494 cells (PULNiX TM-7), a line lens of 60°, a motor with
    /// 200 steps per revolution behind a transmission, hence 200 columns.
    ///
    /// Chosen here, because the text gives no number or calls it "estimated":
    ///
    /// | value | reason |
    /// |---|---|
    /// | cells of 8.4 µm × 9.8 µm | the cells of a half-inch array of that size |
    /// | f = 16 mm | a field of 23° × 17°: 275 mm × 205 mm at a depth of 700 mm, a face mask |
    /// | B = 300 mm | triangulation angle of 24° at that depth, one cell is 0.8 mm of depth |
    /// | R = 20 mm, g = 16 mm | the beam stays within 4 mm of the middle of a small mirror's face |
    /// | θ from 58° in steps of 0.09° | a 1.8° step geared 40 : 1, doubled by the mirror; 18° cover 260 mm of the field at 700 mm, and every cell's line of sight meets every sheet |
    /// | farthest 2000 mm | three times the working depth; a 5 mW line is lost in daylight there |
    pub fn smart_eye() -> Self {
        Self {
            camera_rows: 494,
            camera_cols: 768,
            focal_length: 16.0,
            cell_width: 0.0084,
            cell_height: 0.0098,
            x_center: 384.0,
            y_center: 246.5,
            baseline: 300.0,
            mirror_axis: 16.0,
            mirror_face: 20.0,
            fan_angle: PI / 3.0,
            farthest: 2000.0,
            theta_laser: LaserAngles::equal_steps_degrees(58.0, 0.09, 200),
        }
    }

    /// The same instrument in another length unit, or a smaller or larger one of the same shape:
    /// every length times `factor`. Angles and image positions stay.
    ///
    /// ```
    /// use transect_sensors::LightStripeParameters;
    ///
    /// let in_metres = LightStripeParameters::smart_eye().scaled(0.001);
    /// assert!((in_metres.focal_length - 0.016).abs() < 1e-12);
    /// ```
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            focal_length: self.focal_length * factor,
            cell_width: self.cell_width * factor,
            cell_height: self.cell_height * factor,
            baseline: self.baseline * factor,
            mirror_axis: self.mirror_axis * factor,
            mirror_face: self.mirror_face * factor,
            farthest: self.farthest * factor,
            ..self
        }
    }

    /// Rows and columns of the camera.
    pub fn camera(&self) -> ImageSize {
        ImageSize { rows: self.camera_rows, cols: self.camera_cols }
    }

    /// `B_b = B + b(θ)`: from the laser's spot on the mirror to the focal point, along X.
    ///
    /// 4.3.2 (errata): `b = (R - g cos θ_m) / sin θ_m` with the mirror at `θ_m = θ/2`.
    pub fn base_line(&self, theta: f64) -> f64 {
        let (sin, cos) = (theta / 2.0).sin_cos();
        self.baseline + (self.mirror_face - self.mirror_axis * cos) / sin
    }

    /// Checks each value by itself.
    pub(super) fn check(&self) -> Result<(), SensorError> {
        let length = |key, value: f64| require(key, value, value > 0.0, "a positive length");
        length("focal_length", self.focal_length)?;
        length("cell_width", self.cell_width)?;
        length("cell_height", self.cell_height)?;
        require("x_center", self.x_center, true, "a place along the camera's rows")?;
        require("y_center", self.y_center, true, "a camera row")?;
        require("baseline", self.baseline, true, "a length")?;
        require("mirror_axis", self.mirror_axis, true, "a length")?;
        let mirror = self.mirror_face;
        require("mirror_face", mirror, mirror >= 0.0, "a length of at least 0")?;
        let opens = self.fan_angle > 0.0 && self.fan_angle < PI;
        require("fan_angle", self.fan_angle, opens, "an angle between 0 and π, in radians")?;
        let (rows, cols) = (self.camera_rows as f64, self.camera_cols as f64);
        require("camera_rows", rows, rows > 0.0, "at least one row")?;
        require("camera_cols", cols, cols > 0.0, "at least one column")?;
        if self.farthest > self.focal_length {
            self.theta_laser.check()
        } else {
            let wanted = "a depth beyond the focal length";
            Err(SensorError::BadParameter { key: "farthest", value: self.farthest, wanted })
        }
    }

    /// The angle of the laser sheet through a point: Eq. 4.15 with `B_b(θ)`, solved for θ.
    ///
    /// Multiplied by `sin θ`, and with `b sin θ = 2 cos θ_m (R - g cos θ_m)`, the equation has no
    /// poles: `(x + B) sin θ + 2 cos θ_m (R - g cos θ_m) - z cos θ = 0`. Newton's method inside a
    /// shrinking interval; `None` if no sheet of the scan's field reaches the point.
    pub(super) fn theta_at(&self, point: &Point3) -> Option<f64> {
        let from_axis = point.x + self.baseline;
        let miss = |theta: f64| {
            let ((sin, cos), (sin_m, cos_m)) = (theta.sin_cos(), (theta / 2.0).sin_cos());
            let (r, g) = (self.mirror_face, self.mirror_axis);
            let value = from_axis * sin + 2.0 * cos_m * (r - g * cos_m) - point.z * cos;
            let slope = from_axis * cos - r * sin_m + g * sin + point.z * sin;
            (value, slope)
        };
        let (mut low, mut high) = self.theta_laser.field();
        if miss(low).0 > 0.0 || miss(high).0 < 0.0 {
            return None;
        }
        let mut theta = 0.5 * (low + high);
        for _ in 0..MAX_STEPS {
            let (value, slope) = miss(theta);
            if value > 0.0 {
                high = theta
            } else {
                low = theta
            }
            let newton = theta - value / slope;
            // A few roundings away from the root, Newton's step is rounding too.
            if (newton - theta).abs() <= 4.0 * f64::EPSILON * theta {
                break;
            }
            theta = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        }
        Some(theta)
    }
}
