//! The radius of a window, from the noise and the spacing of the rays.

use crate::tuning::{LARGEST_RADIUS, RADIUS, SMALLEST_RADIUS, WIDER, WIDEST_RADIUS};

/// Radii of a pixel's window in rows and in columns, from the distances between its rays and its
/// noise, all lengths; 0 where noise is negligible against the spacing of the rays, or either is
/// not known.
#[inline(always)]
pub(super) fn radii([across, down, noise]: [f32; 3]) -> [f32; 2] {
    let spacing = (across * down).sqrt();
    let radius = radius(noise, spacing);
    // Nothing here branches, so that several pixels can be taken at a time.
    let limit = |radius: f32| radius.clamp(1.0, LARGEST_RADIUS);
    let [rows, cols] = [limit(radius * spacing / down), limit(radius * spacing / across)];
    // Rays that coincide have no spacing.
    let known = (radius > 0.0) & (across > 0.0) & (down > 0.0);
    if known { [rows, cols] } else { [0.0; 2] }
}

/// Radius of the window in pixels; 0 where noise is negligible against the spacing, or either is
/// not known.
#[inline(always)]
pub(super) fn radius(sigma: f32, spacing: f32) -> f32 {
    let radius = RADIUS * cube_root(sigma / spacing);
    if radius >= SMALLEST_RADIUS { radius.min(LARGEST_RADIUS) } else { 0.0 }
}

/// The cube root of a positive number by a guess at its exponent and Newton's method; 0 of all
/// others. That of the standard library takes several times as long.
#[inline(always)]
fn cube_root(x: f32) -> f32 {
    // Nothing here branches, so that several can be found at a time.
    let known = x > 1e-30;
    let x = if known { x.min(1e30) } else { 1.0 };
    // A third of the exponent and its bias again; each step then doubles the number of right
    // digits.
    let mut root = f32::from_bits(x.to_bits() / 3 + 0x2a51_19f2);
    for _ in 0..3 {
        root = (root + root + x / (root * root)) * (1.0 / 3.0);
    }
    if known { root } else { 0.0 }
}

/// Radius of the wider window of a pixel.
pub(super) fn wider(radius: f32) -> f32 {
    (WIDER * radius).min(WIDEST_RADIUS)
}

/// Radius of a window of which the wider one has a share.
#[inline(always)]
pub(super) fn between(radius: f32, share: f32) -> f32 {
    radius + share * (wider(radius) - radius)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_that_coincide_have_no_window() {
        assert!(radii([0.01, 0.02, 0.01]).iter().all(|r| *r > 0.0));
        for spacings in [[0.0, 0.02], [0.01, 0.0], [0.0, 0.0], [f32::NAN, 0.02]] {
            assert_eq!(radii([spacings[0], spacings[1], 0.01]), [0.0; 2], "{spacings:?}");
        }
    }

    #[test]
    fn cube_roots_are_those_of_the_library() {
        for k in -400..400 {
            let x = 1.0371_f32.powi(k) * 0.9;
            assert!((cube_root(x) / x.cbrt() - 1.0).abs() < 4e-7, "{x}");
        }
        assert_eq!(cube_root(0.0), 0.0);
        assert_eq!(cube_root(f32::NAN), 0.0);
    }

    #[test]
    fn windows_grow_with_noise_and_vanish_without() {
        assert_eq!(radius(0.0, 1.0), 0.0);
        assert_eq!(radius(0.01, 1.0), 0.0);
        assert_eq!(radius(f32::NAN, 1.0), 0.0);
        assert_eq!(radius(1.0, f32::NAN), 0.0);
        assert_eq!(radius(100.0, 1.0), LARGEST_RADIUS);
        let sizes = [0.1, 0.5, 1.0, 2.5].map(|ratio| radius(ratio, 1.0));
        assert!(sizes.windows(2).all(|pair| pair[0] < pair[1]), "{sizes:?}");
        assert!((radius(0.002, 0.004) - 0.7937 * RADIUS).abs() < 0.001);
    }
}
