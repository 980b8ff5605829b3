//! A hash that tells two views of the same name apart.

use transect_device::{Pixel, View};

/// A hash of the image size, the points of all pixels in the sensor's frame, the start of the
/// middle ray of each row, and the given noise. The pose and the names of files are not part of it.
///
/// 64 bits find accidents, such as an image that was taken again under its old name. They do not
/// stop attacks.
pub(crate) fn fingerprint(view: &View) -> String {
    let (size, frame) = (view.image().size(), view.frame());
    let mut hash = mix(mix(SEED, size.rows as u64), size.cols as u64);
    hash = mix(hash, view.sigma().map_or(u64::MAX, f64::to_bits));
    for row in 0..size.rows {
        for col in 0..size.cols {
            let pixel = Pixel::new(row, col);
            let Some(point) = view.point_in_sensor(pixel) else {
                hash = mix(hash, 0);
                continue;
            };
            hash = point.iter().fold(hash, |hash, c| mix(hash, c.to_bits()));
        }
        let starts = frame.ray(Pixel::new(row, size.cols / 2)).map(|ray| ray.start);
        let starts = starts.iter().flat_map(|start| start.iter());
        hash = starts.fold(hash, |hash, c| mix(hash, c.to_bits()));
    }
    format!("{hash:016x}")
}

/// Most rows in a hash of some values. No unit. Measured on 40 frames of a depth camera: a hash of
/// all points takes 5 % of a run, that of these rows too little to show. Doubled, twice that.
const ROWS: usize = 32;

/// A hash of the image size and the values of some rows, spread evenly, for a note on images that
/// are repeated within a run.
pub(crate) fn fingerprint_of_rows(view: &View) -> String {
    let (image, size) = (view.image(), view.image().size());
    let rows = (0..size.rows).step_by(size.rows.div_ceil(ROWS).max(1));
    let values = rows.flat_map(|row| image.row(row).iter().map(|value| u64::from(value.to_bits())));
    let sizes = [size.rows as u64, size.cols as u64];
    format!("{:016x}", sizes.into_iter().chain(values).fold(SEED, mix))
}

const SEED: u64 = 0xcbf2_9ce4_8422_2325;

/// The step is invertible in the hash so far, so a change of a single number is always found.
fn mix(hash: u64, word: u64) -> u64 {
    const ODD: u64 = 0x9e37_79b9_7f4a_7c15;
    (hash ^ word).wrapping_mul(ODD).rotate_left(29)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use transect_device::{ImageSize, Isometry3, RangeImage};
    use transect_sensors::{Intrinsics, Pinhole};

    fn view(fx: f64, depth: f32, sigma: Option<f64>) -> View {
        let size = ImageSize { rows: 2, cols: 3 };
        let camera = Pinhole::new(size, Intrinsics { fx, fy: 5.0, cx: 1.0, cy: 0.5 }).unwrap();
        let image = RangeImage::from_values(size, vec![1.0, 2.0, f32::NAN, 1.5, depth, 3.0]);
        let pose = Isometry3::identity();
        View::new("v", image.unwrap(), Arc::new(camera), pose, sigma).unwrap()
    }

    #[test]
    fn image_sensor_and_noise_count_and_the_pose_does_not() {
        let print = fingerprint(&view(5.0, 1.0, None));
        let moved = view(5.0, 1.0, None).with_pose(Isometry3::translation(1.0, 0.0, 0.0));
        assert_eq!(fingerprint(&moved.unwrap()), print);
        let others = [view(6.0, 1.0, None), view(5.0, 1.0000001, None), view(5.0, 1.0, Some(0.0))];
        for other in others {
            assert_ne!(fingerprint(&other), print);
        }
    }
}
