//! The fit without robust weights against the robust one, which it must not be told from.
#![allow(clippy::unwrap_used, reason = "test code; helpers are outside test functions")]

mod surfaces;

use std::sync::Arc;
use surfaces::{Normal, camera, error_at, look, pixels, radar};
use transect_device::{DeviceFrame, ImageSize, Isometry3, Pixel, Point3, RangeImage, View};
use transect_partial::smooth::{Extent, Smoothed, smooth_with};
use transect_partial::{BreakRule, RangeNoise};
use transect_sensors::{AngularScan, ImagingRadar, Intrinsics, Pinhole};

/// With and without it.
fn both(view: &View) -> [Smoothed; 2] {
    let noise = RangeNoise::of(view);
    let rule = BreakRule::new(78_f64.to_radians(), 4.0 * noise.length());
    [false, true].map(|robust| {
        let extent = Extent { robust, ..Extent::default() };
        smooth_with(view, &noise, &rule, &extent).unwrap()
    })
}

fn rms(errors: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = errors
        .filter(|e| !e.is_nan())
        .fold((0.0, 0.0), |(count, sum), e| (count + 1.0, sum + e * e));
    f64::sqrt(sum / count)
}

fn with_missing(view: &View, missing: impl FnMut(Pixel) -> bool) -> View {
    let (size, mut missing) = (view.image().size(), missing);
    let keep = |p: Pixel| view.image().get(p).filter(|_| !missing(p)).unwrap_or(f32::NAN);
    let values = pixels(size).map(keep).collect();
    view.with_image(RangeImage::from_values(size, values).unwrap()).unwrap()
}

/// The point as seen with z along the viewing direction, whichever sensor sees it.
fn ahead(p: &Point3) -> (f64, f64, f64) {
    if p.x > p.z { (p.y, p.z, p.x) } else { (p.x, p.y, p.z) }
}

fn wall(p: &Point3) -> f64 {
    let (x, y, z) = ahead(p);
    (3.0 - z + 0.7 * x + 0.4 * y) / (1.0_f64 + 0.49 + 0.16).sqrt()
}

fn bowl(p: &Point3) -> f64 {
    let (x, y, z) = ahead(p);
    2.2 - x.hypot(y).hypot(z - 1.0)
}

#[test]
fn smooth_surfaces_come_out_alike() {
    for (name, surface) in [("wall", wall as surfaces::Distance), ("bowl", bowl)] {
        for frame in [camera(), radar()] {
            for (ratio, missing) in [(0.3, 0.0), (0.5, 0.02), (2.5, 0.02)] {
                let sigma = ratio * 3.0 / 120.0;
                let mut random = Normal(3);
                let clean = look(&frame, surface, 0.0, Some(sigma));
                let noisy = look(&frame, surface, sigma, Some(sigma));
                let noisy = with_missing(&noisy, |_| random.uniform() < missing);
                let [linear, robust] = both(&noisy);
                assert_eq!(robust.linear, 0);
                let share = linear.linear as f64 / noisy.image().valid_count() as f64;
                let apart =
                    rms(pixels(frame.size()).map(|p| error_at(&linear.view, &robust.view, p)));
                let errors = [&linear, &robust].map(|s| {
                    rms(pixels(frame.size()).map(|p| error_at(&s.view, &clean, p))) / sigma
                });
                let normalised =
                    |p: Pixel| error_at(&linear.view, &clean, p) / (sigma * linear.factor(p));
                let spread = rms(pixels(frame.size()).map(normalised));
                let apart = apart / sigma;
                println!(
                    "{name} {ratio} {missing}: {share:.3} linear, {apart:.3} apart, errors {errors:.3?}, over stated {spread:.3}"
                );
                assert!(share > 0.5, "{name} {ratio}: {share}");
                assert!(apart < 0.1, "{name} {ratio}: {apart}");
                assert!(errors[0] < 1.03 * errors[1], "{name} {ratio}: {errors:?}");
                assert!((0.85..1.2).contains(&spread), "{name} {ratio}: {spread}");
                let filled = pixels(frame.size())
                    .filter(|p| noisy.image().get(*p).is_none())
                    .any(|p| linear.view.image().get(p).is_some());
                assert!(!filled, "{name}");
            }
        }
    }
}

/// Many rows and few columns, seen from straight ahead; rays are 1/400 apart at distance 3.
fn strip() -> Arc<dyn DeviceFrame> {
    let k = Intrinsics { fx: 1200.0, fy: 1200.0, cx: 31.5, cy: 511.5 };
    Arc::new(Pinhole::new(ImageSize { rows: 1024, cols: 64 }, k).unwrap())
}

/// Mean and rms error by column, in standard deviations, of both.
fn profile(shape: impl Fn(f64) -> f64, sigma: f64) -> (Vec<[[f64; 2]; 2]>, f64) {
    let frame = strip();
    let size = frame.size();
    let depth = |p: Pixel| 3.0 + sigma * shape(p.col as f64 - 31.5);
    let mut random = Normal(5);
    let image = |mut noise: Box<dyn FnMut() -> f64>| {
        let values = pixels(size).map(|p| (depth(p) + noise()) as f32).collect();
        let image = RangeImage::from_values(size, values).unwrap();
        View::new("strip", image, frame.clone(), Isometry3::identity(), Some(sigma)).unwrap()
    };
    let clean = image(Box::new(|| 0.0));
    let noisy = image(Box::new(move || sigma * random.sample()));
    let results = both(&noisy);
    let share = results[0].linear as f64 / size.pixels() as f64;
    let of = |result: &Smoothed, col: usize| {
        let errors: Vec<f64> = (20..size.rows - 20)
            .map(|row| error_at(&result.view, &clean, Pixel::new(row, col)) / sigma)
            .collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        [mean, rms(errors.into_iter())]
    };
    let columns = (0..size.cols).map(|col| [of(&results[0], col), of(&results[1], col)]);
    (columns.collect(), share)
}

/// Height over the distance in columns.
type Shape = Box<dyn Fn(f64) -> f64>;

/// Creases and steps of all heights: where the fit without robust weights would be bent, it is not
/// used.
#[test]
fn creases_and_steps_are_not_flattened() {
    let mut bad = Vec::new();
    for sigma in [0.00075, 0.0015, 0.005] {
        let mut shapes: Vec<(String, Shape)> = Vec::new();
        for slope in [0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 4.0] {
            shapes.push((format!("roof {slope}"), Box::new(move |x| -slope * x.abs())));
        }
        for height in [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0] {
            shapes.push((format!("step {height}"), Box::new(move |x| height * f64::from(x > 0.0))));
            let bar = move |x: f64| height * f64::from(x.abs() < 2.0);
            shapes.push((format!("bar {height}"), Box::new(bar)));
        }
        for (name, shape) in shapes {
            let (columns, share) = profile(shape, sigma);
            let near = &columns[14..50];
            let worst = |which: usize, what: usize| {
                near.iter().map(|c| c[which][what].abs()).fold(0.0, f64::max)
            };
            let mean = |which: usize| rms(near.iter().map(|c| c[which][1]));
            println!(
                "{sigma} {name}: {share:.2} linear; bias {:.2} {:.2}, rms {:.3} {:.3}",
                worst(0, 0),
                worst(1, 0),
                mean(0),
                mean(1)
            );
            let more = near.iter().map(|c| c[0][0].abs() - c[1][0].abs()).fold(0.0, f64::max);
            if more > 0.17 || mean(0) > 1.08 * mean(1) {
                bad.push(format!("{sigma} {name}: biased by {more} more"));
            }
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

#[test]
fn images_too_small_for_a_window_are_fitted_robustly() {
    for (rows, cols) in [(1, 1), (1, 40), (40, 1), (5, 60), (60, 5), (7, 7), (9, 130)] {
        let k = Intrinsics { fx: 120.0, fy: 120.0, cx: 0.5 * cols as f64, cy: 0.5 * rows as f64 };
        let frame: Arc<dyn DeviceFrame> =
            Arc::new(Pinhole::new(ImageSize { rows, cols }, k).unwrap());
        let noisy = look(&frame, wall, 0.0125, Some(0.0125));
        let [linear, robust] = both(&noisy);
        assert_eq!(linear.linear, 0, "{rows} × {cols}");
        for p in pixels(frame.size()) {
            assert_eq!(linear.view.image().get(p), robust.view.image().get(p), "{p}");
        }
    }
}

/// Around a full circle every column has a whole window.
#[test]
fn a_full_circle_has_linear_fits_across_its_seam() {
    let step = std::f64::consts::TAU / 160.0;
    let (theta, phi) =
        (AngularScan::from_radians(0.3, step), AngularScan::from_radians(-0.4, 0.02));
    let size = ImageSize { rows: 40, cols: 160 };
    let frame: Arc<dyn DeviceFrame> = Arc::new(ImagingRadar::new(size, theta, phi).unwrap());
    let tube: surfaces::Distance = |p| 3.0 - p.coords.xy().norm();
    let noisy = look(&frame, tube, 0.05, Some(0.05));
    let [linear, robust] = both(&noisy);
    let changed = |s: &Smoothed, col: usize| {
        let p = Pixel::new(20, col);
        s.view.image().get(p) != robust.view.image().get(p)
    };
    let at_seam = (0..5).chain(155..160).filter(|col| changed(&linear, *col)).count();
    assert!(at_seam >= 5, "{at_seam}");
    let rms = rms(pixels(size).map(|p| error_at(&linear.view, &robust.view, p))) / 0.05;
    assert!(rms < 0.1, "{rms}");
}

/// A line of missing pixels between two surfaces is no lone one.
#[test]
fn jumps_behind_missing_pixels_are_not_bridged() {
    let frame = camera();
    let step: surfaces::Distance =
        |p| if p.x > 0.0 { 0.7 * (3.0 - p.z) } else { 0.7 * (3.4 - p.z) };
    let sigma = 0.0125;
    let clean = look(&frame, step, 0.0, Some(sigma));
    let noisy = with_missing(&look(&frame, step, sigma, Some(sigma)), |p| p.col == 64);
    let [linear, _] = both(&noisy);
    for p in pixels(frame.size()) {
        let error = error_at(&linear.view, &clean, p).abs() / sigma;
        assert!(error.is_nan() || error < 5.0, "{p}: {error}");
    }
}
