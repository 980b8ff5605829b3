//! Point clouds of structured scans: organised PCD and PLY files, and rotating lidars.
//!
//! A file is one view, and a folder of such files is a scan whose poses a trajectory states
//! ([`poses`]). A cloud without rows and columns cannot be traced, so each file must show them, in
//! one of these ways ([`arrange`]):
//!
//! 1. its header states rows and columns, or the caller does;
//! 2. its points come in firings of all lasers, which a field `ring` or the elevations prove;
//! 3. a field `ring`, or the stated number of rings, gives the rows, and the azimuth the columns.
//!
//! Points are put into cells; no point is moved. The files state no unit. Robotics uses metres
//! (ROS REP 103), so metres are taken, with a note. Points are in the frame of the sensor, which is
//! at its origin with z along the axis of rotation.

mod arrange;
mod azimuth;
mod cells;
mod firings;
mod kitti;
mod lzf;
mod pcd;
mod poses;
mod rings;
#[cfg(test)]
mod tests;

use crate::input::read_bytes;
use crate::point_table::Cloud;
use crate::scan::{FramedImage, LoadView};
use crate::{OpenOptions, Place, ReadError, Scan, ScanView, ply, points, stanford, survey};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect_device::ImageSize;
use transect_geometry::{Isometry3, Point3};

/// The formats of cloud files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Pcd,
    Ply,
    Kitti,
}

impl Kind {
    fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "pcd" => Some(Self::Pcd),
            "ply" => Some(Self::Ply),
            "bin" => Some(Self::Kitti),
            _ => None,
        }
    }
}

/// Whether a path is a cloud file.
pub(crate) fn is_file(path: &Path) -> bool {
    !path.is_dir() && Kind::of(path).is_some()
}

/// Whether a path is a folder with cloud files.
pub(crate) fn is_folder(path: &Path) -> bool {
    files(path).is_ok_and(|files| !files.is_empty())
}

/// Opens one cloud file: a scan of one view.
pub(crate) fn open_file(path: &Path, options: &OpenOptions) -> Result<Scan, ReadError> {
    scan(path, vec![path.to_owned()], options)
}

/// Opens a folder of cloud files.
pub(crate) fn open_folder(folder: &Path, options: &OpenOptions) -> Result<Scan, ReadError> {
    if options.poses.is_none()
        && let Some(problem) = stanford::several(folder)
    {
        return Err(ReadError::unsupported(folder, Place::Whole, problem));
    }
    let files = files(folder).map_err(|e| ReadError::io(folder, e))?;
    let kinds = |kind| files.iter().filter(|f| Kind::of(f) == Some(kind)).count();
    let counts = [Kind::Pcd, Kind::Ply, Kind::Kitti].map(kinds);
    if counts.iter().filter(|n| **n > 0).count() > 1 {
        let [pcd, ply, bin] = counts;
        let problem = format!(
            "the folder has {pcd} *.pcd, {ply} *.ply and {bin} *.bin; a scan has clouds of one \
             kind; move the others out"
        );
        return Err(ReadError::damaged(folder, Place::Whole, problem));
    }
    scan(folder, files, options)
}

/// The cloud files of a folder, sorted by name.
fn files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if is_file(&path) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

fn scan(path: &Path, files: Vec<PathBuf>, options: &OpenOptions) -> Result<Scan, ReadError> {
    let mut notes = Vec::new();
    let unit = points::unit_or_metres(path, options, &mut notes);
    let placed = poses::find(path, &files, options.poses.as_deref())?;
    notes.extend(placed.notes);
    let view = |(file, pose): (&PathBuf, Isometry3)| {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let viewpoint = placed.by_viewpoints.then(|| Point3::from(pose.translation.vector));
        let (grid, rings) = (options.grid, options.rings);
        let source = CloudView { path: file.clone(), grid, rings, viewpoint };
        ScanView::new(name, file.clone(), pose, Arc::new(source))
    };
    let views = files.iter().zip(placed.poses).map(view).collect();
    let absolute = std::path::absolute(path).map_err(|e| ReadError::io(path, e))?;
    let name = absolute.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let inputs = placed.files.into_iter().chain(files).collect();
    Ok(Scan { name, unit, sigma: None, planes: None, views, notes, inputs })
}

/// A cloud file, and the rows that the caller states.
#[derive(Debug)]
struct CloudView {
    path: PathBuf,
    grid: Option<ImageSize>,
    rings: Option<usize>,
    /// Where the `VIEWPOINT` line places the sensor, if the pose is that of the line.
    viewpoint: Option<Point3>,
}

impl LoadView for CloudView {
    fn load(&self, notes: &mut Vec<String>) -> Result<FramedImage, ReadError> {
        let mut cloud = read(&self.path)?;
        notes.append(&mut cloud.notes);
        let (is_carried, is_grid) = (cloud.is_carried, cloud.size.or(self.grid).is_some());
        let (size, points) = arrange::arrange(cloud, self.grid, self.rings, notes)
            .map_err(|p| p.in_file(&self.path))?;
        if is_carried {
            return points::framed_carried(&self.path, size, points, notes);
        }
        if is_grid {
            self.check_frame(size, &points)?;
            return survey::framed(&self.path, &Place::Whole, size, points, None, notes);
        }
        // The rays of a rotating lidar that moves, or whose lasers sit apart, are not even.
        points::framed(&self.path, size, points, notes)
    }
}

impl CloudView {
    /// Refuses points that are in the world already: the pose would move them once more.
    fn check_frame(&self, size: ImageSize, points: &[Point3]) -> Result<(), ReadError> {
        let Some(place) = self.viewpoint else { return Ok(()) };
        if !survey::is_seen_from_alone(size, points, &place) {
            return Ok(());
        }
        let problem = format!(
            "the points are seen from ({:.3}, {:.3}, {:.3}), the place of the VIEWPOINT line, and \
             not from their origin: they are in the world already. Pass the setting `poses`, a \
             file with the line \"1 0 0 0 0 1 0 0 0 0 1 0\" for each cloud, or export the points \
             in the frame of the sensor",
            place.x, place.y, place.z
        );
        Err(ReadError::damaged(&self.path, Place::Whole, problem))
    }
}

fn read(path: &Path) -> Result<Cloud, ReadError> {
    let bytes = read_bytes(path)?;
    match Kind::of(path) {
        Some(Kind::Pcd) => pcd::read(&bytes).map_err(|p| p.in_file(path)),
        Some(Kind::Kitti) => kitti::read(path, &bytes).map_err(|p| p.in_file(path)),
        _ => ply::cloud(path, &bytes),
    }
}
