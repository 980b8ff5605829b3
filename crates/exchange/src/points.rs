//! A grid of points, as most structured formats store a scan.

use crate::missing::{self, Origin};
use crate::scan::FramedImage;
use crate::{OpenOptions, Place, ReadError};
use std::path::Path;
use std::sync::Arc;
use transect_device::{ImageSize, Note, RangeImage};
use transect_geometry::{LengthUnit, Point3};
use transect_sensors::{PointGrid, RayStarts, SensorError};

/// The frame and the image of row-major points, in the frame of a scanner at the origin. Points
/// that are not finite, (0, 0, 0) and points that repeat are missing.
pub(crate) fn framed(
    path: &Path,
    size: ImageSize,
    points: Vec<Point3>,
    notes: &mut Vec<String>,
) -> Result<FramedImage, ReadError> {
    let starts = RayStarts::Viewpoint(Point3::origin());
    framed_by(path, size, points, notes, |size, points| PointGrid::new(size, points, starts))
}

/// The same for a triangulation scanner that was carried along x and looks along -z.
pub(crate) fn framed_carried(
    path: &Path,
    size: ImageSize,
    points: Vec<Point3>,
    notes: &mut Vec<String>,
) -> Result<FramedImage, ReadError> {
    framed_by(path, size, points, notes, PointGrid::from_translated_scan)
}

fn framed_by(
    path: &Path,
    size: ImageSize,
    mut points: Vec<Point3>,
    notes: &mut Vec<String>,
    make: impl Fn(ImageSize, Vec<Point3>) -> Result<(PointGrid, RangeImage), SensorError>,
) -> Result<FramedImage, ReadError> {
    missing::clear_points(size, &mut points, Origin::PointFile, notes)
        .map_err(|p| p.in_file(path))?;
    let unusable = |e| ReadError::unusable(path, Place::Whole, "the grid", e);
    let (frame, image) = make(size, points).map_err(unusable)?;
    Ok(FramedImage { frame: Arc::new(frame), image })
}

/// The unit of the options, or metres with a note, for formats without a unit.
pub(crate) fn unit_or_metres(
    path: &Path,
    options: &OpenOptions,
    notes: &mut Vec<Note>,
) -> LengthUnit {
    options.unit.unwrap_or_else(|| {
        let convention = "the format carries no unit: taken as metres by its convention";
        notes.push(Note::about(path.display(), convention));
        LengthUnit::Metre
    })
}
