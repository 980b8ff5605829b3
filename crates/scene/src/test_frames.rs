//! A triangulation sensor at its simplest, for tests.

use transect_device::{
    DeviceFrame, DevicePoint, Handedness, ImageSize, Pixel, Point3, Ray, SensorPlane, Vector3,
};

/// A laser that turns about the y axis and a camera beside it, both carried along y from row to
/// row.
///
/// The laser is at `(0, y, 0)`, its column's angle θ is counted from z towards x. The camera is at
/// `(base_line, y, 0)` and measures the slope of its line of sight: `d3 = 4 + (x - base_line) / z`.
/// This is positive for all that the tests look at, as stored values have to be.
#[derive(Debug)]
pub struct SheetOfLight {
    pub size: ImageSize,
    pub base_line: f64,
}

impl SheetOfLight {
    /// Angle of a column in radians: 60 degrees around the z axis.
    pub fn angle(&self, col: usize) -> f64 {
        (60.0 * ((col as f64 + 0.5) / self.size.cols as f64 - 0.5)).to_radians()
    }

    /// Where a row is along y: 0.1 apart.
    pub fn row(&self, row: usize) -> f64 {
        0.1 * row as f64
    }

    pub fn start(&self, row: usize) -> Point3 {
        Point3::new(0.0, self.row(row), 0.0)
    }
}

impl DeviceFrame for SheetOfLight {
    fn size(&self) -> ImageSize {
        self.size
    }

    fn kind(&self) -> &'static str {
        "SheetOfLight"
    }

    fn handedness(&self) -> Handedness {
        Handedness::ColumnsRight
    }

    fn ray(&self, pixel: Pixel) -> Option<Ray> {
        let inside = pixel.row < self.size.rows && pixel.col < self.size.cols;
        let (sin, cos) = self.angle(pixel.col).sin_cos();
        let direction = Vector3::new(sin, 0.0, cos);
        inside.then(|| Ray { start: self.start(pixel.row), direction })
    }

    fn second_viewpoint(&self, pixel: Pixel) -> Option<Point3> {
        Some(self.start(pixel.row) + Vector3::x() * self.base_line)
    }

    fn point(&self, pixel: Pixel, d3: f64) -> Option<Point3> {
        let ray = self.ray(pixel)?;
        let (sin, cos) = (ray.direction.x, ray.direction.z);
        Some(ray.start + ray.direction * (self.base_line / (sin - cos * (d3 - 4.0))))
    }

    fn device_point(&self, in_sensor: &Point3) -> Option<DevicePoint> {
        let share = in_sensor.x.atan2(in_sensor.z).to_degrees() / 60.0 + 0.5;
        let col = share * self.size.cols as f64 - 0.5;
        let d3 = 4.0 + (in_sensor.x - self.base_line) / in_sensor.z;
        Some(DevicePoint { row: 10.0 * in_sensor.y, col, d3 })
    }

    fn plane_value(&self, pixel: Pixel, plane: &SensorPlane) -> Option<f64> {
        let ray = self.ray(pixel)?;
        let range =
            (plane.offset - plane.normal.dot(&ray.start.coords)) / plane.normal.dot(&ray.direction);
        let (sin, cos) = (ray.direction.x, ray.direction.z);
        Some(4.0 + (sin - self.base_line / range) / cos)
    }

    fn extent(&self, _direction: &Vector3, _nearest: f64, _farthest: f64) -> (f64, f64) {
        (f64::MIN, f64::MAX)
    }
}
