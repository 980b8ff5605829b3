//! Smoothing what can take part in a curve against smoothing everything, and against itself with
//! other instructions.

use crate::common::normals;
use crate::surfaces::{Normal, camera, look, pixels, radar};
use proptest::prelude::*;
use std::sync::Arc;
use transect_device::{
    DeviceFrame, ImageSize, Isometry3, Pixel, Point3, RangeImage, SensorPlane, Vector3, View,
};
use transect_geometry::{PlaneFamily, StraightGuide};
use transect_image::smooth::{PixelChoice, Smoothed, Smoothing, ValueBounds, smooth_with};
use transect_image::{BreakRule, Instructions, RangeNoise};
use transect_partial::one_pass::{OnePassOptions, partial_model};
use transect_partial::subpixel::Subpixel;
use transect_partial::{SectionAxes, near_planes};
use transect_sensors::{AngularScan, ImagingRadar, LightStripe};

/// Balls in a tube, seen along any axis.
fn scene(p: &Point3) -> f64 {
    let ball = |x: f64, y: f64, z: f64, r: f64| (p - Point3::new(x, y, z)).norm() - r;
    let balls = ball(0.3, 0.2, 3.0, 0.8).min(ball(3.0, 0.2, -0.3, 0.8));
    balls.min(4.0 - p.coords.norm() * 0.5 - p.coords.xy().norm() * 0.5)
}

/// A full circle of 160 columns.
fn circle() -> Arc<dyn DeviceFrame> {
    let theta = AngularScan::from_radians(0.3, std::f64::consts::TAU / 160.0);
    let phi = AngularScan::from_radians(-0.4, 0.02);
    Arc::new(ImagingRadar::new(ImageSize { rows: 40, cols: 160 }, theta, phi).unwrap())
}

/// A wall seen by a light-stripe sensor, whose values are not lengths.
fn before_stripe() -> View {
    let frame: Arc<dyn DeviceFrame> = Arc::new(LightStripe::smart_eye().unwrap());
    let middle = Pixel::new(frame.size().rows / 2, frame.size().cols / 2);
    let seen = (1..400).rev().find_map(|k| frame.point(middle, 2.0 * f64::from(k))).unwrap();
    let normal = Vector3::new(0.1, 0.05, -1.0).normalize();
    let through = Vector3::new(seen.x, seen.y, 0.5 * seen.z);
    let plane = SensorPlane { normal, offset: normal.dot(&through) };
    let mut random = Normal(11);
    let value = |p: Pixel| {
        let d3 = frame.plane_value(p, &plane).filter(|d3| frame.point(p, *d3).is_some());
        d3.map_or(f32::NAN, |d3| (d3 + 0.2 * random.sample()) as f32)
    };
    let values = pixels(frame.size()).map(value).collect();
    let image = RangeImage::from_values(frame.size(), values).unwrap();
    View::new("stripe", image, frame, Isometry3::identity(), None).unwrap()
}

/// Views by different sensors, of known and of estimated noise.
fn noisy_view(which: usize) -> View {
    let of = |frame, ratio: f64, known: bool| {
        let sigma = ratio * 3.0 / 120.0;
        look(&frame, scene, sigma, known.then_some(sigma))
    };
    match which {
        0 => of(camera(), 0.5, true),
        1 => of(camera(), 0.15, false),
        2 => of(radar(), 1.0, true),
        3 => of(circle(), 0.5, true),
        _ => before_stripe(),
    }
}

fn noisy_views() -> impl Iterator<Item = View> {
    (0..5).map(noisy_view)
}

fn with_missing(view: &View, share: f64) -> View {
    let mut random = Normal(3);
    let size = view.image().size();
    let keep = |p: Pixel| view.image().get(p).filter(|_| random.uniform() > share);
    let values = pixels(size).map(keep).map(|v| v.unwrap_or(f32::NAN)).collect();
    view.with_image(RangeImage::from_values(size, values).unwrap()).unwrap()
}

/// The default options, with smoothing near the planes alone or everywhere.
fn options(near_planes: bool) -> OnePassOptions {
    let mut options = OnePassOptions::default();
    options.smoothing.near_planes = near_planes;
    options
}

/// Largest distance of a sample from the sensor.
fn depth(view: &View) -> f64 {
    let points = pixels(view.image().size()).filter_map(|p| view.point_in_sensor(p));
    points.map(|p| p.coords.norm()).fold(0.0, f64::max)
}

/// Compares the models; the shares of the pixels that changed.
fn compare(view: &View, planes: &PlaneFamily) -> Result<[f64; 2], TestCaseError> {
    let [near, all] = [true, false].map(|near| partial_model(view, planes, &options(near)).ok());
    prop_assert_eq!(near.is_some(), all.is_some());
    let (Some(near), Some(all)) = (near, all) else { return Ok([0.0; 2]) };
    // What is printed of a number tells every bit of it.
    prop_assert_eq!(format!("{:?}", near.planes), format!("{:?}", all.planes));
    prop_assert_eq!(near.counts.crossings, all.counts.crossings);
    prop_assert!(near.counts.smoothed <= all.counts.smoothed);
    let valid = view.image().valid_count() as f64;
    Ok([near.counts.smoothed, all.counts.smoothed].map(|count| count as f64 / valid))
}

fn planes(normal: Vector3, offset: f64, interval: f64) -> PlaneFamily {
    PlaneFamily::new(StraightGuide::along(normal).unwrap(), offset, interval).unwrap()
}

#[test]
fn curves_are_those_of_a_view_that_is_smoothed_everywhere() {
    for view in noisy_views() {
        let depth = depth(&view);
        let mut seldom = 1.0_f64;
        for normal in [Vector3::x(), Vector3::y(), Vector3::z(), Vector3::new(0.4, -0.5, 0.7)] {
            for share in [0.003, 0.05, 0.4] {
                let planes = planes(normal, 0.0123, share * depth);
                let [near, all] = compare(&view, &planes).unwrap();
                println!("{:?} {share}: {near:.3} of {all:.3}", normal.as_slice());
                assert!(all > 0.2, "{all}");
                seldom = seldom.min(near / all);
            }
        }
        assert!(seldom < 0.5, "{seldom}");
    }
}

/// The cubic reads the samples before and after a pair, which may be far from every plane.
#[test]
fn cubic_curves_are_those_of_a_view_that_is_smoothed_everywhere() {
    let view = noisy_view(0);
    let planes = planes(Vector3::z(), 0.0123, 0.05 * depth(&view));
    let models = [true, false].map(|near| {
        let mut options = options(near);
        options.subpixel = Subpixel::FourPoint;
        partial_model(&view, &planes, &options).unwrap().planes
    });
    assert!(!models[0].is_empty());
    assert_eq!(format!("{:?}", models[0]), format!("{:?}", models[1]));
}

/// A view that is smoothed near the planes of some axes, or everywhere.
fn smoothed(
    view: &View,
    noise: &RangeNoise,
    rule: &BreakRule,
    near: Option<&SectionAxes>,
    instructions: Instructions,
) -> Smoothed {
    let choice =
        near.map(|axes| move |bounds: &ValueBounds| near_planes(view, axes, bounds, instructions));
    let pixels = choice.as_ref().map(|choice| choice as &PixelChoice<'_>);
    let smoothing = Smoothing { instructions, pixels, ..Smoothing::default() };
    smooth_with(view, noise, rule, &smoothing).unwrap()
}

fn bits(smoothed: &Smoothed) -> Vec<[u32; 2]> {
    let image = smoothed.view.image();
    let values = (0..image.size().rows).flat_map(|row| image.row(row));
    values.zip(&smoothed.sigma_factors).map(|(v, f)| [v.to_bits(), f.to_bits()]).collect()
}

#[test]
fn all_instructions_give_the_same_bits() {
    for view in noisy_views() {
        let noise = RangeNoise::of(&view);
        let rule = BreakRule::new(78_f64.to_radians(), 4.0 * noise.length());
        let depth = depth(&view);
        let axes = SectionAxes::new(&view, &planes(Vector3::y(), 0.0, 0.1 * depth)).unwrap();
        for near in [None, Some(&axes)] {
            let with = |instructions| smoothed(&view, &noise, &rule, near, instructions);
            let best = with(Instructions::Best);
            assert!(best.changed > 100);
            for other in [Instructions::Avx2, Instructions::Portable] {
                assert_eq!(bits(&with(other)), bits(&best), "{other:?}");
            }
        }
    }
}

#[test]
fn all_pixels_of_a_crossed_cell_are_smoothed() {
    for view in noisy_views() {
        let noise = RangeNoise::of(&view);
        let rule = BreakRule::new(78_f64.to_radians(), 4.0 * noise.length());
        let axes =
            SectionAxes::new(&view, &planes(Vector3::new(0.4, -0.5, 0.7), 0.0, 0.2 * depth(&view)));
        let axes = axes.unwrap();
        let with = |near| smoothed(&view, &noise, &rule, near, Instructions::Best);
        let (all, near) = (with(None), with(Some(&axes)));
        let size = view.image().size();
        let (every, some) = (bits(&all), bits(&near));
        let label = |row, col| {
            let p = all.view.point_in_sensor(Pixel::new(row, col));
            p.map(|p| axes.level().at(&p).ceil())
        };
        let mut crossed = 0;
        for p in pixels(size).filter(|p| p.row > 0 && p.col > 0 && p.col + 1 < size.cols) {
            let pair = label(p.row - 1, p.col).zip(label(p.row, p.col));
            if pair.is_some_and(|(a, b)| a != b) {
                crossed += 1;
                for row in p.row - 1..=p.row {
                    for col in p.col - 1..=p.col + 1 {
                        let at = row * size.cols + col;
                        assert_eq!(every[at], some[at], "row {row}, column {col}");
                    }
                }
            }
        }
        assert!(crossed > 20, "{crossed}");
    }
}

/// A bowl that bends by three deviations within a pixel, and whose lowest sample errs by three,
/// too. Smoothing takes that one most of the way back, through a plane that lies more than a
/// deviation beyond all samples.
#[test]
fn a_sample_that_smoothing_moves_by_most_of_what_it_may_counts() {
    let (frame, sigma) = (camera(), 0.1 * 3.0 / 120.0);
    let middle = Pixel::new(frame.size().rows / 2, frame.size().cols / 2);
    let value = |p: Pixel| {
        let (rows, cols) = (p.row.abs_diff(middle.row), p.col.abs_diff(middle.col));
        let squared = (rows * rows + cols * cols).min(25) as f64;
        let error = if p == middle { 3.0 * sigma } else { 0.0 };
        let plane =
            SensorPlane { normal: Vector3::z(), offset: 3.0 + 3.0 * sigma * squared + error };
        frame.plane_value(p, &plane).unwrap() as f32
    };
    let image = RangeImage::from_values(frame.size(), pixels(frame.size()).map(value).collect());
    let pose = Isometry3::identity();
    let view = View::new("bowl", image.unwrap(), frame.clone(), pose, Some(sigma)).unwrap();
    let with = |near_planes, smooth| {
        let mut options = options(near_planes);
        (options.excursion_sigmas, options.smooth) = (0.0, smooth);
        let planes = planes(Vector3::z(), 3.0 + 1.5 * sigma, 50.0);
        let model = partial_model(&view, &planes, &options).unwrap();
        model.planes.iter().map(|p| p.curves.len()).sum::<usize>()
    };
    assert_eq!(with(true, false), 0);
    assert_eq!(with(false, true), 1);
    assert_eq!(with(true, true), 1);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn so_they_are_with_any_planes_and_missing_pixels(
        which in 0..5_usize,
        normal in normals(),
        offset in -1.0..1.0_f64,
        share in 0.01..0.5_f64,
        missing in 0.0..0.3_f64,
    ) {
        let view = &with_missing(&noisy_view(which), missing);
        let depth = depth(view);
        compare(view, &planes(normal, offset * depth, share * depth))?;
    }
}
