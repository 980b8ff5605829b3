//! The errors of sensors, and the check of a parameter.

use transect_device::ImageError;

/// Why parameters or measurements make no sensor.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SensorError {
    /// A parameter is zero, NaN, infinite or outside its range.
    #[error("{key} = {value}: {wanted}")]
    BadParameter {
        /// The parameter, by its name in manifests.
        key: &'static str,
        /// Its value.
        value: f64,
        /// The condition it fails.
        wanted: &'static str,
    },
    /// The size of the sensor's image is impossible.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A grid of points that does not show from which side it is seen.
    #[error("no three neighbouring points show from which side the grid is seen")]
    NoSurface,
    /// Scanned points that do not lie on the surfaces as they were stated.
    #[error(
        "{problem}; check the stated places, the radii (not diameters), and which file belongs to \
         which surface"
    )]
    Contradicted {
        /// The surfaces with what was stated and what was found.
        problem: String,
    },
    /// Measurements that do not determine all unknowns.
    #[error("the measurements leave the pose undetermined; needed are {wanted}")]
    Undetermined {
        /// The measurements that would determine them.
        wanted: &'static str,
    },
}

/// Refuses a parameter that is not finite or fails a condition.
pub(crate) fn require(
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
