//! The radius of a window, from the noise and the spacing of the rays.

use super::lanes::{MOST, Native, all};
use crate::tuning::{LARGEST_RADIUS, RADIUS, SMALLEST_RADIUS, WIDER, WIDEST_RADIUS};
use fearless_simd::Simd;
use fearless_simd::prelude::*;

/// Radii of the pixels' windows in rows and in columns, from the distances between their rays and
/// their noise, all lengths. A radius is 0 where noise is negligible against the spacing of the
/// rays, or either is not known.
#[inline(always)]
pub(super) fn radii<S: Simd>(simd: S, [across, down, noise]: [Native<S>; 3]) -> [Native<S>; 2] {
    let zero = all(simd, 0.0);
    let spacing = (across * down).sqrt();
    let radius = radius(simd, noise, spacing);
    // Rays that coincide have no spacing.
    let known = radius.simd_gt(zero) & across.simd_gt(zero) & down.simd_gt(zero);
    [down, across].map(|along| {
        let radius = (radius * spacing / along).max(all(simd, 1.0));
        known.select(radius.min(all(simd, LARGEST_RADIUS)), zero)
    })
}

/// Radii of the windows in pixels; 0 where noise is negligible against the spacing, or either is
/// not known.
#[inline(always)]
fn radius<S: Simd>(simd: S, sigma: Native<S>, spacing: Native<S>) -> Native<S> {
    let radius = cube_root(simd, sigma / spacing) * RADIUS;
    let counts = radius.simd_ge(all(simd, SMALLEST_RADIUS));
    counts.select(radius.min(all(simd, LARGEST_RADIUS)), all(simd, 0.0))
}

/// The cube roots of positive numbers by a guess at their exponents and Newton's method; 0 of all
/// others. That of the standard library takes several times as long.
#[inline(always)]
fn cube_root<S: Simd>(simd: S, x: Native<S>) -> Native<S> {
    let known = x.simd_gt(all(simd, 1e-30));
    let x = known.select(x.min(all(simd, 1e30)), all(simd, 1.0));
    // A third of the exponent and its bias again; each step then doubles the number of right
    // digits.
    let mut guesses = [0.0; MOST];
    x.store_slice(&mut guesses[..Native::<S>::LEN]);
    let guesses = guesses.map(|x: f32| f32::from_bits(x.to_bits() / 3 + 0x2a51_19f2));
    let mut root = Native::<S>::from_slice(simd, &guesses[..Native::<S>::LEN]);
    for _ in 0..3 {
        root = (root + root + x / (root * root)) * (1.0 / 3.0);
    }
    known.select(root, all(simd, 0.0))
}

/// Radius of the wider window of a pixel.
pub(super) fn wider(radius: f32) -> f32 {
    (WIDER * radius).min(WIDEST_RADIUS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    /// A function of all lanes for one number in each.
    macro_rules! first_lane {
        ($function:ident, $($number:expr),*) => {
            dispatch!(Level::new(), simd => {
                $function(simd, $(all(simd, $number)),*).as_slice()[0]
            })
        };
    }

    fn root(x: f32) -> f32 {
        first_lane!(cube_root, x)
    }

    fn of_ratio(sigma: f32, spacing: f32) -> f32 {
        first_lane!(radius, sigma, spacing)
    }

    #[test]
    fn rays_that_coincide_have_no_window() {
        let radii = |lengths: [f32; 3]| {
            dispatch!(Level::new(), simd => {
                radii(simd, lengths.map(|length| all(simd, length))).map(|r| r.as_slice()[0])
            })
        };
        assert!(radii([0.01, 0.02, 0.01]).iter().all(|r| *r > 0.0));
        for spacings in [[0.0, 0.02], [0.01, 0.0], [0.0, 0.0], [f32::NAN, 0.02]] {
            assert_eq!(radii([spacings[0], spacings[1], 0.01]), [0.0; 2], "{spacings:?}");
        }
    }

    #[test]
    fn cube_roots_are_those_of_the_library() {
        for k in -400..400 {
            let x = 1.0371_f32.powi(k) * 0.9;
            assert!((root(x) / x.cbrt() - 1.0).abs() < 4e-7, "{x}");
        }
        assert_eq!(root(0.0), 0.0);
        assert_eq!(root(f32::NAN), 0.0);
    }

    #[test]
    fn windows_grow_with_noise_and_vanish_without() {
        assert_eq!(of_ratio(0.0, 1.0), 0.0);
        assert_eq!(of_ratio(0.01, 1.0), 0.0);
        assert_eq!(of_ratio(f32::NAN, 1.0), 0.0);
        assert_eq!(of_ratio(1.0, f32::NAN), 0.0);
        assert_eq!(of_ratio(100.0, 1.0), LARGEST_RADIUS);
        let sizes = [0.1, 0.5, 1.0, 2.5].map(|ratio| of_ratio(ratio, 1.0));
        assert!(sizes.windows(2).all(|pair| pair[0] < pair[1]), "{sizes:?}");
        assert!((of_ratio(0.002, 0.004) - 0.7937 * RADIUS).abs() < 0.001);
    }
}
