//! Halved frames, over random depth cameras.

use super::laws::{SIZE, cameras, grid_of, images, lenses, scales};
use proptest::prelude::*;
use transect_device::{DeviceFrame, Pixel};

/// Sensors whose neighbouring pixels may share their noise.
fn depth_cameras() -> impl Strategy<Value = Box<dyn DeviceFrame>> {
    prop_oneof![
        (cameras(), scales())
            .prop_map(|(f, scale)| Box::new(f.with_scale(scale)) as Box<dyn DeviceFrame>),
        lenses().prop_map(|f| Box::new(f) as Box<dyn DeviceFrame>),
    ]
}

proptest! {
    #[test]
    fn halved_frames_are_every_other_row_and_column(
        frame in depth_cameras(),
        image in images(),
        d3 in 1.0..9.0_f64,
    ) {
        let grid = grid_of(frame.as_ref(), &image).map(|(grid, _)| grid);
        let grid = grid.iter().map(|grid| grid as &dyn DeviceFrame);
        for whole in std::iter::once(frame.as_ref()).chain(grid) {
            let half = whole.halved().unwrap();
            prop_assert_eq!(half.size(), SIZE.halved());
            prop_assert_eq!(half.handedness(), whole.handedness());
            for pixel in half.size().all_pixels() {
                let in_whole = Pixel::new(2 * pixel.row, 2 * pixel.col);
                let points = [half.point(pixel, d3), whole.point(in_whole, d3)];
                prop_assert_eq!(points[0].is_some(), points[1].is_some());
                let [Some(a), Some(b)] = points else { continue };
                prop_assert!((a - b).norm() < 1e-9, "{}: {} and {}", pixel, a, b);
                let rays = (half.ray(pixel).unwrap(), whole.ray(in_whole).unwrap());
                prop_assert!((rays.0.direction - rays.1.direction).norm() < 1e-9);
                let places = half.device_point(&a).zip(whole.device_point(&a));
                let apart = places.map_or(0.0, |(half, whole)| {
                    (2.0 * half.row - whole.row).hypot(2.0 * half.col - whole.col)
                });
                prop_assert!(apart < 1e-6, "{}: {} pixels apart", pixel, apart);
            }
            let values = (0..SIZE.rows).step_by(2).flat_map(|row| image.row(row).iter().step_by(2));
            let halved = image.halved();
            let found = (0..halved.size().rows).flat_map(|row| halved.row(row));
            prop_assert!(values.zip(found).all(|(a, b)| a == b || a.is_nan() && b.is_nan()));
        }
    }
}
