//! Functions of sensors whose rays all start in the origin.

use transect_device::{SensorPlane, Vector3};

/// Bounds of `direction · p` over the points `value · ray` of some rays, for values from `nearest`
/// to `farthest`.
pub(crate) fn central_extent(
    rays: impl Iterator<Item = Vector3>,
    direction: &Vector3,
    nearest: f64,
    farthest: f64,
) -> (f64, f64) {
    let (low, high) = rays.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), ray| {
        let per_value = direction.dot(&ray);
        (low.min(per_value), high.max(per_value))
    });
    ((low * nearest).min(low * farthest), (high * nearest).max(high * farthest))
}

/// The value at which a ray meets a plane; `None` if it misses it.
pub(crate) fn central_plane_value(ray: &Vector3, plane: &SensorPlane) -> Option<f64> {
    let value = plane.offset / plane.normal.dot(ray);
    (value.is_finite() && value > 0.0).then_some(value)
}
