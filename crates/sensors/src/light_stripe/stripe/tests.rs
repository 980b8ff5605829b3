//! Synthetic stripes at known places.

use super::*;
use crate::light_stripe::{LaserAngles, LightStripeParameters};
use transect_device::ImageSize;

const COLS: usize = 96;

/// What rounding to whole counts can do to a stripe 8 cells wide and 120 counts high.
const ROUNDING: f64 = 8.0 * 0.5 / (1.75 * 120.0);

/// Rows of 8-bit counts: `light(row, column)`, rounded and cut off like a camera does.
fn image_u8(rows: usize, light: impl Fn(usize, usize) -> f64) -> IntensityImage {
    let cells = (0..rows * COLS).map(|k| light(k / COLS, k % COLS));
    let counts = cells.map(|v| v.round().clamp(0.0, 255.0) as u8).collect();
    IntensityImage::from_u8(ImageSize { rows, cols: COLS }, counts).unwrap()
}

/// The same with 16 bits, 256 times as many counts.
fn image_u16(rows: usize, light: impl Fn(usize, usize) -> f64) -> IntensityImage {
    let cells = (0..rows * COLS).map(|k| 256.0 * light(k / COLS, k % COLS));
    let counts = cells.map(|v| v.round().clamp(0.0, 65535.0) as u16).collect();
    IntensityImage::from_u16(ImageSize { rows, cols: COLS }, counts).unwrap()
}

/// Light of a stripe whose middle is `x` cells from the edge, in the cell's centre.
fn stripe(profile: &StripeProfile, x: f64, col: usize) -> f64 {
    profile.at(col as f64 + 0.5 - x)
}

fn plain(profile: StripeProfile, peak: Peak) -> StripeFinder {
    StripeFinder { median_rows: 1, peak, ..StripeFinder::new(profile) }
}

fn in_u16(profile: StripeProfile) -> StripeProfile {
    StripeProfile { height: 256.0 * profile.height, ..profile }
}

/// Pseudo-random numbers with mean 0 and standard deviation 1: twelve uniform ones each.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    let mut uniform = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    move || (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}

#[test]
fn whole_cells_are_found_exactly() {
    let profile = StripeProfile::triangle(8.0, 120.0);
    let image = image_u8(40, |row, col| 20.0 + stripe(&profile, 20.5 + row as f64, col));
    for peak in [Peak::WholeCell, Peak::SubCell] {
        let curve = plain(profile, peak).curve(&image).unwrap();
        for (row, place) in curve.iter().enumerate() {
            assert_eq!(*place, Some(20.5 + row as f64), "the centre of cell {}", 20 + row);
        }
    }
}

/// Largest error over 60 places that move through a cell.
fn worst_error(image: &IntensityImage, finder: StripeFinder, first: f64, step: f64) -> f64 {
    let curve = finder.curve(image).unwrap();
    let errors = curve
        .iter()
        .enumerate()
        .map(|(row, place)| (place.unwrap() - (first + step * row as f64)).abs());
    errors.fold(0.0, f64::max)
}

#[test]
fn fractions_of_a_cell_are_found_as_well_as_documented() {
    let (first, step) = (30.0, 0.05);
    let profile = StripeProfile::triangle(8.0, 120.0);
    let light = |row: usize, col: usize| 20.0 + stripe(&profile, first + step * row as f64, col);
    let eight = worst_error(&image_u8(60, light), plain(profile, Peak::SubCell), first, step);
    let finder = plain(in_u16(profile), Peak::SubCell);
    let sixteen = worst_error(&image_u16(60, light), finder, first, step);
    let whole = worst_error(&image_u8(60, light), plain(profile, Peak::WholeCell), first, step);
    println!("triangle: 8 bits {eight:.5}, 16 bits {sixteen:.6}, whole cells {whole:.3}");
    // Eight cells rounded by up to 0.5 counts, over a balance of 1.75 · 120 counts per cell.
    assert!(eight < ROUNDING, "{eight}");
    assert!(sixteen < 5e-5, "{sixteen}");
    assert!((0.45..=0.5 + 1e-9).contains(&whole), "{whole}");
}

#[test]
fn stripes_of_other_shapes_have_a_small_bias() {
    let (first, step) = (30.0, 0.05);
    for (width, drawn) in
        [(8.0, 8.0), (8.0, 6.0), (8.0, 11.0), (7.0, 7.0), (5.0, 5.0), (12.0, 12.0)]
    {
        let gaussian = StripeProfile::gaussian(drawn, 120.0);
        let light =
            |row: usize, col: usize| 20.0 + stripe(&gaussian, first + step * row as f64, col);
        let image = image_u16(60, light);
        let finder = plain(in_u16(StripeProfile::triangle(width, 120.0)), Peak::SubCell);
        let error = worst_error(&image, finder, first, step);
        println!("gaussian of width {drawn} by a triangle of width {width}: {error:.4}");
        assert!(error < 0.02, "{error}");
    }
}

#[test]
fn noise_moves_the_peak_as_much_as_documented() {
    let profile = StripeProfile::triangle(8.0, 120.0);
    let (rows, sigma) = (4000, 3.0);
    let mut next = noise(7);
    let noisy: Vec<f64> = (0..rows * COLS).map(|_| sigma * next()).collect();
    let place = |row: usize| 30.0 + (row % 37) as f64 / 37.0;
    let image = image_u16(rows, |row, col| {
        60.0 + stripe(&profile, place(row), col) + noisy[row * COLS + col]
    });
    let curve = plain(in_u16(profile), Peak::SubCell).curve(&image).unwrap();
    let squares = curve.iter().enumerate().map(|(row, x)| (x.unwrap() - place(row)).powi(2));
    let deviation = (squares.sum::<f64>() / rows as f64).sqrt();
    let predicted = sigma * 8.0_f64.sqrt() / (1.75 * 120.0);
    println!("noise: {deviation:.5} cells, predicted {predicted:.5}");
    // 4000 rows tell a deviation to 1 %.
    assert!((deviation / predicted - 1.0).abs() < 0.05, "{deviation} {predicted}");
}

#[test]
fn background_light_drops_out_and_its_slope_nearly_does() {
    let profile = StripeProfile::triangle(8.0, 120.0);
    for background in [0.0, 60.0, 130.0] {
        let image =
            image_u8(20, |row, col| background + stripe(&profile, 40.25 + 0.1 * row as f64, col));
        let error = worst_error(&image, plain(profile, Peak::SubCell), 40.25, 0.1);
        assert!(error < ROUNDING, "{background}: {error}");
    }
    // One count per cell moves the peak by n(n + 1) / (2 - 1/n) h towards the light, n = 4.
    let image = image_u8(1, |_, col| col as f64 + stripe(&profile, 40.5, col));
    let place = plain(profile, Peak::SubCell).curve(&image).unwrap()[0].unwrap();
    assert!((place - 40.5 - 20.0 / (1.75 * 120.0)).abs() < 1e-9, "{place}");
}

#[test]
fn a_specular_second_peak_is_passed_over() {
    let profile = StripeProfile::triangle(8.0, 100.0);
    let second = [
        ("dimmer", StripeProfile::triangle(8.0, 60.0)),
        ("saturated and wide", StripeProfile::triangle(24.0, 500.0)),
        ("a spark", StripeProfile::triangle(2.0, 220.0)),
    ];
    for (name, second) in second {
        for at in [25.5, 62.5] {
            let image =
                image_u8(4, |_, col| 30.0 + stripe(&profile, 45.5, col) + stripe(&second, at, col));
            let curve = plain(profile, Peak::SubCell).curve(&image).unwrap();
            let place = curve[0].unwrap();
            assert!((place - 45.5).abs() < 0.05, "{name} at {at}: {place}");
        }
    }
}

/// The window's brightest cell may belong to a slope that only reaches into it.
#[test]
fn a_bright_slope_at_the_windows_rim_is_not_the_stripe() {
    let template = StripeProfile::triangle(8.0, 100.0);
    let finder = plain(template, Peak::WholeCell);
    let image = image_u8(1, |_, col| {
        let flare = if col >= 49 { 60.0 * (col as f64 - 48.0) } else { 0.0 };
        20.0 + stripe(&template, 45.5, col) + flare
    });
    let place = finder.curve(&image).unwrap()[0].unwrap();
    assert!((place - 45.5).abs() < 1e-9, "{place}");
}

#[test]
fn a_saturated_stripe_counts_as_the_middle_of_its_top() {
    let bright = StripeProfile::triangle(12.0, 380.0);
    let image = image_u8(3, |row, col| 10.0 + stripe(&bright, 50.5 + 0.5 * row as f64, col));
    let template = StripeProfile::triangle(12.0, 240.0);
    for (peak, allowed) in [(Peak::WholeCell, 1e-9), (Peak::SubCell, 1e-9)] {
        let curve = plain(template, peak).curve(&image).unwrap();
        for (row, place) in curve.iter().enumerate() {
            let error = place.unwrap() - (50.5 + 0.5 * row as f64);
            assert!(error.abs() <= allowed, "{peak:?} row {row}: {error}");
        }
    }
}

#[test]
fn rows_without_a_stripe_are_missing() {
    let profile = StripeProfile::triangle(8.0, 100.0);
    let mut next = noise(3);
    let grain: Vec<f64> = (0..12 * COLS).map(|_| 2.0 * next()).collect();
    let dark = |row: usize| (4..8).contains(&row);
    let image = image_u8(12, |row, col| {
        let light = if dark(row) { 0.0 } else { stripe(&profile, 45.5, col) };
        40.0 + light + grain[row * COLS + col]
    });
    // With the median on: it must not fill the gap.
    let curve = StripeFinder::new(profile).curve(&image).unwrap();
    for (row, place) in curve.iter().enumerate() {
        assert_eq!(place.is_none(), dark(row), "row {row}: {place:?}");
    }
    // A faint stripe counts if the finder's least height is small.
    let faint = image_u8(1, |_, col| 40.0 + 0.2 * stripe(&profile, 45.5, col));
    let usual = plain(profile, Peak::SubCell);
    assert_eq!(usual.curve(&faint).unwrap(), [None]);
    let patient = StripeFinder { least_height: 15.0, ..usual };
    assert!(patient.curve(&faint).unwrap()[0].is_some());
    let level = image_u8(2, |_, _| 255.0);
    assert_eq!(usual.curve(&level).unwrap(), [None, None]);
}

#[test]
fn the_median_moves_outliers_and_leaves_a_leaning_stripe_alone() {
    let leaning: Vec<_> = (0..9).map(|k| Some(10.0 + 0.7 * k as f64)).collect();
    assert_eq!(median_along(&leaning, 5), leaning, "also at both ends");
    let mut broken = leaning.clone();
    broken[4] = Some(80.0);
    let mended = median_along(&broken, 5);
    assert!((mended[4].unwrap() - 12.8).abs() < 0.71, "{mended:?}");
    let mut gap = leaning.clone();
    gap[3] = None;
    let kept = median_along(&gap, 5);
    assert_eq!(kept[3], None);
    assert_eq!((kept[2], kept[4]), (leaning[2], leaning[4]), "the gap moves no row");
    assert_eq!(median_along(&broken, 1), broken);
}

fn small_sensor() -> LightStripe {
    let mut parameters = LightStripeParameters::smart_eye();
    (parameters.camera_rows, parameters.camera_cols) = (7, COLS);
    parameters.cell_width *= 8.0;
    parameters.cell_height *= 70.0;
    (parameters.x_center, parameters.y_center) = (48.0, 3.0);
    parameters.theta_laser = LaserAngles::equal_steps_degrees(58.0, 3.0, 7);
    LightStripe::new(parameters).unwrap()
}

/// From light to range image: the stripes of a wall give back the wall's depth.
#[test]
fn a_stack_of_images_becomes_the_range_image_of_the_scene() {
    let frame = small_sensor();
    let wall = transect_device::SensorPlane { normal: nalgebra::Vector3::z(), offset: 700.0 };
    let profile = StripeProfile::triangle(8.0, 120.0);
    let place = |row: usize, col: usize| frame.plane_value(Pixel::new(row, col), &wall);
    let images: Vec<_> = (0..7)
        .map(|angle| {
            image_u8(7, |row, col| {
                30.0 + place(row, angle).map_or(0.0, |x| stripe(&profile, x, col))
            })
        })
        .collect();
    let image = extract(&frame, &images, StripeFinder::new(profile)).unwrap();
    let mut found = 0;
    for row in 0..7 {
        for col in 0..7 {
            let Some(d3) = image.get(Pixel::new(row, col)) else { continue };
            let p = frame.point(Pixel::new(row, col), f64::from(d3)).unwrap();
            // A cell is worth about 6.5 mm of depth here.
            assert!((p.z - 700.0).abs() < 7.0 * ROUNDING, "row {row}, column {col}: {}", p.z);
            found += 1;
        }
    }
    assert!(found >= 40, "{found} of 49");
}

#[test]
fn bad_settings_and_stacks_are_named() {
    let profile = StripeProfile::triangle(8.0, 100.0);
    let image = image_u8(7, |_, _| 0.0);
    let message = |finder: StripeFinder| finder.curve(&image).unwrap_err().to_string();
    let good = StripeFinder::new(profile);
    let thin = StripeFinder::new(StripeProfile::triangle(1.0, 100.0));
    assert_eq!(message(thin), "stripe_width = 1: at least 2 cells");
    let flat = StripeFinder::new(StripeProfile::triangle(8.0, 0.0));
    assert_eq!(message(flat), "stripe_height = 0: a positive number of counts");
    let absurd = StripeFinder::new(StripeProfile::triangle(1e15, 9.0));
    assert!(message(absurd).contains("a stripe narrower than the image"), "refused, not allocated");
    let patient = StripeFinder { median_rows: usize::MAX, ..good };
    assert_eq!(patient.curve(&image).unwrap(), vec![None; 7]);
    let wide = StripeFinder::new(StripeProfile::triangle(200.0, 9.0));
    assert_eq!(message(wide), "stripe_width = 200: a stripe narrower than the image");
    let even = StripeFinder { median_rows: 4, ..good };
    assert_eq!(message(even), "median_rows = 4: an odd number of rows");
    let high = StripeFinder { least_height: 101.0, ..good };
    assert!(message(high).starts_with("least_height = 101"));
    let infinite = StripeFinder::new(StripeProfile::triangle(f64::INFINITY, 9.0));
    assert!(message(infinite).starts_with("stripe_width = inf"));

    let frame = small_sensor();
    let error = |images: &[IntensityImage]| extract(&frame, images, good).unwrap_err().to_string();
    let seven = vec![image.clone(); 7];
    assert_eq!(error(&seven[..6]), "images = 6: one image per laser angle");
    assert_eq!(error(&vec![image; 8]), "images = 8: one image per laser angle");
    let low = image_u8(6, |_, _| 0.0);
    assert_eq!(error(&[low]), "image_rows = 6: as many rows as the camera");
    assert_eq!(extract(&frame, &seven, good).unwrap().valid_count(), 0);
    let size = ImageSize { rows: 2, cols: 3 };
    assert!(IntensityImage::from_u8(size, vec![0; 5]).is_err());
    assert!(IntensityImage::from_u16(ImageSize { rows: 0, cols: 3 }, Vec::new()).is_err());
}
