//! The dissertation's light-stripe sensor from light to range: images of the face mask, and what
//! the extraction finds in them.

use std::f64::consts::PI;
use transect_device::{DeviceFrame, ImageSize, Pixel, RangeImage};
use transect_geometry::{Isometry3, Vector3};
use transect_scene::{BitDepth, Counts, Scene, Shape, Solid, StripeCamera, fixtures};
use transect_sensors::light_stripe::stripe::{
    IntensityImage, StripeFinder, StripeProfile, StripeStack,
};
use transect_sensors::{LaserAngles, LightStripe, LightStripeParameters};

const CAMERA: StripeCamera = StripeCamera {
    columns: 768,
    depth: BitDepth::Eight,
    width: 4.0,
    peak: 150.0,
    background: 30.0,
    speckle: 0.0,
    read_noise: 0.0,
    seed: 5,
};

/// The dissertation's, with every eighth row and every fifth angle.
fn sensor() -> LightStripe {
    let full = LightStripeParameters::smart_eye();
    LightStripe::new(LightStripeParameters {
        camera_rows: 61,
        cell_height: 8.0 * full.cell_height,
        y_center: 30.0,
        theta_laser: LaserAngles::equal_steps_degrees(58.0, 0.45, 40),
        ..full
    })
    .unwrap()
}

/// The mask at the working depth, turned towards the sensor.
fn scene() -> Scene {
    let mask = Shape::mesh(&fixtures::face_mask()).unwrap();
    let pose = Isometry3::new(Vector3::new(0.0, 0.0, 760.0), Vector3::new(PI, 0.0, 0.0));
    Scene::new(vec![Solid::new(mask, pose).unwrap().with_reflectivity(0.8).unwrap()])
}

fn extracted(sensor: &LightStripe, camera: &StripeCamera) -> RangeImage {
    // Values count cells from the array's edge, columns their centres.
    let column = |_: Pixel, d3: f64| Some(d3 - 0.5);
    let pose = Isometry3::identity();
    let images = scene().stripe_images(sensor, &pose, camera, &column, 0).unwrap();
    let finder = StripeFinder::new(StripeProfile::triangle(8.0, 100.0));
    let mut stack = StripeStack::new(sensor, finder).unwrap();
    for step in 0..images.steps {
        let image = match images.image(step).unwrap() {
            Counts::Eight(counts) => IntensityImage::from_u8(images.size, counts),
            Counts::Sixteen(counts) => IntensityImage::from_u16(images.size, counts),
        };
        stack.push(&image.unwrap()).unwrap();
    }
    stack.finish().unwrap()
}

/// Differences of the found values from the true ones, and how many were found or true alone.
fn compare(found: &RangeImage, truth: &RangeImage) -> (Vec<f64>, usize) {
    let ImageSize { rows, cols } = truth.size();
    let pixels = (0..rows * cols).map(|k| Pixel::new(k / cols, k % cols));
    let (mut differences, mut alone) = (Vec::new(), 0);
    for pixel in pixels {
        match (found.get(pixel), truth.get(pixel)) {
            (Some(f), Some(t)) => differences.push((f64::from(f) - f64::from(t)).abs()),
            (None, None) => {}
            _ => alone += 1,
        }
    }
    differences.sort_by(f64::total_cmp);
    (differences, alone)
}

#[test]
fn the_stripes_are_found_where_the_surface_is() {
    let sensor = sensor();
    let truth = scene().cast(&sensor, &Isometry3::identity()).unwrap();
    assert!(truth.valid_count() > 600, "{}", truth.valid_count());
    let (differences, alone) = compare(&extracted(&sensor, &CAMERA), &truth);
    let (median, p90) =
        (differences[differences.len() / 2], differences[differences.len() * 9 / 10]);
    println!("{} found, {alone} alone, median {median}, p90 {p90} cells", differences.len());
    assert!(alone * 50 < truth.valid_count(), "{alone} of {}", truth.valid_count());
    assert!(median < 0.03 && p90 < 0.2, "{median} {p90}");
}

#[test]
fn speckle_and_noise_blur_them_by_parts_of_a_cell() {
    let sensor = sensor();
    let truth = scene().cast(&sensor, &Isometry3::identity()).unwrap();
    let noisy = StripeCamera { speckle: 0.2, read_noise: 2.0, ..CAMERA };
    let (differences, alone) = compare(&extracted(&sensor, &noisy), &truth);
    let median = differences[differences.len() / 2];
    println!("{} found, {alone} alone, median {median} cells", differences.len());
    assert!(alone * 20 < truth.valid_count(), "{alone} of {}", truth.valid_count());
    assert!((0.03..0.4).contains(&median), "{median}");
}

#[test]
fn the_face_throws_shadows_on_both_sides() {
    let sensor = sensor();
    let (scene, pose) = (scene(), Isometry3::identity());
    let truth = scene.cast(&sensor, &pose).unwrap();
    let ImageSize { rows, cols } = truth.size();
    let hidden = (0..rows * cols).map(|k| Pixel::new(k / cols, k % cols)).filter(|&pixel| {
        let lit = sensor.ray(pixel).and_then(|ray| scene.hit(&ray)).is_some();
        lit && truth.get(pixel).is_none()
    });
    let hidden = hidden.count();
    assert!(hidden > 5, "the camera sees all that is lit: {hidden}");
}
