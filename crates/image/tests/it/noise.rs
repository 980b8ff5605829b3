//! Estimated noise against known noise, for every sensor.

use crate::surfaces::{Normal, camera, error_at, look, pixels, quantile, radar, shared_noise};
use std::sync::Arc;
use transect_device::{
    DeviceFrame, Isometry3, Pixel, Point3, RangeImage, SensorPlane, Vector3, View,
};
use transect_image::smooth::{Smoothed, smooth};
use transect_image::{
    BreakRule, NoisyView, RangeNoise, estimate_sigma, estimate_value_sigma, length_per_value,
};
use transect_sensors::lookup_table::LinearSteps;
use transect_sensors::{LightStripe, LookupTable, PointGrid, RayStarts};

/// A view of a tilted wall through a point, with an error of `spread(pixel, value)` in each value.
fn wall(
    frame: &Arc<dyn DeviceFrame>,
    (normal, through): (Vector3, Point3),
    spread: impl Fn(Pixel, f64) -> f64,
) -> View {
    let normal = normal.normalize();
    let plane = SensorPlane { normal, offset: normal.dot(&through.coords) };
    let mut random = Normal(11);
    let value = |p: Pixel| {
        let d3 = frame.plane_value(p, &plane).filter(|d3| frame.point(p, *d3).is_some());
        d3.map_or(f32::NAN, |d3| (d3 + random.sample() * spread(p, d3)) as f32)
    };
    let values = pixels(frame.size()).map(value).collect();
    let image = RangeImage::from_values(frame.size(), values).unwrap();
    View::new("wall", image, Arc::clone(frame), Isometry3::identity(), None).unwrap()
}

fn grid() -> Arc<dyn DeviceFrame> {
    let view = look(&camera(), |p| 0.8 * (3.0 - p.z + 0.3 * p.x), 0.0, None);
    let nowhere = Point3::new(f64::NAN, f64::NAN, f64::NAN);
    let points =
        pixels(crate::surfaces::SIZE).map(|p| view.point_in_sensor(p).unwrap_or(nowhere)).collect();
    let starts = RayStarts::Viewpoint(Point3::origin());
    Arc::new(PointGrid::new(crate::surfaces::SIZE, points, starts).unwrap().0)
}

/// The centre of balls before the camera.
const BALL: Point3 = Point3::new(0.0, 0.0, 3.0);

/// Name, sensor, normal and point of a wall, and noise of the values.
type Case = (&'static str, Arc<dyn DeviceFrame>, (Vector3, Point3), f64);

/// Every kind of sensor, a wall that it sees, and a noise of its values.
fn cases() -> Vec<Case> {
    let stripe: Arc<dyn DeviceFrame> = Arc::new(LightStripe::smart_eye().unwrap());
    let table = LookupTable::hyscan(LinearSteps::new(0.0, 0.5, 60)).unwrap();
    let tilted = Vector3::new(0.3, 0.1, -1.0);
    let (row, col) = (stripe.size().rows / 2, stripe.size().cols / 2);
    let middle = (1..400).map(|k| 2.0 * f64::from(k));
    let seen = middle.rev().find_map(|d3| stripe.point(Pixel::new(row, col), d3)).unwrap();
    let before = Point3::new(seen.x, seen.y, 0.5 * seen.z);
    vec![
        ("camera", camera(), (tilted, Point3::new(0.0, 0.0, 3.0)), 0.01),
        ("radar", radar(), (Vector3::new(-1.0, 0.1, 0.3), Point3::new(3.0, 0.0, 0.0)), 0.01),
        ("grid", grid(), (tilted, Point3::new(0.0, 0.0, 3.0)), 0.01),
        ("light stripe", stripe, (Vector3::new(0.1, 0.05, -1.0), before), 0.2),
        ("lookup table", Arc::new(table), (tilted, Point3::new(0.0, 15.0, 150.0)), 0.1),
    ]
}

#[test]
fn estimates_are_lengths_along_the_ray_for_every_sensor() {
    for (name, frame, plane, sigma) in cases() {
        let clean = wall(&frame, plane, |_, _| 0.0);
        let noisy = wall(&frame, plane, |_, _| sigma);
        assert!(clean.image().valid_count() > 1000, "{name} sees {}", clean.image().valid_count());
        let value = estimate_value_sigma(noisy.image());
        assert!((value / sigma - 1.0).abs() < 0.05, "{name}: {value} for {sigma}");
        let lengths = pixels(frame.size()).map(|p| error_at(&noisy, &clean, p));
        let observed = quantile(lengths, 0.5) / 0.6745;
        let length = estimate_sigma(&noisy);
        println!(
            "{name}: {length:.5} for {observed:.5} in length, {value:.5} for {sigma} in value"
        );
        assert!((length / observed - 1.0).abs() < 0.1, "{name}: {length} for {observed}");
        assert_eq!(RangeNoise::of(&noisy).length(), length);
        let without = estimate_sigma(&clean);
        assert!(without < 0.01 * length, "{name}: {without} without noise");
    }
}

#[test]
fn a_stated_length_is_smoothed_in_every_sensor() {
    for (name, frame, plane, sigma) in cases() {
        let clean = wall(&frame, plane, |_, _| 0.0);
        let middle = quantile(pixels(frame.size()).map(|p| rate(&clean, p)), 0.5);
        let length = sigma * middle;
        let noisy = wall(&frame, plane, |p, d3| {
            // At the very edge of a field there is no rate, and here no noise.
            length_per_value(frame.as_ref(), p, d3).map_or(0.0, |rate| length / rate)
        });
        let (image, pose) = (noisy.image().clone(), Isometry3::identity());
        let noisy = View::new("stated", image, Arc::clone(&frame), pose, Some(length)).unwrap();
        let rule = BreakRule::new(78_f64.to_radians(), 4.0 * length);
        let result = smooth(&noisy, &RangeNoise::of(&noisy), &rule).unwrap();
        let error =
            |view: &View| quantile(pixels(frame.size()).map(|p| error_at(view, &clean, p)), 0.5);
        let (before, after) = (error(&noisy), error(&result.view));
        let factor = median_factor(&result);
        println!("{name}: {:.3} of the noise left, {factor:.3} by the factors", after / before);
        assert!((after / before / factor - 1.0).abs() < 0.2, "{name}");
        assert!(factor < 0.7, "{name}: {factor}");
    }
}

/// The factor of the median pixel's standard deviation.
fn median_factor(smoothed: &Smoothed) -> f64 {
    let image = smoothed.view.image();
    let valid = pixels(image.size()).filter(|p| image.get(*p).is_some());
    quantile(valid.map(|p| smoothed.factor(p)), 0.5)
}

fn rate(view: &View, pixel: Pixel) -> f64 {
    let d3 = view.image().get(pixel).map(f64::from);
    d3.and_then(|d3| length_per_value(view.frame(), pixel, d3)).unwrap_or(f64::NAN)
}

/// The view with every value passed through a function.
fn changed(view: &View, mut change: impl FnMut(f32) -> f32) -> RangeImage {
    let size = view.image().size();
    let values = pixels(size).map(|p| view.image().get(p).map_or(f32::NAN, &mut change)).collect();
    RangeImage::from_values(size, values).unwrap()
}

/// The noise of a pixel and of its neighbours together that is found in a view.
fn total(view: &View) -> f64 {
    estimate_value_sigma(view.image()) * 1.0_f64.hypot(RangeNoise::of(view).shared())
}

#[test]
fn noise_that_neighbours_share_is_found() {
    let (_, frame, plane, sigma) = cases().remove(0);
    // The last two hardly differ from pixel to pixel.
    for (side, own) in [(3, 1.0), (4, 1.0), (6, 1.0), (6, 0.3), (8, 0.3)] {
        let mut shared = shared_noise(frame.size(), side, side as u64).into_iter();
        let alone = wall(&frame, plane, |_, _| own * sigma);
        let image = changed(&alone, |v| v + (2.0 * sigma * shared.next().unwrap()) as f32);
        let view = View::new("groups", image, Arc::clone(&frame), *alone.world_from_sensor(), None);
        let (found, expected) = (total(&view.unwrap()), sigma * own.hypot(2.0));
        println!("groups of {side}: {found:.5} for {expected:.5}");
        assert!((found / expected - 1.0).abs() < 0.15, "groups of {side}: {found}, {expected}");
    }
}

#[test]
fn noise_that_grows_with_the_square_of_the_depth_is_found() {
    let (_, frame, _, sigma) = cases().remove(0);
    // Depths from about 2 to 6.
    let plane = (Vector3::new(1.0, 0.0, -1.0), Point3::new(0.0, 0.0, 3.0));
    for power in [0, 2] {
        let view = wall(&frame, plane, |_, depth| 0.1 * sigma * depth.powi(power));
        for noise in [RangeNoise::of(&view), RangeNoise::of_pixels(&view)] {
            for depth in [2.0_f64, 3.0, 5.0] {
                let found = noise.value_sigma(depth, 1.0) / (0.1 * sigma * depth.powi(power));
                println!("power {power}, depth {depth}: {found:.3} of the noise");
                assert!((found - 1.0).abs() < 0.1, "power {power}, depth {depth}: {found}");
            }
        }
    }
}

#[test]
fn noise_of_one_size_does_not_grow_with_few_far_pixels() {
    // A wall across the line of sight ends at one side, where a far one is seen.
    let surface = |p: &Point3| (3.0 - p.z).max(p.x + 1.0).min(9.0 - p.z);
    let view = look(&camera(), surface, 0.003, None);
    let far = pixels(view.image().size()).filter(|p| view.image().get(*p) > Some(6.0)).count();
    assert!(far > view.image().size().pixels() / 50, "{far}");
    let noise = RangeNoise::of(&view);
    assert_eq!(noise.value_sigma(3.0, 1.0), noise.value_sigma(9.0, 1.0));
}

#[test]
fn views_are_halved_where_neighbours_share_most_of_their_noise() {
    let (_, frame, plane, sigma) = cases().remove(0);
    let own = wall(&frame, plane, |_, _| sigma);
    let mut shared = shared_noise(frame.size(), 6, 1).into_iter();
    let image = changed(&own, |v| v + (3.0 * sigma * shared.next().unwrap()) as f32);
    let groups = own.with_image(image.clone()).unwrap();
    let stated = View::new("stated", image, frame, *own.world_from_sensor(), Some(sigma)).unwrap();
    for (view, step) in [(&groups, 2), (&own, 1), (&stated, 1)] {
        let noisy = NoisyView::resolved(view);
        assert_eq!(noisy.step(), step);
        for pixel in pixels(noisy.view().image().size()) {
            let whole = Pixel::new(step * pixel.row, step * pixel.col);
            let (found, expected) =
                (noisy.view().point_in_sensor(pixel), view.point_in_sensor(whole));
            let apart = found.zip(expected).map_or(0.0, |(a, b)| (a - b).norm());
            assert!(found.is_some() == expected.is_some() && apart < 1e-9, "{pixel}");
        }
    }
}

#[test]
fn missing_pixels_are_filled_where_the_image_is_noisy() {
    let (_, frame, plane, sigma) = cases().remove(0);
    let whole = wall(&frame, plane, |_, _| sigma);
    let mut count = 0..;
    let image = changed(&whole, |v| if count.next().unwrap() % 7 == 0 { f32::NAN } else { v });
    for (stated, filled) in [(None, true), (Some(sigma), true), (Some(0.0), false)] {
        let (image, pose) = (image.clone(), *whole.world_from_sensor());
        let view = View::new("holes", image, Arc::clone(&frame), pose, stated).unwrap();
        let noisy = NoisyView::whole(&view);
        let rule = BreakRule::new(78_f64.to_radians(), 4.0 * noisy.noise().length());
        let missing = view.image().size().pixels() - view.image().valid_count();
        let noisy = noisy.filled(&rule);
        let found = noisy.view().image().valid_count() - view.image().valid_count();
        assert_eq!(found, noisy.filled_pixels());
        // Those at the border stay.
        assert_eq!(found > missing * 9 / 10, filled, "{found} of {missing}");
        assert_eq!(found == 0, !filled);
    }
}

#[test]
fn half_of_the_rows_is_enough_where_neighbours_share_their_noise() {
    let (_, frame, plane, sigma) = cases().remove(0);
    let clean = wall(&frame, plane, |_, _| 0.0);
    for side in [4, 6] {
        let mut shared = shared_noise(frame.size(), side, side as u64).into_iter();
        let own = wall(&frame, plane, |_, _| sigma);
        let image = changed(&own, |v| v + (2.0 * sigma * shared.next().unwrap()) as f32);
        // A stated noise is one of single pixels, so all rows count.
        let stated = Some(sigma * 5_f64.sqrt());
        let [half, all] = [None, stated].map(|sigma| {
            let pose = Isometry3::identity();
            let view = View::new("groups", image.clone(), Arc::clone(&frame), pose, sigma).unwrap();
            let noise = RangeNoise::of(&view);
            let rule = BreakRule::new(78_f64.to_radians(), 4.0 * noise.length());
            let result = smooth(&view, &noise, &rule).unwrap();
            let errors = pixels(frame.size()).map(|p| error_at(&result.view, &clean, p));
            (quantile(errors, 0.5), median_factor(&result))
        });
        println!("groups of {side}: half the rows {half:?}, all {all:?}");
        assert!(half.0 < 1.1 * all.0, "groups of {side}: {half:?}, {all:?}");
        assert!(half.1 > 1.1 * all.1, "the factor is that of fewer rows: {half:?}, {all:?}");
    }
}

#[test]
fn surfaces_do_not_pass_for_noise_that_neighbours_share() {
    // A wall, balls of 12, 50 and 120 pixels, and pipes of 16 pixels before a wall. Their noise is
    // below, at and above their bends.
    let surfaces = [
        |p: &Point3| 3.0 - p.z,
        |p: &Point3| (*p - BALL).norm() - 0.15,
        |p: &Point3| (*p - BALL).norm() - 0.6,
        |p: &Point3| (*p - BALL).norm() - 1.4,
        |p: &Point3| {
            let pipes = (p.x.rem_euclid(0.5) - 0.25).hypot(p.z - 3.0) - 0.2;
            (0.9 * pipes).min(3.2 - p.z)
        },
    ];
    for (k, surface) in surfaces.into_iter().enumerate() {
        for sigma in [1e-6, 1e-4, 1e-3, 1e-2] {
            let view = look(&camera(), surface, sigma, None);
            let shared = RangeNoise::of(&view).shared();
            println!("surface {k}, noise {sigma}: {shared:.3}");
            assert_eq!(shared, 0.0, "surface {k}, noise {sigma}");
        }
    }
}

#[test]
fn coarse_steps_and_missing_pixels_do_not_mislead() {
    let (_, frame, plane, sigma) = cases().remove(0);
    let noisy = wall(&frame, plane, |_, _| sigma);
    for step in [0.5 * sigma, sigma, 2.5 * sigma] {
        let image = changed(&noisy, |v| ((f64::from(v) / step).round() * step) as f32);
        let expected = sigma.hypot(step / 12_f64.sqrt());
        let found = estimate_value_sigma(&image);
        println!("steps of {step}: {found:.5} for {expected:.5}");
        assert!((found / expected - 1.0).abs() < 0.2, "steps of {step}: {found}, {expected}");
    }
    let mut random = Normal(5);
    for share in [0.3, 0.65] {
        let image = changed(&noisy, |v| if random.uniform() < share { f32::NAN } else { v });
        let found = estimate_value_sigma(&image);
        assert!((found / sigma - 1.0).abs() < 0.15, "{share} missing: {found} for {sigma}");
    }
    let single = changed(&noisy, |_| 1.0);
    assert_eq!(estimate_value_sigma(&single), 0.0);
}

#[test]
fn curvature_and_jumps_are_not_noise() {
    let bumps: crate::surfaces::Distance = |p| {
        let (x, y, z) = if p.x > p.z { (p.y, p.z, p.x) } else { (p.x, p.y, p.z) };
        let ball = x.hypot(y).hypot(z - 3.0) - 1.0;
        let rods = ((x - 0.25).rem_euclid(0.5) - 0.25).hypot(z - 2.6) - 0.06;
        ball.min(5.0 - z).min(0.9 * rods)
    };
    let spacing = 3.0 / 120.0;
    for frame in [camera(), radar()] {
        let clean = estimate_sigma(&look(&frame, bumps, 0.0, None));
        println!("{:.5} of the spacing without noise", clean / spacing);
        assert!(clean < 0.015 * spacing, "{}", clean / spacing);
        for sigma in [0.2 * spacing, spacing] {
            let found = estimate_sigma(&look(&frame, bumps, sigma, None));
            println!("{found:.5} for {sigma:.5}");
            assert!((found / sigma - 1.0).abs() < 0.25, "{found} for {sigma}");
        }
    }
}

/// The view with another stated noise.
fn stating(view: &View, frame: &Arc<dyn DeviceFrame>, sigma: f64) -> View {
    let image = view.image().clone();
    View::new("stated", image, Arc::clone(frame), Isometry3::identity(), Some(sigma)).unwrap()
}

#[test]
fn a_stated_noise_is_compared_with_the_estimate() {
    for (name, frame, plane, sigma) in cases() {
        let noisy = wall(&frame, plane, |_, _| sigma);
        let length = estimate_sigma(&noisy);
        for (factor, contradicts) in
            [(30.0, true), (4.0, true), (2.0, false), (0.5, false), (0.25, true), (0.0, true)]
        {
            let found = RangeNoise::contradicting(&stating(&noisy, &frame, factor * length));
            assert_eq!(found.is_some(), contradicts, "{name}, {factor} times");
            assert!(found.is_none_or(|found| (found / length - 1.0).abs() < 0.1), "{name}");
            let of_pixels = RangeNoise::of_pixels(&stating(&noisy, &frame, factor * length));
            let more = found.filter(|_| factor < 1.0);
            assert_eq!(of_pixels.length(), more.unwrap_or(factor * length), "{name}, {factor}");
        }
        assert_eq!(RangeNoise::contradicting(&noisy), None, "{name}: an estimate");
        let clean = stating(&wall(&frame, plane, |_, _| 0.0), &frame, 0.0);
        assert_eq!(RangeNoise::contradicting(&clean), None, "{name}: no noise, as stated");
    }
}

#[test]
fn noise_that_hardly_differs_between_neighbours_contradicts_one_far_below_it() {
    const SIDE: usize = 4;
    let (_, frame, plane, sigma) = cases().remove(0);
    let size = frame.size();
    let groups = shared_noise(size, SIDE, 6);
    // Means of means: as smooth as the noise of a matching window.
    let smooth = |p: Pixel| {
        let rows = p.row..(p.row + SIDE).min(size.rows);
        let row = |r: usize| &groups[r * size.cols..][p.col..(p.col + SIDE).min(size.cols)];
        let near: Vec<f64> = rows.flat_map(row).copied().collect();
        near.iter().sum::<f64>() / near.len() as f64
    };
    let mut shared = pixels(size).map(smooth);
    let own = wall(&frame, plane, |_, _| 0.05 * sigma);
    let image = changed(&own, |v| v + (3.0 * sigma * shared.next().unwrap()) as f32);
    let view = own.with_image(image).unwrap();
    let found = estimate_sigma(&view);
    for (factor, is_told) in [(0.2, true), (0.5, false)] {
        let told = RangeNoise::contradicting(&stating(&view, &frame, factor * found));
        assert_eq!(told.is_some(), is_told, "{factor} of the noise is stated: {told:?}");
    }
}

#[test]
fn bends_and_coarse_steps_contradict_no_stated_noise() {
    let waves = |p: &Point3| 0.2 * (3.0 + 0.2 * (8.0 * p.x).sin() * (7.0 * p.y).cos() - p.z);
    let clean = look(&camera(), waves, 0.0, None);
    let bends = estimate_sigma(&clean);
    assert_eq!(RangeNoise::contradicting(&stating(&clean, &camera(), 0.1 * bends)), None);
    let (_, frame, plane, sigma) = cases().remove(0);
    let noisy = wall(&frame, plane, |_, _| 0.02 * sigma);
    let image = changed(&noisy, |v| ((f64::from(v) / sigma).round() * sigma) as f32);
    for stated in [0.02 * sigma, 0.3 * sigma, sigma] {
        let coarse = stating(&noisy.with_image(image.clone()).unwrap(), &frame, stated);
        assert_eq!(RangeNoise::contradicting(&coarse), None, "{stated}");
    }
}
