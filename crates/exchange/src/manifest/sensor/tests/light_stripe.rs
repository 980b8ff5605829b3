//! Stacks whose stripes were drawn at known places.

use super::*;
use crate::{Counts, write_npy_stack, write_png_image};
use transect_device::{DeviceFrame, SensorPlane, Vector3};
use transect_sensors::light_stripe::stripe::{StripeProfile, StripeShape};
use transect_sensors::{LaserAngles, LightStripe, LightStripeParameters};

const ROWS: usize = 9;
const COLS: usize = 96;
const STEPS: usize = 7;
/// A row of the camera that sees no stripe.
const DARK: usize = 6;
const CAMERA: ImageSize = ImageSize { rows: ROWS, cols: COLS };
const PROFILE: StripeProfile =
    StripeProfile { shape: StripeShape::Triangle, width: 8.0, height: 120.0 };

const KEYS: &str = r#""sensor": "light_stripe", "camera_rows": 9, "camera_cols": 96,
    "focal_length": 16, "cell_width": 0.0672, "cell_height": 0.686, "x_center": 48,
    "y_center": 4, "baseline": 300, "mirror_axis": 16, "mirror_face": 20,
    "fan_angle": 1.0471975511965976, "farthest": 2000"#;

/// The sensor of the keys, by its own constructor.
fn sensor() -> LightStripe {
    let radians = (0..STEPS).map(|k| 1.0 + 0.05 * k as f64).collect();
    LightStripe::new(LightStripeParameters {
        camera_rows: ROWS,
        camera_cols: COLS,
        cell_width: 0.0672,
        cell_height: 0.686,
        x_center: 48.0,
        y_center: 4.0,
        theta_laser: LaserAngles::from_radians(radians),
        ..LightStripeParameters::smart_eye()
    })
    .unwrap()
}

/// Where the stripe of a wall lies in every row and step; `None` where it is not seen.
fn places(frame: &LightStripe) -> Vec<Vec<Option<f64>>> {
    let wall = SensorPlane { normal: Vector3::new(0.0, 0.2, 1.0), offset: 700.0 };
    let place = |row: usize, step: usize| {
        let inside = |x: &f64| (4.5..COLS as f64 - 4.5).contains(x);
        frame.plane_value(Pixel::new(row, step), &wall).filter(inside)
    };
    let seen = |row: usize, step: usize| place(row, step).filter(|_| row != DARK);
    (0..ROWS).map(|row| (0..STEPS).map(|step| seen(row, step)).collect()).collect()
}

/// Images of those stripes, step by step, on an even background.
fn light(places: &[Vec<Option<f64>>]) -> Vec<f64> {
    let cells = (0..STEPS * ROWS * COLS).map(|n| (n / (ROWS * COLS), n / COLS % ROWS, n % COLS));
    let light = |(step, row, col): (usize, usize, usize)| {
        let place: Option<f64> = places[row][step];
        20.0 + place.map_or(0.0, |x| PROFILE.at(col as f64 + 0.5 - x))
    };
    cells.map(light).collect()
}

fn eight_bits() -> Vec<u8> {
    light(&places(&sensor())).iter().map(|v| v.round() as u8).collect()
}

fn sixteen_bits() -> Vec<u16> {
    light(&places(&sensor())).iter().map(|v| (v * 200.0).round() as u16).collect()
}

fn write_stack(folder: &Path, counts: Counts<'_>) {
    let path = folder.join("stack.npy");
    crate::write_file(&path, |out| write_npy_stack(STEPS, CAMERA, counts, out)).unwrap();
}

fn write_images(folder: &Path, counts: Counts<'_>) {
    let path = folder.join("stack");
    std::fs::create_dir(&path).unwrap();
    for step in 0..STEPS {
        let part = step * ROWS * COLS..(step + 1) * ROWS * COLS;
        let counts = match counts {
            Counts::Eight(all) => Counts::Eight(&all[part]),
            Counts::Sixteen(all) => Counts::Sixteen(&all[part]),
        };
        let name = path.join(format!("image_{step:02}.png"));
        crate::write_file(&name, |out| write_png_image(CAMERA, counts, out)).unwrap();
    }
}

fn keys(file: &str, more: &str) -> String {
    format!(r#""file": "{file}", {KEYS}, "theta0": 1, "dtheta": 0.05{more}"#)
}

/// The view of a stack must have every stripe where it was drawn, to 0.05 cells.
fn check(view: &View, what: &str) {
    let (frame, mut found) = (sensor(), 0);
    for (row, places) in places(&frame).iter().enumerate() {
        for (step, place) in places.iter().enumerate() {
            let pixel = Pixel::new(row, step);
            let value = view.image().get(pixel);
            assert_eq!(value.is_some(), place.is_some(), "{what}, {pixel}");
            let Some((value, place)) = value.zip(*place) else { continue };
            assert!((f64::from(value) - place).abs() < 0.05, "{what}, {pixel}: {value} {place}");
            let point = view.point_in_sensor(pixel).unwrap();
            let drawn = frame.point(pixel, place).unwrap();
            assert!((point - drawn).norm() < 0.5, "{what}: a cell is worth some 7 mm here");
            found += 1;
        }
    }
    assert!(found >= 40, "{what}: {found}");
}

#[test]
fn stacks_of_both_depths_and_kinds_show_where_the_stripe_was() {
    let (eight, sixteen) = (eight_bits(), sixteen_bits());
    for (counts, height) in [(Counts::Eight(&eight), 120), (Counts::Sixteen(&sixteen), 24000)] {
        let stripe = format!(r#", "stripe": {{ "height": {height} }}"#);
        for more in [stripe.as_str(), ""] {
            let array = scan_folder(&[&keys("stack.npy", more)]);
            write_stack(array.path(), counts);
            let images = scan_folder(&[&keys("stack", more)]);
            write_images(images.path(), counts);
            for folder in [array, images] {
                let (view, notes) = load(folder.path()).unwrap();
                check(&view, &format!("height {height}{more}"));
                assert_eq!(notes.len(), usize::from(more.is_empty()), "{notes:?}");
                let measured = notes.iter().all(|n| n.text.contains("\"stripe.height\" taken as"));
                assert!(measured, "{notes:?}");
            }
        }
    }
}

#[test]
fn a_median_over_more_rows_than_there_are_is_over_all_rows() {
    let all = keys("stack.npy", r#", "stripe": { "height": 120, "median_rows": 1000000000001 }"#);
    let folder = scan_folder(&[&all]);
    write_stack(folder.path(), Counts::Eight(&eight_bits()));
    check(&load(folder.path()).unwrap().0, "median over all rows");
}

#[test]
fn an_image_of_places_is_taken_as_it_is() {
    let angles: Vec<String> = (0..STEPS).map(|k| (1.0 + 0.05 * k as f64).to_string()).collect();
    let listed = format!(
        r#""file": "x.npy", {KEYS}, "theta_laser": [{}], "rows": 9, "cols": 7, "stripe": {{}}"#,
        angles.join(", ")
    );
    let folder = scan_folder(&[&listed]);
    let places = places(&sensor());
    let values = places.iter().flatten().map(|p| p.map_or(f32::NAN, |x| x as f32));
    let path = folder.path().join("x.npy");
    write_npy(&path, &[ROWS, STEPS], &values.collect::<Vec<_>>());
    let (view, notes) = load(folder.path()).unwrap();
    check(&view, "x_frame");
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(notes[0].text.ends_with("\"stripe\" is not used: the image is no stack"), "{notes:?}");
}

#[test]
fn every_image_of_a_folder_is_an_input() {
    let folder = scan_folder(&[&keys("stack", "")]);
    write_images(folder.path(), Counts::Eight(&eight_bits()));
    let scan = Scan::open(folder.path()).unwrap();
    assert_eq!(scan.inputs.len(), 1 + STEPS);
    assert!(scan.inputs[2].ends_with("stack/image_01.png"), "{:?}", scan.inputs);
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    replace(folder.path(), "\"stack\"", "\"empty\"");
    let error = Scan::open(folder.path()).unwrap_err().to_string();
    assert!(error.contains("empty: no .png images in this folder"), "{error}");
}

#[test]
fn bad_parameters_name_their_key() {
    let counts = eight_bits();
    let stack = |folder: &Path| write_stack(folder, Counts::Eight(&counts));
    let stripe = keys("stack.npy", r#", "stripe": { "height": 120, "width": 8 }"#);
    let wrong = |from: &str, to: &str| error_with(&stripe, from, to, stack);
    let steps = "\"theta0\": 1, \"dtheta\": 0.05";
    for (error, wanted) in [
        (wrong("length\": 16", "length\": 0"), "focal_length = 0: a positive length"),
        (wrong("_width\": 0.0672", "_width\": -1"), "cell_width = -1: a positive length"),
        (wrong("\"fan_angle\": 1.0", "\"fan_angle\": 4.0"), "fan_angle = 4.04"),
        (wrong("\"farthest\": 2000", "\"farthest\": 3"), "farthest = 3: a depth beyond"),
        (wrong("\"dtheta\": 0.05", "\"dtheta\": 0"), "theta_laser = 1: angles that all"),
        (
            wrong(steps, "\"theta_laser\": [1, 1.1, 1.05, 1.2, 1.3, 1.4, 1.5]"),
            "theta_laser = 1.05: angles that all increase or all decrease",
        ),
        (
            wrong(steps, "\"theta_laser\": [1, 1.1, null, 1.2, 1.3, 1.4, 1.5]"),
            "\"theta_laser\": invalid type: null",
        ),
        (
            wrong(steps, "\"theta_laser\": [1, 1.1, 1.2]"),
            "stack.npy: the stack has 7 images, but \"theta_laser\" has 3 angles",
        ),
        (
            wrong("\"baseline\"", "\"cols\": 8, \"baseline\""),
            "stack.npy: the image has 9 rows × 7 columns, but the manifest or the \
             camera file states 9 rows × 8",
        ),
        (
            wrong("\"baseline\"", "\"rows\": 8, \"baseline\""),
            "stack.npy: the image has 9 rows × 7 columns, but the manifest or the \
             camera file states 8 rows × 7",
        ),
        (
            wrong("camera_cols\": 96", "camera_cols\": 97"),
            "images have 9 rows × 96 columns, but the camera 9 rows × 97 columns",
        ),
        (wrong("\"width\": 8", "\"width\": 1"), "\"stripe\" is not usable: stripe_width = 1"),
        (wrong("\"height\": 120", "\"height\": 0"), "stripe_height = 0: a positive number"),
        (wrong("\"width\": 8", "\"width\": 1e12"), "stripe_width = 1000000000000: a stripe narr"),
        (wrong("\"width\": 8", "\"median_rows\": 4"), "median_rows = 4: an odd number"),
        (wrong("\"width\": 8", "\"median_rows\": 1000000000000"), "an odd number of rows"),
        (wrong("\"width\": 8", "\"least_height\": 121"), "least_height = 121"),
    ] {
        assert!(error.contains(wanted), "{error}");
    }
}

#[test]
fn images_that_contradict_the_camera_name_their_file() {
    let counts = eight_bits();
    let folder = scan_folder(&[&keys("stack", "")]);
    write_images(folder.path(), Counts::Eight(&counts));
    let third = folder.path().join("stack/image_02.png");
    let other = ImageSize { rows: ROWS, cols: 2 };
    let write =
        |out: &mut dyn std::io::Write| write_png_image(other, Counts::Eight(&[0; 2 * ROWS]), out);
    crate::write_file(&third, write).unwrap();
    let wanted = "image_02.png: the image has 9 rows × 2 columns, but the camera";
    assert!(error(folder.path()).contains(wanted), "{}", error(folder.path()));
    let flat = scan_folder(&[&keys("x.npy", "")]);
    write_npy(&flat.path().join("x.npy"), &[8, 7], &[40.0; 56]);
    let wanted = "x.npy: the image has 8 rows, but \"camera_rows\" is 9";
    assert!(error(flat.path()).ends_with(wanted), "{}", error(flat.path()));
}

#[test]
fn a_stack_without_light_has_no_valid_pixel() {
    let folder = scan_folder(&[&keys("stack.npy", "")]);
    write_stack(folder.path(), Counts::Eight(&[0; STEPS * ROWS * COLS]));
    assert!(error(folder.path()).contains("every pixel is missing"));
}
