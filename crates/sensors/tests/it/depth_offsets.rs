//! The error of a depth camera, taken out of its images.

use transect_device::{DepthOffsets, ImageSize, RangeImage};
use transect_sensors::{Intrinsics, Pinhole};

#[test]
fn an_image_of_another_size_than_the_sensor_is_refused() {
    let (size, turned) = (ImageSize { rows: 2, cols: 3 }, ImageSize { rows: 3, cols: 2 });
    let camera = Pinhole::new(size, Intrinsics { fx: 4.0, fy: 4.0, cx: 1.0, cy: 0.5 }).unwrap();
    let offsets = DepthOffsets::new(2, 2, vec![0.1; 4]).unwrap();
    let corrected = |size: ImageSize| {
        let image = RangeImage::from_values(size, vec![2.0; size.pixels()]).unwrap();
        offsets.correct(&camera, &image)
    };
    assert!(corrected(size).is_ok());
    let error = corrected(turned).unwrap_err().to_string();
    assert_eq!(error, "the image has 3 rows × 2 columns, but the sensor 2 rows × 3 columns");
}
