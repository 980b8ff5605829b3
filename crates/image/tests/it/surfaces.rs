//! Simulated views of any surface given by its signed distance, with reproducible noise.

use std::sync::Arc;
use transect_device::{DeviceFrame, ImageSize, Isometry3, Pixel, Point3, RangeImage, View};
use transect_sensors::{AngularScan, ImagingRadar, Intrinsics, Pinhole};

/// Signed distance from a surface; a ray walks along it until it meets the surface.
pub type Distance = fn(&Point3) -> f64;

pub const SIZE: ImageSize = ImageSize { rows: 96, cols: 128 };

/// Looks along +z of its frame; 1/120 rad per pixel.
pub fn camera() -> Arc<dyn DeviceFrame> {
    let k = Intrinsics { fx: 120.0, fy: 120.0, cx: 63.5, cy: 47.5 };
    Arc::new(Pinhole::new(SIZE, k).unwrap())
}

/// Looks along +x of its frame; 1/120 rad per pixel.
pub fn radar() -> Arc<dyn DeviceFrame> {
    let scan = |count: usize| {
        let step = 1.0 / 120.0;
        AngularScan::from_radians(-0.5 * step * (count - 1) as f64, step)
    };
    Arc::new(ImagingRadar::new(SIZE, scan(SIZE.cols), scan(SIZE.rows)).unwrap())
}

/// Normal random numbers, near enough: the sum of twelve uniform ones.
pub struct Normal(pub u64);

impl Normal {
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn sample(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// Noise of standard deviation 1 that each pixel shares with those nearer than `side`: the mean
/// of normal numbers over a square, made larger again.
pub fn shared_noise(size: ImageSize, side: usize, seed: u64) -> Vec<f64> {
    let cols = size.cols + side;
    let mut normal = Normal(seed);
    let numbers: Vec<f64> = (0..(size.rows + side) * cols).map(|_| normal.sample()).collect();
    let square = |p: Pixel| {
        let rows = (p.row..p.row + side).map(|row| &numbers[row * cols + p.col..][..side]);
        rows.flatten().sum::<f64>() / side as f64
    };
    pixels(size).map(square).collect()
}

/// Range along a ray to the surface.
fn range(frame: &dyn DeviceFrame, pixel: Pixel, distance: Distance) -> Option<f64> {
    let ray = frame.ray(pixel)?;
    let mut along = 0.0;
    for _ in 0..2000 {
        let step = distance(&(ray.start + ray.direction * along));
        along += step;
        if step < 1e-12 {
            return Some(along);
        }
        if along > 100.0 {
            return None;
        }
    }
    None
}

/// What a sensor sees, with normal noise of `sigma` along the rays; the view states `stated`.
pub fn look(
    frame: &Arc<dyn DeviceFrame>,
    distance: Distance,
    sigma: f64,
    stated: Option<f64>,
) -> View {
    let mut normal = Normal(7);
    let size = frame.size();
    let value = |k: usize| {
        let pixel = size.pixel(k);
        let noise = sigma * normal.sample();
        let along = range(frame.as_ref(), pixel, distance)? + noise;
        let ray = frame.ray(pixel)?;
        frame.device_point(&(ray.start + ray.direction * along)).map(|d| d.d3 as f32)
    };
    let values = (0..size.pixels()).map(value).map(|v| v.unwrap_or(f32::NAN)).collect();
    let image = RangeImage::from_values(size, values).unwrap();
    View::new("surface", image, Arc::clone(frame), Isometry3::identity(), stated).unwrap()
}

/// Distance along the ray between the samples of two views; NaN where either is missing.
pub fn error_at(view: &View, truth: &View, pixel: Pixel) -> f64 {
    let (p, q) = (view.point_in_sensor(pixel), truth.point_in_sensor(pixel));
    let ray = view.frame().ray(pixel).unwrap().direction;
    p.zip(q).map_or(f64::NAN, |(p, q)| (p - q).dot(&ray))
}

pub fn pixels(size: ImageSize) -> impl Iterator<Item = Pixel> {
    size.all_pixels()
}

/// The value below which a share of the sizes lies; NaN are left out.
pub fn quantile(errors: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut sizes: Vec<f64> = errors.map(f64::abs).filter(|e| !e.is_nan()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes[((sizes.len() - 1) as f64 * share) as usize]
}
