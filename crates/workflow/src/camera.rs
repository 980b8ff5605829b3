//! Plausibility of cameras: numbers that belong to images of another size stop the run.
//!
//! **Problem.** A camera that was calibrated for images of 640 × 480 pixels is stated for images of
//! 320 × 240. Every ray is wrong then, and the model is bent and too small.
//!
//! **Idea.** The principal point of a whole image is near its middle. In another size, both of its
//! coordinates are off by the factor between the sizes. A part of a larger image has its principal
//! point anywhere, so only usual factors count, and only if all views have the same camera.

use transect_device::{ImageSize, Point3, View};

/// Usual factors between the sizes of the images of a depth camera: binning by 2, 3 and 4, and from
/// 640 to 960 columns.
const FACTORS: [f64; 8] = [0.25, 1.0 / 3.0, 0.5, 2.0 / 3.0, 1.5, 2.0, 3.0, 4.0];

/// Largest deviation of the principal point from the middle of its own image, as a share of half
/// the image. Chosen by hand: the camera of TUM fr1 has 0.07, most others have less. Doubled, parts
/// of images are refused twice as often in each direction.
const OFF_MIDDLE: f64 = 0.08;

/// Largest distance of the principal points of one camera, in pixels. Theory: numbers that are read
/// from one file are equal. Doubled, nothing changes.
const SAME: f64 = 0.5;

/// A pinhole camera beside its image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Camera {
    size: ImageSize,
    /// Column and row of the principal point.
    centre: [f64; 2],
}

impl Camera {
    /// The camera of a view; `None` of another sensor.
    pub(crate) fn of(view: &View) -> Option<Self> {
        let frame = view.frame();
        let ahead = frame.device_point(&Point3::new(0.0, 0.0, 1.0))?;
        let centre = [ahead.col, ahead.row];
        (frame.kind() == "Pinhole").then_some(Self { size: frame.size(), centre })
    }

    fn equals(&self, other: &Self) -> bool {
        let is_near = |axis: usize| (self.centre[axis] - other.centre[axis]).abs() <= SAME;
        self.size == other.size && is_near(0) && is_near(1)
    }

    /// The size that fits the camera in place of the image's own, in shares of that.
    fn other_size(&self) -> Option<f64> {
        let ImageSize { rows, cols } = self.size;
        let share = |axis: usize, pixels: usize| (self.centre[axis] + 0.5) / (0.5 * pixels as f64);
        let shares = [share(0, cols), share(1, rows)];
        let fits = |factor: &f64| shares.iter().all(|s| (s / factor - 1.0).abs() <= OFF_MIDDLE);
        FACTORS.into_iter().find(fits)
    }
}

/// Why the camera that all views share belongs to images of another size; `None` if it does not.
pub(crate) fn misfit(cameras: &[Camera]) -> Option<String> {
    let first = cameras.first()?;
    let factor = first.other_size().filter(|_| cameras.iter().all(|c| c.equals(first)))?;
    let (ImageSize { rows, cols }, [cx, cy]) = (first.size, first.centre);
    let meant = |pixels: usize| (factor * pixels as f64).round();
    let by = crate::table::digits(factor);
    Some(format!(
        "the principal point of all views is cx = {cx}, cy = {cy}, and their images have {rows} rows \
         × {cols} columns. That is the camera of images of {} rows × {} columns; expected a \
         principal point near the middle of the image. Divide fx, fy, cx and cy by {by}: in \
         scan.json, or in the setting `camera` for a folder of depth images. Images that are one \
         corner of larger images look alike.",
        meant(rows),
        meant(cols)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(cols: usize, rows: usize, cx: f64, cy: f64) -> Camera {
        Camera { size: ImageSize { rows, cols }, centre: [cx, cy] }
    }

    #[test]
    fn cameras_of_another_image_size_are_found() {
        for (found, factor) in [
            (camera(320, 240, 318.6, 255.3), 2.0),
            (camera(640, 480, 159.5, 119.5), 0.5),
            (camera(640, 480, 479.5, 359.5), 1.5),
            (camera(640, 480, 213.3, 160.0), 2.0 / 3.0),
            (camera(320, 240, 647.75, 483.75), 4.0),
            (camera(320, 288, 511.5, 447.0), 3.0),
        ] {
            assert_eq!(found.other_size(), Some(factor), "{found:?}");
            assert!(misfit(&[found, found]).is_some());
        }
    }

    /// Published cameras, and parts of images.
    #[test]
    fn sound_cameras_pass() {
        for sound in [
            camera(640, 480, 318.6, 255.3),
            camera(640, 480, 325.1, 249.7),
            camera(640, 480, 320.0, 240.0),
            camera(512, 424, 258.6, 206.5),
            camera(640, 576, 319.9, 336.6),
            // The left half, a strip at the top, a window in the middle and one on the right.
            camera(320, 480, 319.5, 239.5),
            camera(640, 100, 319.5, 239.5),
            camera(300, 200, 149.5, 99.5),
            camera(200, 200, -120.5, 99.5),
        ] {
            assert_eq!(sound.other_size(), None, "{sound:?}");
        }
        // Windows that follow an object differ from view to view.
        let windows = [camera(200, 200, 199.5, 199.5), camera(200, 200, 80.0, 140.0)];
        assert!(misfit(&windows).is_none());
    }
}
