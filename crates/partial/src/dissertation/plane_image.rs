//! The plane range image: what the sensor would measure of one plane (3.4.1).

use transect_device::{DeviceFrame, ImageSize, Pixel, SensorPlane};

/// One range-related value of a plane per pixel, in the unit of the range image, made through the
/// inverse mapping F.
///
/// A ray that runs along the plane or meets it behind its start has +∞ (errata).
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneImage {
    size: ImageSize,
    values: Vec<f64>,
}

impl PlaneImage {
    /// The range image of a plane in the sensor frame.
    pub fn new(frame: &dyn DeviceFrame, plane: &SensorPlane) -> Self {
        let size = frame.size();
        let value = |p| frame.plane_value(p, plane).unwrap_or(f64::INFINITY);
        let pixels = (0..size.rows).flat_map(|r| (0..size.cols).map(move |c| Pixel::new(r, c)));
        Self { size, values: pixels.map(value).collect() }
    }

    /// The plane's value at a pixel; +∞ where its ray misses the plane, and outside the image.
    pub fn get(&self, pixel: Pixel) -> f64 {
        let inside = pixel.row < self.size.rows && pixel.col < self.size.cols;
        let at = inside.then(|| self.values.get(pixel.row * self.size.cols + pixel.col));
        at.flatten().copied().unwrap_or(f64::INFINITY)
    }

    /// The printed label of Eq. 3.3 and 3.4: whether the ray meets the plane before an object at
    /// `d3`.
    ///
    /// Values grow with range on every sensor, so comparing them compares ranges (3.4.1).
    pub fn is_before(&self, pixel: Pixel, d3: f64) -> bool {
        self.get(pixel) < d3
    }
}
