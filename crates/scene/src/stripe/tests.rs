use super::*;
use crate::test_frames::SheetOfLight;
use crate::{Shape, Solid};
use transect_device::Vector3;

const ROWS: usize = 24;
const STEPS: usize = 40;
const FRAME: SheetOfLight =
    SheetOfLight { size: ImageSize { rows: ROWS, cols: STEPS }, base_line: 3.0 };
const CAMERA: StripeCamera = StripeCamera {
    columns: 400,
    depth: BitDepth::Sixteen,
    width: 4.0,
    peak: 40_000.0,
    background: 0.0,
    speckle: 0.0,
    read_noise: 0.0,
    seed: 8,
};

/// Slopes of the line of sight from -1 to 1, which are values from 3 to 5, in 400 columns.
fn column(_pixel: Pixel, d3: f64) -> Option<f64> {
    Some(199.5 + 200.0 * (d3 - 4.0))
}

fn wall(reflectivity: f64) -> Scene {
    let slab = Shape::cuboid(Vector3::new(40.0, 40.0, 1.0)).unwrap();
    let slab = Solid::new(slab, Isometry3::translation(0.0, 0.0, 10.5)).unwrap();
    Scene::new(vec![slab.with_reflectivity(reflectivity).unwrap()])
}

fn images(scene: &Scene, camera: &StripeCamera) -> StripeImages {
    scene.stripe_images(&FRAME, &Isometry3::identity(), camera, &column, 1).unwrap()
}

fn row_of(images: &StripeImages, row: usize, step: usize) -> Vec<f64> {
    let range = row * images.size.cols..(row + 1) * images.size.cols;
    match images.image(step).unwrap() {
        Counts::Eight(counts) => counts[range].iter().map(|&c| f64::from(c)).collect(),
        Counts::Sixteen(counts) => counts[range].iter().map(|&c| f64::from(c)).collect(),
    }
}

fn spread(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt())
}

#[test]
fn the_stripe_is_where_the_surface_is_as_bright_as_its_material_and_as_wide_as_asked() {
    let images = images(&wall(0.5), &CAMERA);
    for step in 0..STEPS {
        let angle = FRAME.angle(step);
        let expected = 199.5 + 200.0 * (angle.tan() - 0.3);
        let Some(found) = images.true_column(3, step) else {
            assert!(!(-0.5..399.5).contains(&expected), "step {step}");
            continue;
        };
        assert!((found - expected).abs() < 1e-9);
        let row = row_of(&images, 3, step);
        if !(10.0..390.0).contains(&found) {
            continue;
        }
        let sum: f64 = row.iter().sum();
        let centroid = row.iter().enumerate().map(|(k, v)| k as f64 * v).sum::<f64>() / sum;
        assert!((centroid - expected).abs() < 1e-3, "{centroid} against {expected}");
        // A bell of full width w at half its height h has the area h w √(π / ln 2) / 2.
        let height = 40_000.0 * 0.5 * angle.cos();
        let area = height * 4.0 * 0.5 * (std::f64::consts::PI / 2f64.ln()).sqrt();
        assert!((sum / area - 1.0).abs() < 1e-3, "{sum} against {area}");
        let brightest = row.iter().copied().fold(0.0, f64::max);
        assert!(brightest <= height + 0.5 && brightest > 0.95 * height);
    }
}

#[test]
fn background_read_noise_and_speckle_have_the_spread_asked_for() {
    let quiet = StripeCamera { background: 900.0, read_noise: 25.0, ..CAMERA };
    let dark: Vec<f64> = {
        let images = images(&wall(1.0), &quiet);
        let far = |k: usize, x: f64| (k as f64 - x).abs() > 2.5 * quiet.width;
        let rows = (0..ROWS).flat_map(|r| (0..STEPS).map(move |s| (r, s)));
        let of = |(r, s)| (row_of(&images, r, s), images.true_column(r, s).unwrap_or(-99.0));
        let kept = |(row, x): (Vec<f64>, f64)| {
            row.into_iter().enumerate().filter(move |&(k, _)| far(k, x)).map(|(_, v)| v)
        };
        rows.map(of).flat_map(kept).collect()
    };
    let ((mean, sigma), n) = (spread(&dark), dark.len() as f64);
    // Rounding to counts adds a variance of 1/12.
    let expected = (25f64 * 25.0 + 1.0 / 12.0).sqrt();
    assert!((mean - 900.0).abs() < 4.0 * 25.0 / n.sqrt(), "{mean}");
    assert!((sigma / expected - 1.0).abs() < 4.0 / (2.0 * n).sqrt(), "{sigma}");

    let (clean, grainy) =
        (images(&wall(1.0), &CAMERA), images(&wall(1.0), &StripeCamera { speckle: 0.3, ..CAMERA }));
    let bright = |&(c, _): &(f64, f64)| c > 5000.0;
    let rows = (0..ROWS).flat_map(|r| (0..STEPS).map(move |s| (r, s)));
    let grains: Vec<f64> = rows
        .flat_map(|(r, s)| row_of(&clean, r, s).into_iter().zip(row_of(&grainy, r, s)))
        .filter(bright)
        .map(|(c, g)| g / c)
        .collect();
    let ((mean, contrast), n) = (spread(&grains), grains.len() as f64);
    assert!(n > 3000.0 && (mean - 1.0).abs() < 4.0 * 0.3 / n.sqrt(), "{mean} of {n}");
    // The fourth moment of a gamma variable of this contrast makes its spread a little less sure.
    assert!((contrast / 0.3 - 1.0).abs() < 5.0 / (2.0 * n).sqrt(), "{contrast}");
}

#[test]
fn eight_bits_saturate_at_255() {
    let camera = StripeCamera { depth: BitDepth::Eight, peak: 400.0, background: 20.0, ..CAMERA };
    let images = images(&wall(1.0), &camera);
    let Counts::Eight(counts) = &images.counts else { panic!("eight bits expected") };
    assert_eq!(counts.len(), ROWS * STEPS * 400);
    assert_eq!(images.image(STEPS), None);
    assert_eq!(counts.iter().max(), Some(&255));
    assert_eq!(counts.iter().min(), Some(&20));
}

#[test]
fn where_laser_or_camera_reaches_nothing_there_is_no_stripe() {
    let mut solids = wall(1.0).solids().to_vec();
    let post = Shape::cuboid(Vector3::new(0.4, 40.0, 4.0)).unwrap();
    solids.push(Solid::new(post, Isometry3::translation(0.5, 0.0, 8.0)).unwrap());
    let scene = Scene::new(solids);
    let images = images(&scene, &CAMERA);
    let range = scene.cast(&FRAME, &Isometry3::identity()).unwrap();
    let mut hidden = 0;
    for step in 0..STEPS {
        let seen =
            range.get(Pixel::new(5, step)).and_then(|d3| column(Pixel::new(5, step), d3.into()));
        let inside = seen.filter(|c| (-0.5..399.5).contains(c));
        assert_eq!(images.true_column(5, step).is_some(), inside.is_some(), "step {step}");
        let lit = row_of(&images, 5, step).iter().any(|&v| v > 0.0);
        assert_eq!(lit, inside.is_some());
        hidden += usize::from(range.get(Pixel::new(5, step)).is_none());
    }
    assert!(hidden > 0);
    assert_eq!(images.true_column(0, STEPS), None);
    assert_eq!(images.true_column(ROWS, 0), None);
}

#[test]
fn same_seed_same_images() {
    let noisy = StripeCamera { speckle: 0.5, read_noise: 3.0, background: 50.0, ..CAMERA };
    assert_eq!(images(&wall(0.7), &noisy).counts, images(&wall(0.7), &noisy).counts);
    let other = StripeCamera { seed: 9, ..noisy };
    assert_ne!(images(&wall(0.7), &noisy).counts, images(&wall(0.7), &other).counts);
}

#[test]
fn bad_settings_are_named() {
    for (camera, key) in [
        (StripeCamera { width: 0.0, ..CAMERA }, "width"),
        (StripeCamera { peak: f64::NAN, ..CAMERA }, "peak"),
        (StripeCamera { background: -1.0, ..CAMERA }, "background"),
        (StripeCamera { speckle: 1.5, ..CAMERA }, "speckle"),
        (StripeCamera { read_noise: f64::INFINITY, ..CAMERA }, "read_noise"),
    ] {
        let found = wall(1.0).stripe_images(&FRAME, &Isometry3::identity(), &camera, &column, 0);
        assert!(found.unwrap_err().to_string().starts_with(key), "{key}");
    }
    let huge = StripeCamera { columns: 1 << 40, ..CAMERA };
    let found = wall(1.0).stripe_images(&FRAME, &Isometry3::identity(), &huge, &column, 0);
    assert!(matches!(found, Err(StripeError::Image(_))));
}
