//! Cameras with a ray per pixel: what the common laws do not say.

use transect_device::{DeviceFrame, Handedness, ImageSize, Pixel, Point3, Vector3};
use transect_sensors::{Intrinsics, Pinhole, PinholeScale, RayTable};

const SIZE: ImageSize = ImageSize { rows: 240, cols: 320 };
const CAMERA: Intrinsics = Intrinsics { fx: 200.0, fy: 210.0, cx: 161.3, cy: 118.2 };

/// The ray of a place in the image, through a lens with barrel distortion.
fn bent(row: f64, col: f64) -> Vector3 {
    let (x, y) = ((col - CAMERA.cx) / CAMERA.fx, (row - CAMERA.cy) / CAMERA.fy);
    let bend = 1.0 + 0.12 * (x * x + y * y);
    Vector3::new(x * bend, y * bend, 1.0)
}

fn table(stride: usize, ray: impl Fn(f64, f64) -> Vector3) -> RayTable {
    let size = ImageSize { rows: SIZE.rows / stride, cols: SIZE.cols / stride };
    let pixels = (0..size.rows).flat_map(|row| (0..size.cols).map(move |col| (row, col)));
    let rays = pixels.map(|(row, col)| ray((row * stride) as f64, (col * stride) as f64));
    RayTable::new(size, rays.collect(), PinholeScale::RayLength).unwrap()
}

#[test]
fn a_table_of_straight_rays_is_the_pinhole() {
    let pinhole = Pinhole::new(SIZE, CAMERA).unwrap().with_scale(PinholeScale::RayLength);
    let straight =
        |row, col| Vector3::new((col - CAMERA.cx) / CAMERA.fx, (row - CAMERA.cy) / CAMERA.fy, 1.0);
    let table = table(1, straight);
    for pixel in [Pixel::new(0, 0), Pixel::new(239, 319), Pixel::new(17, 200)] {
        let (a, b) = (table.point(pixel, 3.0).unwrap(), pinhole.point(pixel, 3.0).unwrap());
        assert!((a - b).norm() < 1e-12);
        let d = table.device_point(&a).unwrap();
        assert!((d.row - pixel.row as f64).abs() < 1e-9 && (d.col - pixel.col as f64).abs() < 1e-9);
    }
}

#[test]
fn between_pixels_the_error_falls_with_the_square_of_the_spacing() {
    let error = |stride: usize| {
        let table = table(stride, bent);
        let step = stride as f64;
        let places = (0..40).map(|k| (5.0 + 5.3 * f64::from(k), 7.0 + 7.1 * f64::from(k)));
        let off = |(row, col): (f64, f64)| {
            let d = table.device_point(&Point3::from(bent(row, col) * 2.0)).unwrap();
            (d.row * step - row).hypot(d.col * step - col)
        };
        places.map(off).fold(0.0, f64::max)
    };
    let errors = [8, 4, 2, 1].map(error);
    println!("pixels off, in pixels of the finest grid: {errors:?}");
    assert!(errors[3] < 1e-3);
    assert!(errors[0] / errors[3] > 30.0, "second order over three halvings is 64: {errors:?}");
}

#[test]
fn outside_the_lens_there_is_no_pixel() {
    // Only the circle the lens lights has rays.
    let round = |row: f64, col: f64| {
        let lit = (row - CAMERA.cy).hypot(col - CAMERA.cx) < 100.0;
        if lit { bent(row, col) } else { Vector3::new(f64::NAN, 0.0, 0.0) }
    };
    let table = table(1, round);
    assert_eq!(table.ray(Pixel::new(0, 0)), None);
    assert_eq!(table.point(Pixel::new(0, 0), 1.0), None);
    let inside = table.device_point(&Point3::from(bent(60.25, 200.5))).unwrap();
    assert!((inside.row - 60.25).abs() < 1e-3 && (inside.col - 200.5).abs() < 1e-3, "{inside:?}");
    for (row, col) in [(2.0, 2.0), (118.0, 300.0), (-40.0, 160.0)] {
        assert_eq!(table.device_point(&Point3::from(bent(row, col))), None);
    }
    assert_eq!(table.device_point(&Point3::new(0.0, 0.0, -1.0)), None, "behind the camera");
    assert_eq!(table.device_point(&Point3::origin()), None);
    assert_eq!(table.handedness(), Handedness::ColumnsRight);
}

#[test]
fn tables_that_are_no_camera_are_named() {
    let size = ImageSize { rows: 2, cols: 2 };
    let ray = |x: f64, y: f64, z: f64| Vector3::new(x, y, z);
    let good = vec![ray(0.0, 0.0, 1.0), ray(0.1, 0.0, 1.0), ray(0.0, 0.1, 1.0), ray(0.1, 0.1, 1.0)];
    let message = |rays: Vec<Vector3>, size| {
        RayTable::new(size, rays, PinholeScale::Depth).unwrap_err().to_string()
    };
    assert!(message(good[..3].to_vec(), size).contains("3 values do not fill"));
    let mut backward = good.clone();
    backward[3].z = -1.0;
    assert!(message(backward, size).contains("rays = -"));
    let missing = vec![Vector3::zeros(); 4];
    assert!(message(missing, size).contains("show from which side"));
    let folded = [good.clone(), vec![ray(0.0, -0.1, 1.0), ray(0.1, -0.1, 1.0)]].concat();
    let three = ImageSize { rows: 3, cols: 2 };
    assert_eq!(message(folded, three), "rays = 1: no cells that fold back");
}
