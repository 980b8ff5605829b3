//! Errors of depth cameras that project a pattern and find it in their image.
//!
//! Depth follows from the disparity of a small window between image and pattern:
//! `depth = base_line · focal length / disparity`. Therefore
//!
//! * the window's place in the image is uncertain (`shuffle`);
//! * a spot that the pattern does not reach has no depth (the projector's shadow);
//! * the calibration of lens and scale is a little wrong, in all images alike (`distortion`);
//! * disparities are whole steps, so depths have steps that grow with the square of the depth.

use super::{LENS_POSITION, Noise, normal, source};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;
use transect_device::{DeviceFrame, ImageSize, Pixel, Point3, Ray, Vector3};

/// Errors of a depth camera, all of them 0 for none. Sensors whose values are not depths along z
/// ignore them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DepthCamera {
    /// Distance of the projector from the camera along the sensor's x axis, in the model's length
    /// unit. What it does not light is missing.
    pub base_line: f64,
    /// Step of the disparities, in pixels. Depths have steps of `step · depth² / (base_line ·
    /// focal length)`.
    pub disparity_step: f64,
    /// Standard deviation of the place that a pixel measures, along rows and along columns, in
    /// pixels.
    pub shuffle: f64,
    /// Root mean square of a relative error of the depth that varies smoothly over the image and is
    /// the same in all views: wrong scale and wrong lens.
    pub distortion: f64,
}

/// Waves of the distortion along either side of the image, from 0 on: half a wave each.
const WAVES: usize = 3;

/// A depth camera with its errors.
pub(crate) struct Optics {
    camera: DepthCamera,
    size: ImageSize,
    /// Focal lengths along the columns' and the rows' direction, in pixels.
    focal: [f64; 2],
    /// Amplitudes of the distortion's waves along columns and rows.
    amplitudes: [[f64; WAVES]; WAVES],
}

impl Optics {
    /// The errors of a sensor's depths; `None` if it has none, or its values are not depths.
    pub fn of(noise: &Noise, frame: &dyn DeviceFrame) -> Option<Self> {
        let camera = noise.depth_camera;
        if camera == DepthCamera::default() {
            return None;
        }
        let at = |row, col| frame.point(Pixel::new(row, col), 1.0);
        let (origin, right, down) = (at(0, 0)?, at(0, 1), at(1, 0));
        let corners = [Some(origin), right, down];
        let is_depth = corners.iter().flatten().all(|p| (p.z - 1.0).abs() < 1e-9);
        let focal = [
            right.map(|p| (p.x - origin.x).abs().recip()),
            down.map(|p| (p.y - origin.y).abs().recip()),
        ];
        let focal = settled(focal, pixels_beside(frame, &origin))?;
        let amplitudes = amplitudes(noise.seed, camera.distortion);
        is_depth.then(|| Self { camera, size: frame.size(), focal, amplitudes })
    }

    /// Where the pattern comes from, in the sensor's frame.
    pub fn projector(&self) -> Option<Point3> {
        (self.camera.base_line > 0.0).then(|| Point3::new(self.camera.base_line, 0.0, 0.0))
    }

    /// The ray of the place that a pixel measures. The two numbers are always drawn.
    pub fn shuffled(&self, ray: &Ray, numbers: &mut ChaCha8Rng) -> Ray {
        let [x, y] = self.focal.map(|f| normal(numbers) * self.camera.shuffle / f);
        let direction = ray.direction + Vector3::new(x, y, 0.0) * ray.direction.z;
        Ray { start: ray.start, direction: direction.normalize() }
    }

    /// The depth that a pixel states; `None` if its disparity rounds to 0.
    pub fn stated(&self, pixel: Pixel, depth: f64) -> Option<f64> {
        let depth = depth * (1.0 + self.distortion(pixel));
        let scale = self.camera.base_line * self.focal[0];
        let step = self.camera.disparity_step;
        let steps = if step > 0.0 { (scale / depth / step).round() * step } else { scale / depth };
        let stated = if step > 0.0 { scale / steps } else { depth };
        (stated.is_finite() && stated > 0.0).then_some(stated)
    }

    fn distortion(&self, pixel: Pixel) -> f64 {
        // At the pixels' centres the waves are orthogonal, so their squares add up.
        let waves = |k: usize, count: usize| {
            let share = PI * (k as f64 + 0.5) / count as f64;
            (0..WAVES).map(move |wave| (wave as f64 * share).cos())
        };
        let along_rows = |amplitudes: &[f64; WAVES]| -> f64 {
            waves(pixel.row, self.size.rows).zip(amplitudes).map(|(wave, a)| wave * a).sum()
        };
        waves(pixel.col, self.size.cols)
            .zip(&self.amplitudes)
            .map(|(wave, amplitudes)| wave * along_rows(amplitudes))
            .sum()
    }
}

/// Pixels per length at depth 1, along columns and rows, by the frame's inverse mapping. It also
/// knows places outside the image.
fn pixels_beside(frame: &dyn DeviceFrame, place: &Point3) -> [Option<f64>; 2] {
    let here = frame.device_point(place);
    let beside = |step: Vector3| here.zip(frame.device_point(&(place + step * BESIDE)));
    let right = beside(Vector3::x()).map(|(here, there)| (there.col - here.col).abs() / BESIDE);
    let down = beside(Vector3::y()).map(|(here, there)| (there.row - here.row).abs() / BESIDE);
    [right, down].map(|pixels| pixels.filter(|pixels| *pixels > 0.0))
}

/// How far the second place is off for [`pixels_beside`], at depth 1. Chosen by hand: a tenth of a
/// pixel of common cameras. Doubled, the distortion of a lens changes the result in its fifth
/// digit.
const BESIDE: f64 = 1e-4;

/// Focal lengths from the pixels beside the first one. An image of one row or column has no such
/// pixel along one side: the inverse mapping stands for it, or the other side.
fn settled(focal: [Option<f64>; 2], inverse: [Option<f64>; 2]) -> Option<[f64; 2]> {
    let [x, y] = [focal[0].or(inverse[0]), focal[1].or(inverse[1])];
    Some([x.or(y)?, y.or(x)?])
}

/// Random amplitudes of waves, smaller for shorter ones, whose sum has a root mean square.
fn amplitudes(seed: u64, rms: f64) -> [[f64; WAVES]; WAVES] {
    let mut numbers = source(seed, 0, LENS_POSITION);
    let mut amplitudes = [[0.0; WAVES]; WAVES];
    let mut square = 0.0;
    for (a, row) in amplitudes.iter_mut().enumerate() {
        for (b, amplitude) in row.iter_mut().enumerate() {
            *amplitude = normal(&mut numbers) / (1 + a + b) as f64;
            // The mean square of a wave is a half, that of the constant is 1.
            square += [a, b]
                .iter()
                .fold(*amplitude * *amplitude, |s, k| if *k > 0 { 0.5 * s } else { s });
        }
    }
    amplitudes.map(|row| row.map(|amplitude| amplitude * rms / square.sqrt()))
}
