//! A grid of points that one place saw, as most structured formats store a scan.

use crate::scan::FramedImage;
use crate::{OpenOptions, Place, ReadError, missing};
use std::path::Path;
use std::sync::Arc;
use transect_device::ImageSize;
use transect_geometry::{LengthUnit, Point3};
use transect_sensors::{PointGrid, RayStarts};

/// The frame and the image of row-major points, in the frame of a scanner at the origin. Points
/// that are not finite, (0, 0, 0) and points that repeat are missing.
#[allow(dead_code, reason = "for readers of point files")]
pub(crate) fn framed(
    path: &Path,
    size: ImageSize,
    mut points: Vec<Point3>,
    notes: &mut Vec<String>,
) -> Result<FramedImage, ReadError> {
    missing::clear_points(size, &mut points, None, notes).map_err(|p| p.in_file(path))?;
    let made = PointGrid::new(size, points, RayStarts::Viewpoint(Point3::origin()));
    let unusable = |e| ReadError::unusable(path, Place::Whole, "the grid", e);
    let (frame, image) = made.map_err(unusable)?;
    Ok(FramedImage { frame: Arc::new(frame), image })
}

/// The unit of the options, or metres with a note, for formats without a unit.
pub(crate) fn unit_or_metres(
    path: &Path,
    options: &OpenOptions,
    notes: &mut Vec<String>,
) -> LengthUnit {
    options.unit.unwrap_or_else(|| {
        let convention = "the format carries no unit: taken as metres by its convention";
        notes.push(format!("{}: {convention}", path.display()));
        LengthUnit::Metre
    })
}
