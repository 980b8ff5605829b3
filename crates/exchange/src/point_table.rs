//! The points of a cloud as a file holds them, before they have rows and columns.

use transect_device::ImageSize;
use transect_geometry::Point3;

/// The points of a file in their order.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cloud {
    pub(crate) points: Vec<Point3>,
    /// The laser of each point, where the file has a field for it.
    pub(crate) rings: Option<Vec<u16>>,
    /// Rows and columns of row-major points, where the file states them.
    pub(crate) size: Option<ImageSize>,
    /// Whether a triangulation scanner was carried along x.
    pub(crate) is_carried: bool,
    pub(crate) notes: Vec<String>,
}

/// The laser of a point from the number in its field.
pub(crate) fn ring(value: f64) -> Result<u16, String> {
    let is_whole = value.fract() == 0.0 && (0.0..=f64::from(u16::MAX)).contains(&value);
    let problem = || format!("the ring is {value}; expected a whole number from 0 to 65535");
    is_whole.then_some(value as u16).ok_or_else(problem)
}

/// Whether a field's name means the laser of a point. CloudCompare puts `scalar_` before names.
pub(crate) fn is_ring_name(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let name = name.strip_prefix("scalar_").unwrap_or(&name);
    ["ring", "laser_id", "laserid", "channel", "beam"].contains(&name)
}
