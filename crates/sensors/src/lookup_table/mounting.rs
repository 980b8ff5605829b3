//! How the scanner hangs on the machine: its plane, its tilt, and the linear axis (4.7.1).

use crate::error::{SensorError, require};
use nalgebra::{Point2, Vector2};
use serde::{Deserialize, Serialize};
use transect_device::{Point3, Vector3};

/// The coordinate plane the scanner sweeps, and with it the linear axis that carries it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ScanPlane {
    /// Sweeps x–z, tilted about y, carried along y.
    Xz,
    /// Sweeps y–z, tilted about x, carried along x.
    Yz,
}

/// The local frame (u, v) in the sensor frame.
///
/// The tilt turns the scanner about the linear axis, right-handed. At tilt 0, v runs along z and u
/// along x (or y).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mounting {
    plane: ScanPlane,
    pub(super) tilt_rad: f64,
}

impl Mounting {
    /// A mounting with its tilt in radians.
    pub fn from_radians(plane: ScanPlane, tilt: f64) -> Self {
        Self { plane, tilt_rad: tilt }
    }

    /// A mounting with its tilt in degrees.
    pub fn from_degrees(plane: ScanPlane, tilt: f64) -> Self {
        Self::from_radians(plane, tilt.to_radians())
    }

    /// The axes, after a check of the tilt.
    pub(super) fn axes(&self) -> Result<Axes, SensorError> {
        let (sin, cos) = require("tilt", self.tilt_rad, true, "an angle")?.sin_cos();
        Ok(match self.plane {
            ScanPlane::Xz => Axes {
                u: Vector3::new(cos, 0.0, -sin),
                v: Vector3::new(sin, 0.0, cos),
                linear: Vector3::y(),
            },
            ScanPlane::Yz => Axes {
                u: Vector3::new(0.0, cos, sin),
                v: Vector3::new(0.0, -sin, cos),
                linear: Vector3::x(),
            },
        })
    }
}

/// Orthonormal axes of a mounted scanner, in the sensor frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes {
    pub(super) u: Vector3,
    pub(super) v: Vector3,
    pub(super) linear: Vector3,
}

impl Axes {
    /// The sensor-frame point of a local point at a place on the linear axis.
    pub(super) fn point(&self, local: &Point2<f64>, linear: f64) -> Point3 {
        Point3::from(self.u * local.x + self.v * local.y + self.linear * linear)
    }

    /// The sensor-frame direction of a local one.
    pub(super) fn direction(&self, local: &Vector2<f64>) -> Vector3 {
        self.u * local.x + self.v * local.y
    }

    /// A sensor-frame vector's components in the scanning plane.
    pub(super) fn local(&self, of: &Vector3) -> Vector2<f64> {
        Vector2::new(self.u.dot(of), self.v.dot(of))
    }
}

/// Equal steps of the linear axis: row `i` is swept at `start + i · step`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearSteps {
    start: f64,
    step: f64,
    rows: usize,
}

impl LinearSteps {
    /// Rows from `start` on, `step` apart; lengths. The step may be negative.
    pub fn new(start: f64, step: f64, rows: usize) -> Self {
        Self { start, step, rows }
    }

    /// A single sweep at one place: an image of one row (dissertation, section 3.3).
    ///
    /// Rows of device points then count length units off the scanning plane.
    pub fn single(at: f64) -> Self {
        Self::new(at, 1.0, 1)
    }

    pub(super) fn checked(self) -> Result<Self, SensorError> {
        require("y0", self.start, true, "a place on the linear axis")?;
        require("dy", self.step, self.step != 0.0, "a step other than 0")?;
        require("rows", self.rows as f64, self.rows > 0, "at least one row")?;
        Ok(self)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Distance from a row to the next, a signed length.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Place of a row that may lie between two sweeps.
    pub fn place(&self, row: f64) -> f64 {
        self.start + row * self.step
    }

    /// The row of a place, whole at a sweep.
    pub(super) fn row(&self, place: f64) -> f64 {
        (place - self.start) / self.step
    }
}
