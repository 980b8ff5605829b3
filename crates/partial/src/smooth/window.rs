//! How large a window: from the noise and the spacing of the rays.

use super::REACH;

/// Radius of the window, in pixels, where noise equals the spacing of the rays.
///
/// With the cube root it gives, for noise of half a spacing, the noise reduction of a square of 7 × 7
/// pixels with equal weights, and for two and a half spacings that of 11 × 11.
const RADIUS: f64 = 6.0;

/// Radius below which a window holds too few pixels to lower noise.
pub(super) const SMALLEST: f64 = 2.3;

/// Radius of the largest window that is not a wider one.
pub(super) const LARGEST: f64 = 7.5;

/// Radius of the largest wider window; the pixels on its rim weigh nothing.
const WIDEST: f64 = REACH as f64 + 0.5;

/// Radius of the window in pixels; 0 where noise is negligible against the spacing.
pub(super) fn radius(sigma: f64, spacing: f64) -> f64 {
    let radius = RADIUS * cube_root(sigma / spacing);
    if radius >= SMALLEST { radius.min(LARGEST) } else { 0.0 }
}

/// The cube root of a positive number by a guess at its exponent and Newton's method; that of the
/// standard library takes several times as long.
fn cube_root(x: f64) -> f64 {
    if !(x > 1e-300 && x < 1e300) {
        return x.cbrt();
    }
    // A third of the exponent and its bias again; each step then doubles the number of right digits.
    let mut root = f64::from_bits(x.to_bits() / 3 + 0x2a9f_7893_782d_a1ce);
    for _ in 0..4 {
        root = (root + root + x / (root * root)) * (1.0 / 3.0);
    }
    root
}

/// Radius of the wider window that is tried, too: twice the pixels.
pub(super) fn wider(radius: f64) -> f64 {
    const FACTOR: f64 = 1.4;
    (FACTOR * radius).min(WIDEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cube_roots_are_those_of_the_library() {
        for k in -400..400 {
            let x = 1.0371_f64.powi(k) * 0.9;
            assert!((cube_root(x) / x.cbrt() - 1.0).abs() < 1e-14, "{x}");
        }
        assert_eq!(cube_root(0.0), 0.0);
        assert!(cube_root(f64::NAN).is_nan());
    }

    #[test]
    fn windows_grow_with_noise_and_vanish_without() {
        assert_eq!(radius(0.0, 1.0), 0.0);
        assert_eq!(radius(0.01, 1.0), 0.0);
        assert_eq!(radius(f64::NAN, 1.0), 0.0);
        assert_eq!(radius(1.0, f64::NAN), 0.0);
        assert_eq!(radius(100.0, 1.0), LARGEST);
        let sizes = [0.1, 0.5, 1.0, 2.5].map(|ratio| radius(ratio, 1.0));
        assert!(sizes.windows(2).all(|pair| pair[0] < pair[1]), "{sizes:?}");
        assert!((radius(0.002, 0.004) - 4.762).abs() < 0.001);
    }
}
