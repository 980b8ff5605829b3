//! Smoothing at creases, steps, gaps and in small images.

use crate::surfaces::{Normal, camera, error_at, look, pixels};
use std::sync::Arc;
use transect_device::{DeviceFrame, ImageSize, Isometry3, Pixel, Point3, RangeImage, View};
use transect_image::smooth::{Smoothed, smooth};
use transect_image::{BreakRule, RangeNoise};
use transect_sensors::{Intrinsics, Pinhole};

fn smoothed(view: &View) -> Smoothed {
    let noise = RangeNoise::of(view);
    let rule = BreakRule::new(78_f64.to_radians(), 4.0 * noise.length());
    smooth(view, &noise, &rule).unwrap()
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

/// Many rows and few columns, seen from straight ahead; rays are 1/400 apart at distance 3.
fn strip() -> Arc<dyn DeviceFrame> {
    let k = Intrinsics { fx: 1200.0, fy: 1200.0, cx: 31.5, cy: 511.5 };
    Arc::new(Pinhole::new(ImageSize { rows: 1024, cols: 64 }, k).unwrap())
}

/// Mean and rms error by column, in standard deviations.
fn profile(shape: impl Fn(f64) -> f64, sigma: f64) -> Vec<[f64; 2]> {
    let frame = strip();
    let size = frame.size();
    let depth = |p: Pixel| 3.0 + sigma * shape(p.col as f64 - 31.5);
    let mut random = Normal(5);
    let mut image = |noise: f64| {
        let values = pixels(size).map(|p| (depth(p) + noise * random.sample()) as f32).collect();
        let image = RangeImage::from_values(size, values).unwrap();
        View::new("strip", image, frame.clone(), Isometry3::identity(), Some(sigma)).unwrap()
    };
    let (clean, noisy) = (image(0.0), image(sigma));
    let result = smoothed(&noisy);
    let of = |col: usize| {
        let rows = 20..size.rows - 20;
        let error = |row| error_at(&result.view, &clean, Pixel::new(row, col)) / sigma;
        let mean = rows.clone().map(error).sum::<f64>() / rows.len() as f64;
        [mean, rms(rows.map(error))]
    };
    (0..size.cols).map(of).collect()
}

/// Height over the distance in columns.
type Shape = Box<dyn Fn(f64) -> f64>;

/// Creases, steps and bars of all heights stay. The mean error of a column is at most 2.3 standard
/// deviations of a sample. The root mean square of all columns is below 0.8 of one. The limits are
/// a little above what was measured.
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
            let columns = profile(shape, sigma);
            let near = &columns[14..50];
            let bias = near.iter().map(|c| c[0].abs()).fold(0.0, f64::max);
            let mean = rms(near.iter().map(|c| c[1]));
            println!("{sigma} {name}: bias {bias:.2}, rms {mean:.3}");
            // Noise that is not smoothed at all has an rms of 1.
            if bias > 2.3 || mean > 0.8 {
                bad.push(format!("{sigma} {name}: bias {bias:.2}, rms {mean:.3}"));
            }
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

#[test]
fn images_too_small_for_a_window_come_out_as_noisy_as_they_are_or_better() {
    for (rows, cols) in [(1, 1), (1, 40), (40, 1), (5, 60), (60, 5), (7, 7), (9, 130)] {
        let k = Intrinsics { fx: 120.0, fy: 120.0, cx: 0.5 * cols as f64, cy: 0.5 * rows as f64 };
        let frame: Arc<dyn DeviceFrame> =
            Arc::new(Pinhole::new(ImageSize { rows, cols }, k).unwrap());
        let [clean, noisy] = [0.0, 0.0125].map(|sigma| look(&frame, wall, sigma, Some(0.0125)));
        let result = smoothed(&noisy);
        let error =
            |view: &View| rms(pixels(frame.size()).map(|p| error_at(view, &clean, p))) / 0.0125;
        let [before, after] = [error(&noisy), error(&result.view)];
        assert!(after <= before, "{rows} × {cols}: {before} -> {after}");
        if rows.min(cols) == 1 {
            assert_eq!(result.changed, 0, "{rows} × {cols}");
        }
    }
}

/// A line of missing pixels between two surfaces is no lone one.
#[test]
fn jumps_behind_missing_pixels_are_not_bridged() {
    let frame = camera();
    let step: crate::surfaces::Distance =
        |p| if p.x > 0.0 { 0.7 * (3.0 - p.z) } else { 0.7 * (3.4 - p.z) };
    let sigma = 0.0125;
    let clean = look(&frame, step, 0.0, Some(sigma));
    let noisy = with_missing(&look(&frame, step, sigma, Some(sigma)), |p| p.col == 64);
    let result = smoothed(&noisy);
    for p in pixels(frame.size()) {
        let error = error_at(&result.view, &clean, p).abs() / sigma;
        assert!(error.is_nan() || error < 5.0, "{p}: {error}");
    }
}

/// Two walls side by side, a unit apart, and a column of pixels between that belong to both.
fn rim(between: impl Fn(usize) -> f64) -> View {
    let frame = camera();
    let size = frame.size();
    let mut random = Normal(9);
    let depth = |p: Pixel| match p.col {
        0..30 => 3.0,
        30 => between(p.row),
        _ => 4.0,
    };
    let values = pixels(size).map(|p| (depth(p) + 0.002 * random.sample()) as f32).collect();
    let image = RangeImage::from_values(size, values).unwrap();
    View::new("rim", image, frame, Isometry3::identity(), Some(0.002)).unwrap()
}

#[test]
fn flying_pixels_become_missing_and_are_counted() {
    let view = rim(|row| 3.2 + 0.6 * ((row * 7 % 10) as f64 / 9.0));
    let rows = view.image().size().rows;
    let result = smoothed(&view);
    assert_eq!(result.flying, rows);
    for row in 0..rows {
        let get = |col: usize| result.view.image().get(Pixel::new(row, col));
        assert!(get(30).is_none() && get(29).is_some() && get(31).is_some(), "row {row}");
        assert!((get(29).unwrap() - 3.0).abs() < 0.01 && (get(31).unwrap() - 4.0).abs() < 0.01);
    }
}

#[test]
fn pixels_of_either_wall_and_of_a_wire_in_front_are_not_flying() {
    for (depth, what) in [(3.0, "the near wall"), (4.0, "the far wall"), (2.0, "a wire")] {
        let result = smoothed(&rim(|_| depth));
        assert_eq!(result.flying, 0, "{what}");
        assert!(result.view.image().get(Pixel::new(20, 30)).is_some());
    }
}

#[test]
fn the_rim_of_a_round_surface_is_not_flying() {
    let frame = camera();
    let size = frame.size();
    // A cylinder bends away to the left of column 30.5, and a wall is behind it.
    for rim in [30.05, 30.3, 30.55, 30.8] {
        let depth = |p: Pixel| {
            let inside = p.col as f64 - rim;
            if inside > 0.0 { 3.0 - 0.2 * inside.sqrt() } else { 6.0 }
        };
        let mut random = Normal(3);
        let values = pixels(size).map(|p| (depth(p) + 1e-3 * random.sample()) as f32).collect();
        let image = RangeImage::from_values(size, values).unwrap();
        let view = View::new("rim", image, frame.clone(), Isometry3::identity(), Some(1e-3));
        assert_eq!(smoothed(&view.unwrap()).flying, 0, "rim at {rim}");
    }
}
