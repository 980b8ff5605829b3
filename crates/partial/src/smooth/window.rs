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
    let radius = RADIUS * (sigma / spacing).cbrt();
    if radius >= SMALLEST { radius.min(LARGEST) } else { 0.0 }
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
