//! The parameters of the sensors that scenes name, and their device frames.

use super::check::{Place, Problem};
use std::sync::Arc;
use transect_device::{DeviceFrame, ImageSize};
use transect_sensors::lookup_table::CarriedScanner;
use transect_sensors::{
    AngularScan, ImagingRadar, Intrinsics, LightStripe, LightStripeParameters, Pinhole, SensorError,
};

/// The parameters of a device frame.
#[derive(Debug, Clone, PartialEq)]
pub enum SensorParameters {
    /// Terrestrial scanner: `(cos φ cos θ, cos φ sin θ, sin φ)` with rows along φ, columns along θ.
    ///
    /// The sensor's z axis is up when the station is upright. Values are ranges.
    Spherical {
        /// θ of column 0, in radians.
        theta0: f64,
        /// Change of θ from column to column, in radians; negative for columns to the right.
        dtheta: f64,
        /// φ of row 0, in radians.
        phi0: f64,
        /// Change of φ from row to row, in radians; negative for rows running down.
        dphi: f64,
    },
    /// Depth camera: pixel (row i, column j) is the ray `((j - cx) / fx, (i - cy) / fy, 1)`.
    ///
    /// x runs right, y down, z forward. Values are depths along z.
    Pinhole {
        /// Focal length along the columns' direction, in pixels.
        fx: f64,
        /// Focal length along the rows' direction, in pixels.
        fy: f64,
        /// Column of the optical axis.
        cx: f64,
        /// Row of the optical axis.
        cy: f64,
    },
    /// Laser sheet and camera, at its true size. x runs from the laser to the camera, y down.
    LightStripe(LightStripeParameters),
    /// Line scanner on a linear axis, at its true size. x runs along the beams, rows run down.
    LookupTable(CarriedScanner),
}

impl SensorParameters {
    /// The device frame of an image's size. Triangulation sensors know their own size.
    ///
    /// # Errors
    /// [`SensorError`] if the parameters make no sensor.
    pub fn frame(&self, size: ImageSize) -> Result<Arc<dyn DeviceFrame>, SensorError> {
        Ok(match self {
            Self::Spherical { theta0, dtheta, phi0, dphi } => {
                let theta = AngularScan::from_radians(*theta0, *dtheta);
                Arc::new(ImagingRadar::new(size, theta, AngularScan::from_radians(*phi0, *dphi))?)
            }
            &Self::Pinhole { fx, fy, cx, cy } => {
                Arc::new(Pinhole::new(size, Intrinsics { fx, fy, cx, cy })?)
            }
            Self::LightStripe(parameters) => Arc::new(LightStripe::new(parameters.clone())?),
            Self::LookupTable(scanner) => Arc::new(scanner.table()?),
        })
    }
}

/// First angle and step, in radians, of pixel centres that share a range equally.
pub(super) fn centres(
    place: &Place,
    key: &'static str,
    [from, to]: [f64; 2],
    count: usize,
) -> Result<(f64, f64), Problem> {
    let span = to - from;
    let possible = |s: f64| s != 0.0 && s.abs() <= 360.0;
    place.value(key, span, possible, "a range of more than 0 and at most 360 degrees")?;
    let step = span / count as f64;
    Ok(((from + 0.5 * step).to_radians(), step.to_radians()))
}
