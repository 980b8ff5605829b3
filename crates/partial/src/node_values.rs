//! Angles at a node, and the errors that follow from them, for both methods.

use transect_device::{Pixel, Vector3};
use transect_geometry::Vector2;
use transect_image::PreparedView;

/// Largest factor between range noise and the error across the curve.
///
/// Chosen by hand: where a plane is nearly tangent to the surface, the factor grows without limit
/// and is itself noise. Doubled, such nodes hardly count in fusion.
pub(crate) const LARGEST_SIGMA_FACTOR: f64 = 12.0;

/// Largest tangent of the incidence. No unit.
///
/// Theory: the range jump rule allows 78°, a tangent of 4.7; a larger one comes from a node's own
/// noise. Doubled, nothing changes but the stated incidence of such nodes.
const LARGEST_TAN_INCIDENCE: f64 = 6.0;

/// Smallest sine of the angle between a ray and its curve.
///
/// Theory: 0.2 is the cosine of the largest incidence of the range jump rule, 78°. Doubled, oblique
/// nodes state half of their spacing.
const SMALLEST_SINE: f64 = 0.2;

/// Standard deviation along the ray of the surface between the two samples of a pair, at a share of
/// the way from the first to the second: the mean of two errors, as far as they are not one and the
/// same. `pixel` is the nearer one.
pub(crate) fn sigma_between(prepared: &PreparedView<'_>, pixel: Pixel, share: f64) -> f64 {
    let (a, b) = (1.0 - share, share);
    let common = prepared.correlation_of_neighbours(pixel);
    prepared.sigma_at(pixel) * (a * a + b * b + 2.0 * a * b * common).sqrt()
}

/// Tangent of the angle between a ray and a surface's unit normal; positive, also head-on.
pub(crate) fn tan_incidence(normal: &Vector3, ray: &Vector3) -> f32 {
    let (along, across) = (normal.dot(ray).abs(), normal.cross(ray).norm());
    // A ray without a direction gives the smallest value as well.
    let tan = if across > 0.0 { (across / along).min(LARGEST_TAN_INCIDENCE) as f32 } else { 0.0 };
    tan.max(f32::MIN_POSITIVE)
}

/// Sine of the angle between a curve's unit direction and a ray.
///
/// One spacing of the rays covers its inverse along the curve.
pub(crate) fn sine_between(tangent: &Vector2, ray: &Vector3) -> f64 {
    let along = tangent.x * ray.x + tangent.y * ray.y;
    (1.0 - along * along).max(0.0).sqrt().max(SMALLEST_SINE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn incidence_is_between_ray_and_normal() {
        let ray = Vector3::new(0.0, -0.6, -0.8);
        assert!(tan_incidence(&-ray, &ray) < 1e-6, "head-on");
        assert!((tan_incidence(&Vector3::z(), &ray) - 0.75).abs() < 1e-6);
        assert_eq!(tan_incidence(&Vector3::x(), &ray), LARGEST_TAN_INCIDENCE as f32);
        assert!(tan_incidence(&Vector3::zeros(), &ray) > 0.0, "0 stands for unknown in files");
    }

    #[test]
    fn oblique_pixels_cover_more_of_the_curve() {
        let head_on = 0.01 / sine_between(&Vector2::x(), &Vector3::y());
        let oblique = 0.01 / sine_between(&Vector2::x(), &Vector3::new(0.8, 0.6, 0.0));
        assert!((head_on - 0.01).abs() < 1e-12);
        assert!((oblique - 0.01 / 0.6).abs() < 1e-12);
    }
}
