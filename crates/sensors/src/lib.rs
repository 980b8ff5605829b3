//! Device frames of range sensors, one module each, all behind [`transect_device::DeviceFrame`].
//!
//! The one decision of this crate: a backend is **parameters plus equations**. Where a sensor's
//! numbers come from (a file, a calibration, a simulation) is somebody else's business.
//!
//! It refuses to know files and curves, and its modules refuse to know each other.
//!
//! | module | sensor | `d3` | inverse `F` |
//! |---|---|---|---|
//! | [`imaging_radar`] | two scanning angles and a range: every terrestrial laser scanner | range | yes |
//! | [`light_stripe`] | a laser sheet turned by a mirror, watched by a camera | the stripe's place in its camera row | yes |
//! | [`lookup_table`] | one scanning angle on a linear axis, calibrated by tables | image position of the spot | yes |
//! | [`pinhole`] | depth camera, with or without lens distortion | depth along the optical axis, or ray length | yes |
//! | [`point_grid`] | organised grid of Cartesian points | distance from the ray's start | no |

pub mod imaging_radar;
pub mod light_stripe;
pub mod lookup_table;
pub mod pinhole;
pub mod point_grid;

pub use imaging_radar::{AngularScan, ImagingRadar};
pub use light_stripe::{LaserAngles, LightStripe, LightStripeParameters};
pub use lookup_table::LookupTable;
pub use pinhole::{Intrinsics, Pinhole, PinholeScale, RayTable};
pub use point_grid::{CarriedPinhole, PointGrid, RayStarts};

use transect_device::ImageError;

/// Parameters that describe no sensor.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SensorError {
    /// A parameter is zero, NaN, infinite or outside its range.
    #[error("{key} = {value}: {wanted}")]
    BadParameter {
        /// The parameter, as manifests call it.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What it should have been.
        wanted: &'static str,
    },
    /// The image that goes with the sensor is impossible.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A grid of points from which the way round it cannot be read.
    #[error("no three neighbouring points show from which side the grid is seen")]
    NoSurface,
    /// Measurements that leave part of what they should tell open.
    #[error("the measurements leave the pose undetermined: needed are {wanted}")]
    Undetermined {
        /// What would determine it.
        wanted: &'static str,
    },
}

/// Refuses a parameter that is not finite or fails a condition.
fn require(
    key: &'static str,
    value: f64,
    condition: bool,
    wanted: &'static str,
) -> Result<f64, SensorError> {
    if value.is_finite() && condition {
        Ok(value)
    } else {
        Err(SensorError::BadParameter { key, value, wanted })
    }
}
