//! Every sensor once: the point of a value, and the value of that point.
//!
//! ```text
//! cargo run -p transect-sensors --example sensors
//! ```

use std::error::Error;
use transect_device::{DeviceFrame, ImageSize, Pixel, Point3, SensorPlane, Vector3};
use transect_sensors::lookup_table::LinearSteps;
use transect_sensors::{
    AngularScan, ImagingRadar, Intrinsics, LightStripe, LookupTable, Pinhole, PinholeScale,
    PointGrid, RayStarts, RayTable,
};

/// Checks that `F` inverts `f` at a pixel.
fn there_and_back(frame: &dyn DeviceFrame, pixel: Pixel, d3: f64) -> Result<(), Box<dyn Error>> {
    let point = frame.point(pixel, d3).ok_or("the value has no point")?;
    let back = frame.device_point(&point).ok_or("the point is not in the image")?;
    assert!((back.row - pixel.row as f64).abs() < 1e-6, "{back:?}");
    assert!((back.col - pixel.col as f64).abs() < 1e-6, "{back:?}");
    assert!((back.d3 - d3).abs() < 1e-6, "{back:?}");
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let size = ImageSize { rows: 20, cols: 30 };
    let pixel = Pixel::new(7, 11);

    // Two angles and a range.
    let theta = AngularScan::from_degrees(-15.0, 1.0);
    let phi = AngularScan::from_degrees(10.0, -1.0);
    there_and_back(&ImagingRadar::new(size, theta, phi)?, pixel, 12.5)?;

    // A depth camera, and the same camera as a table of rays.
    let camera = Pinhole::new(size, Intrinsics { fx: 25.0, fy: 25.0, cx: 14.5, cy: 9.5 })?;
    there_and_back(&camera, pixel, 2.0)?;
    let pixels = (0..size.rows).flat_map(|row| (0..size.cols).map(move |col| Pixel::new(row, col)));
    let rays = pixels.filter_map(|p| camera.ray(p)).map(|ray| ray.direction).collect();
    there_and_back(&RayTable::new(size, rays, PinholeScale::Depth)?, pixel, 2.0)?;

    // The dissertation's light-stripe range finder, in millimetres. d3 counts camera cells.
    there_and_back(&LightStripe::smart_eye()?, Pixel::new(247, 100), 384.0)?;

    // The dissertation's calibrated line scanner, carried in 20 steps of 1 mm. The value of a plane
    // 150 mm away is a place on its detector.
    let scanner = LookupTable::hyscan(LinearSteps::new(0.0, 1.0, 20))?;
    let (pixel_there, wall) =
        (Pixel::new(7, 128), SensorPlane { normal: Vector3::z(), offset: 150.0 });
    let d3 = scanner.plane_value(pixel_there, &wall).ok_or("the ray misses the plane")?;
    there_and_back(&scanner, pixel_there, d3)?;

    // Organised points. There is no inverse: nothing is known between the rays.
    let points =
        (0..600).map(|n| Point3::new(f64::from(n % 30), f64::from(n / 30), 40.0)).collect();
    let (grid, image) = PointGrid::new(size, points, RayStarts::Parallel(Vector3::z()))?;
    let d3 = image.get(pixel).ok_or("missing")?;
    let point = grid.point(pixel, d3.into()).ok_or("no point")?;
    assert_eq!(point, Point3::new(11.0, 7.0, 40.0));
    assert_eq!(grid.device_point(&point), None);
    Ok(())
}
