//! Curve and plane in the Cartesian frame, linear (3.6, errata).

use super::{PairMeeting, height};
use transect_device::{Point3, SensorPlane};

/// Where the straight line between two samples meets the plane.
///
/// `t = −h₁ / (h₂ − h₁)` of the heights over the plane, clamped to the pair: no special cases for
/// lines along an axis, which the printed solution divides by.
pub(super) fn meet([p, q]: &[Point3; 2], plane: &SensorPlane) -> PairMeeting {
    let parameter = parameter(height(plane, p), height(plane, q));
    let d = q - p;
    // From the nearer sample, so that crossings at one sample are at one place.
    let point = if parameter < 0.5 { p + d * parameter } else { q - d * (1.0 - parameter) };
    PairMeeting { parameter, point }
}

/// Where between two heights over a plane the line through them meets it.
///
/// Of two heights on one side of the plane the one nearer to it. Labels are decided in `f32`,
/// heights here in `f64`, so a sample that is on the plane within rounding may have either sign.
pub(crate) fn parameter(first: f64, second: f64) -> f64 {
    let t = first / (first - second);
    if t.is_nan() { 0.5 } else { t.clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plane_is_met_between_the_samples() {
        assert_eq!(parameter(-1.0, 3.0), 0.25);
        assert_eq!(parameter(0.0, 3.0), 0.0);
        assert_eq!(parameter(1e-9, 3.0), 0.0, "a label that rounding flipped");
        assert_eq!(parameter(0.0, 0.0), 0.5);
    }

    #[test]
    fn samples_on_one_side_give_the_nearer_one() {
        assert_eq!(parameter(0.1, 3.0), 0.0);
        assert_eq!(parameter(-3.0, -0.1), 1.0);
    }
}
