//! Smoothing against known surfaces: what it must keep and what it must gain.

use crate::surfaces::{Distance, camera, error_at, look, pixels, quantile, radar};
use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::Arc;
use transect_device::{DeviceFrame, Pixel, Point3, View};
use transect_image::smooth::{Smoothed, smooth};
use transect_image::{BreakRule, RangeNoise};

/// Rays are this far apart at distance 1.
const STEP: f64 = 1.0 / 120.0;

/// The point as seen with z along the viewing direction, whichever sensor sees it.
fn ahead(p: &Point3) -> (f64, f64, f64) {
    if p.x > p.z { (p.y, p.z, p.x) } else { (p.x, p.y, p.z) }
}

/// A wall 3 away, seen at 0° to 55°.
fn wall(p: &Point3) -> f64 {
    let (x, y, z) = ahead(p);
    // Half the distance is a safe step however the rays run.
    (3.0 - z + 0.7 * x + 0.4 * y) / (1.0_f64 + 0.49 + 0.16).sqrt()
}

fn ball(p: &Point3) -> f64 {
    let (x, y, z) = ahead(p);
    (x * x + y * y + (z - 3.0) * (z - 3.0)).sqrt() - 1.0
}

fn torus(p: &Point3) -> f64 {
    let (x, y, z) = ahead(p);
    let (y, z) = (0.8 * y + 0.6 * (z - 3.0), 0.8 * (z - 3.0) - 0.6 * y);
    ((x * x + y * y).sqrt() - 0.75).hypot(z) - 0.3
}

/// A box with a corner towards the sensor, before a wall; a rod of two to three pixels before both.
fn corner_and_rod(p: &Point3) -> f64 {
    let (x, y, z) = ahead(p);
    let (a, b) = (FRAC_1_SQRT_2 * (x + z - 3.0), FRAC_1_SQRT_2 * (z - 3.0 - x));
    let (dx, dy, dz) = (a.abs() - 0.5, (y - 0.1).abs() - 0.5, b.abs() - 0.5);
    let outside = dx.max(0.0).hypot(dy.max(0.0)).hypot(dz.max(0.0));
    let solid = outside + dx.max(dy).max(dz).min(0.0);
    let rod = (x - 0.3 * y + 0.6).hypot(z - 2.2) * 0.95 - 0.025;
    solid.min(4.0 - z).min(rod)
}

fn smoothed(view: &View) -> Smoothed {
    let noise = RangeNoise::of(view);
    let rule = BreakRule::new(78_f64.to_radians(), 4.0 * noise.length());
    smooth(view, &noise, &rule).unwrap()
}

fn sensors() -> [Arc<dyn DeviceFrame>; 2] {
    [camera(), radar()]
}

fn bits(view: &View) -> Vec<u32> {
    let rows = 0..view.image().size().rows;
    rows.flat_map(|r| view.image().row(r).iter().map(|v| v.to_bits())).collect()
}

#[test]
fn images_without_noise_keep_every_bit() {
    for frame in sensors() {
        for stated in [Some(0.0), Some(1e-5), None] {
            let view = look(&frame, torus, 0.0, stated);
            let result = smoothed(&view);
            assert_eq!(bits(&result.view), bits(&view), "{stated:?}");
            assert_eq!(result.changed, 0);
            assert!(result.sigma_factors.iter().all(|factor| *factor == 1.0));
        }
    }
}

#[test]
fn planes_stay_planes() {
    // A clean image of which it is said that it is noisy: every change is bias.
    for (frame, limit) in sensors().iter().zip([1e-4, 5e-3]) {
        let sigma = 0.5 * 3.0 * STEP;
        let view = look(frame, wall, 0.0, Some(sigma));
        let result = smoothed(&view);
        assert!(result.changed > view.image().valid_count() * 9 / 10);
        let worst = quantile(pixels(frame.size()).map(|p| error_at(&result.view, &view, p)), 1.0);
        assert!(worst < limit * sigma, "{} sigma by {frame:?}", worst / sigma);
    }
}

/// Bias and remaining noise of a surface, in standard deviations. The bias is the change of the
/// clean image that three quarters of the pixels stay below (of a ball, those seen at up to 60°).
/// The noise is stated as quantiles of the error before and after.
fn measure(frame: &Arc<dyn DeviceFrame>, surface: Distance, ratio: f64) -> [f64; 5] {
    let sigma = ratio * 3.0 * STEP;
    let clean = look(frame, surface, 0.0, Some(sigma));
    let bias = smoothed(&clean);
    let noisy = look(frame, surface, sigma, Some(sigma));
    let after = smoothed(&noisy);
    let all = || pixels(frame.size());
    let bias = quantile(all().map(|p| error_at(&bias.view, &clean, p)), 0.75);
    let before = |share| quantile(all().map(|p| error_at(&noisy, &clean, p)), share);
    let then = |share| quantile(all().map(|p| error_at(&after.view, &clean, p)), share);
    [bias, before(0.5), then(0.5), before(0.95), then(0.95)].map(|e| e / sigma)
}

#[test]
fn curved_surfaces_gain_without_being_flattened() {
    for (name, surface) in [("ball", ball as Distance), ("torus", torus)] {
        for (ratio, gain) in [(0.5, 2.8), (2.5, 3.5)] {
            for frame in sensors() {
                let [bias, median, median_after, p95, p95_after] = measure(&frame, surface, ratio);
                println!(
                    "{name} {ratio}: bias p75 {bias:.3}, median {median:.3} -> {median_after:.3}, \
                     p95 {p95:.3} -> {p95_after:.3}"
                );
                assert!(median_after * gain < median, "{name} {ratio}");
                assert!(p95_after * 1.5 < p95, "{name} {ratio}");
                assert!(bias < 0.2, "{name} {ratio}: {bias}");
            }
        }
    }
}

#[test]
fn the_remaining_noise_is_as_stated() {
    for frame in sensors() {
        let sigma = 0.5 * 3.0 * STEP;
        let (clean, noisy) =
            (look(&frame, ball, 0.0, None), look(&frame, ball, sigma, Some(sigma)));
        let result = smoothed(&noisy);
        // A normalised error of normal spread, whatever the pixel's own factor.
        let normalised = pixels(frame.size())
            .map(|p| error_at(&result.view, &clean, p) / (sigma * result.factor(p)));
        let spread = quantile(normalised, 0.5) / 0.6745;
        println!("observed over stated: {spread:.3}");
        assert!((0.9..1.2).contains(&spread), "{spread}");
    }
}

/// Whether a pixel lies within two pixels of a jump of the clean image.
fn near_jump(clean: &View, pixel: Pixel) -> bool {
    let value = |row: usize, col: usize| clean.image().get(Pixel::new(row, col));
    let Pixel { row, col } = pixel;
    let around = |c: usize| c.saturating_sub(2)..=c + 2;
    let near = around(row).flat_map(|r| around(col).filter_map(move |c| value(r, c)));
    let (low, high) = near.fold((f32::MAX, 0.0_f32), |(l, h), v| (l.min(v), h.max(v)));
    high - low > 0.3
}

#[test]
fn edges_and_rods_are_not_blurred() {
    for frame in sensors() {
        for ratio in [0.5, 2.5] {
            let sigma = ratio * 3.0 * STEP;
            let clean = look(&frame, corner_and_rod, 0.0, Some(sigma));
            let noisy = look(&frame, corner_and_rod, sigma, Some(sigma));
            let after = smoothed(&noisy);
            let edges = || pixels(frame.size()).filter(|p| near_jump(&clean, *p));
            assert!(edges().count() > 500);
            for share in [0.5, 0.95] {
                let before = quantile(edges().map(|p| error_at(&noisy, &clean, p)), share);
                let then = quantile(edges().map(|p| error_at(&after.view, &clean, p)), share);
                println!("edges {ratio} {share}: {:.2} -> {:.2}", before / sigma, then / sigma);
                assert!(then <= before, "{share}: {} -> {}", before / sigma, then / sigma);
            }
        }
    }
}

/// 1 over such a standard deviation is the smallest 32-bit number, and a part of it is 0.
#[test]
fn a_noise_near_the_largest_number_is_no_panic() {
    for sigma in [1e38, 7e44, 1e45, 1e300] {
        let view = look(&camera(), |p| 0.9 - p.z, 0.0, Some(sigma));
        assert_eq!(smoothed(&view).view.image().valid_count(), view.image().valid_count());
    }
}

#[test]
fn missing_pixels_stay_missing_and_lone_ones_stay_as_they_are() {
    let frame = camera();
    let sigma = 0.5 * 3.0 * STEP;
    let view = look(&frame, ball, sigma, Some(sigma));
    let size = frame.size();
    let lone = Pixel::new(48, 64);
    let thinned: Vec<f32> = pixels(size)
        .map(|p| {
            let beside = p.row.abs_diff(lone.row).max(p.col.abs_diff(lone.col)) == 1;
            if beside { f32::NAN } else { view.image().get(p).unwrap_or(f32::NAN) }
        })
        .collect();
    let image = transect_device::RangeImage::from_values(size, thinned).unwrap();
    let view = view.with_image(image).unwrap();
    let result = smoothed(&view);
    for p in pixels(size) {
        let (old, new) = (view.image().get(p), result.view.image().get(p));
        assert_eq!(old.is_some(), new.is_some(), "{p}");
        if p == lone {
            assert_eq!((old, result.factor(p)), (new, 1.0));
        }
    }
}
