//! Sensors whose grid is two angles and a range: imaging radars (Eq. 4.1–4.3).

use std::f64::consts::{PI, TAU};
use transect_device::{DeviceFrame, Pixel, Point3, Vector3};

/// How far a ray may lie from where its two angles put it, as a length of unit vectors: rounding.
const SAME_RAY: f64 = 1e-12;

/// The angles of a sensor's rows and columns: row `i` at elevation φ_i, column `j` at azimuth θ_j.
///
/// Read from the rays themselves, because partial modelling knows no particular sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct AngularGrid {
    thetas: Vec<f64>,
    phis: Vec<f64>,
}

impl AngularGrid {
    /// The angles of a frame; `None` unless all its rays start at the origin, rows are circles of
    /// elevation, columns are half-planes of azimuth, and values are ranges.
    pub fn read(frame: &dyn DeviceFrame) -> Option<Self> {
        let size = frame.size();
        let elevation = |row: usize| Some(frame.ray(Pixel::new(row, 0))?.direction.z.asin());
        let phis: Vec<f64> = (0..size.rows).map(elevation).collect::<Option<_>>()?;
        // Azimuths are read where the row is longest: at a pole they have none.
        let upright = (0..size.rows).min_by(|a, b| phis[*a].abs().total_cmp(&phis[*b].abs()))?;
        let azimuth = |col: usize| {
            let d = frame.ray(Pixel::new(upright, col))?.direction;
            Some(d.y.atan2(d.x))
        };
        let thetas = (0..size.cols).map(azimuth).collect::<Option<_>>()?;
        let grid = Self { thetas, phis };
        let pixels = (0..size.rows).flat_map(|r| (0..size.cols).map(move |c| Pixel::new(r, c)));
        pixels.into_iter().all(|p| grid.explains(frame, p)).then_some(grid)
    }

    /// Whether a pixel's value of 1 is the point at range 1 along its two angles.
    fn explains(&self, frame: &dyn DeviceFrame, pixel: Pixel) -> bool {
        let (theta, phi) = (self.thetas[pixel.col], self.phis[pixel.row]);
        let expected = Point3::from(direction(theta, phi));
        let from_origin = frame.ray(pixel).is_some_and(|r| r.start == Point3::origin());
        let at_range_1 = frame.point(pixel, 1.0);
        from_origin && at_range_1.is_some_and(|p| (p - expected).norm() < SAME_RAY)
    }

    /// The step between two pixels of one row or one column.
    pub(super) fn step(&self, from: Pixel, to: Pixel) -> Option<AngularStep> {
        let (theta, phi) = (*self.thetas.get(from.col)?, *self.phis.get(from.row)?);
        let turn = self.thetas.get(to.col)? - theta;
        // Across the seam of a full circle, the short way.
        let turn = if turn.abs() > PI { turn - TAU.copysign(turn) } else { turn };
        let rise = self.phis.get(to.row)? - phi;
        let along = if from.row == to.row { Scanning::Theta } else { Scanning::Phi };
        let size = if along == Scanning::Theta { turn } else { rise };
        Some(AngularStep { theta, phi, along, size })
    }
}

/// Which scanning variable a step changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scanning {
    /// Code 2: φ is constant.
    Theta,
    /// Code 1: θ is constant.
    Phi,
}

/// A step of one scanning variable while the other stays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AngularStep {
    pub theta: f64,
    pub phi: f64,
    pub along: Scanning,
    /// Signed size of the step, in radians.
    pub size: f64,
}

impl AngularStep {
    /// The ray's unit direction after a part of the step, in radians.
    pub fn ray(&self, delta: f64) -> Vector3 {
        match self.along {
            Scanning::Theta => direction(self.theta + delta, self.phi),
            Scanning::Phi => direction(self.theta, self.phi + delta),
        }
    }

    /// Change of the ray's direction per radian, after a part of the step.
    pub fn ray_slope(&self, delta: f64) -> Vector3 {
        let (theta, phi) = match self.along {
            Scanning::Theta => (self.theta + delta, self.phi),
            Scanning::Phi => (self.theta, self.phi + delta),
        };
        let ((sin_t, cos_t), (sin_p, cos_p)) = (theta.sin_cos(), phi.sin_cos());
        match self.along {
            // Errata to 3.6: its part along y is cos φ cos θ, printed as cos φ sin θ.
            Scanning::Theta => Vector3::new(-cos_p * sin_t, cos_p * cos_t, 0.0),
            Scanning::Phi => Vector3::new(-sin_p * cos_t, -sin_p * sin_t, cos_p),
        }
    }
}

/// Eq. 4.1–4.3 at range 1.
fn direction(theta: f64, phi: f64) -> Vector3 {
    let ((sin_t, cos_t), (sin_p, cos_p)) = (theta.sin_cos(), phi.sin_cos());
    Vector3::new(cos_p * cos_t, cos_p * sin_t, sin_p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_device::ImageSize;
    use transect_sensors::{AngularScan, ImagingRadar, Intrinsics, Pinhole};

    const SIZE: ImageSize = ImageSize { rows: 5, cols: 8 };

    #[test]
    fn only_grids_of_two_angles_are_recognised() {
        let circle = AngularScan::from_degrees(-170.0, 45.0);
        let radar = ImagingRadar::new(SIZE, circle, AngularScan::from_degrees(-90.0, 45.0));
        let grid = AngularGrid::read(&radar.unwrap()).unwrap();
        let seam = grid.step(Pixel::new(2, 0), Pixel::new(2, 7)).unwrap();
        assert!((seam.size + 45_f64.to_radians()).abs() < 1e-12, "{seam:?}");
        let camera = Pinhole::new(SIZE, Intrinsics { fx: 9.0, fy: 9.0, cx: 4.0, cy: 2.0 });
        assert_eq!(AngularGrid::read(&camera.unwrap()), None);
    }

    #[test]
    fn the_slope_of_the_ray_is_its_derivative() {
        for along in [Scanning::Theta, Scanning::Phi] {
            let step = AngularStep { theta: 2.1, phi: -0.7, along, size: 0.01 };
            let finite = (step.ray(0.2 + 1e-6) - step.ray(0.2 - 1e-6)) / 2e-6;
            assert!((finite - step.ray_slope(0.2)).norm() < 1e-9, "{along:?}");
        }
    }
}
