//! The sensors of a manifest: one module for each sensor with more than four keys.
//!
//! A module holds the sensor's entry (its keys as data) and the reading of the keys. It also holds
//! the [`Sensor`] that makes a device frame and a range image from the view's file.

mod distortion;
mod light_stripe;
mod lookup_table;
mod pinhole;
mod shared;
mod stripe;
#[cfg(test)]
mod tests;

pub use light_stripe::{AnglesEntry, LightStripeEntry};
pub use lookup_table::{LookupTableEntry, ViewpointsEntry};
pub use pinhole::{LensEntry, PinholeEntry};
pub use stripe::StripeEntry;

use super::keys::{Keys, UnknownKey};
use crate::ReadError;
use crate::scan::FramedImage;
use crate::view_file::ViewFile;
use serde::Serialize;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect_device::{ImageOrder, Point3};
use transect_sensors::{AngularScan, ImagingRadar, Intrinsics, PinholeScale, PointGrid, RayStarts};

/// The sensors a manifest can name.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "sensor", rename_all = "snake_case")]
#[non_exhaustive]
pub enum SensorEntry {
    /// Two angles, in radians, and a range.
    Spherical {
        /// Azimuth of column 0.
        theta0: f64,
        /// Azimuth from one column to the next.
        dtheta: f64,
        /// Elevation of row 0.
        phi0: f64,
        /// Elevation from one row to the next.
        dphi: f64,
    },
    /// A depth camera.
    Pinhole(PinholeEntry),
    /// A laser sheet turned by a mirror and watched by a camera.
    LightStripe(LightStripeEntry),
    /// A calibrated scanner on a linear axis.
    LookupTable(LookupTableEntry),
    /// An organised grid of points.
    Grid {
        /// The start of all rays, in the sensor frame and the length unit.
        viewpoint: [f64; 3],
    },
}

impl SensorEntry {
    /// A depth camera without lens distortion whose pixels hold depths.
    pub fn pinhole(intrinsics: Intrinsics) -> Self {
        let lens = LensEntry::Intrinsics { intrinsics, distortion: None };
        let holds = PinholeScale::Depth;
        Self::Pinhole(PinholeEntry { lens, holds, depth_offsets: None })
    }

    /// Reads the sensor of a view. Unknown keys of its inner objects go to `unknown`.
    pub(super) fn read(keys: &Keys<'_>, unknown: &mut Vec<UnknownKey>) -> Result<Self, ReadError> {
        let known = "one of spherical, pinhole, light_stripe, lookup_table, grid";
        match keys.required("sensor", known)? {
            "spherical" => Ok(Self::Spherical {
                theta0: keys.number("theta0")?,
                dtheta: keys.number("dtheta")?,
                phi0: keys.number("phi0")?,
                dphi: keys.number("dphi")?,
            }),
            "pinhole" => PinholeEntry::read(keys).map(Self::Pinhole),
            "light_stripe" => LightStripeEntry::read(keys, unknown).map(Self::LightStripe),
            "lookup_table" => LookupTableEntry::read(keys).map(Self::LookupTable),
            "grid" => Ok(Self::Grid { viewpoint: keys.required("viewpoint", "[x, y, z]")? }),
            other => Err(keys.wrong("sensor", &format!("{known}; it is {other:?}"))),
        }
    }
}

/// Reads the image of a view and makes its device frame. Tables that are costly and depend on the
/// size of the image are made when the first view is loaded; the other views share them.
pub(super) trait Sensor: fmt::Debug + Send + Sync {
    fn load(&self, file: &ViewFile, notes: &mut Vec<String>) -> Result<FramedImage, ReadError>;

    /// Whether it reads images whose pixels are in another order. Grids of points do not: rows and
    /// columns only tell which points are neighbours there, and so do exchanged ones.
    fn reads(&self, _: ImageOrder) -> bool {
        false
    }

    /// The files behind a view's `file`: itself, or all images of a folder.
    fn image_files(&self, path: &Path) -> Result<Vec<PathBuf>, ReadError> {
        Ok(vec![path.to_owned()])
    }

    /// The file with the sensor's own data, such as a calibration.
    fn file(&self) -> Option<&Path> {
        None
    }
}

/// The sensor of an entry; `folder` is the manifest's folder.
pub(super) fn of_entry(folder: &Path, entry: &SensorEntry) -> Arc<dyn Sensor> {
    match entry {
        SensorEntry::Spherical { theta0, dtheta, phi0, dphi } => Arc::new(Spherical {
            theta: AngularScan::from_radians(*theta0, *dtheta),
            phi: AngularScan::from_radians(*phi0, *dphi),
        }),
        SensorEntry::Pinhole(entry) => Arc::new(entry.sensor(folder)),
        SensorEntry::LightStripe(entry) => Arc::new(entry.sensor()),
        SensorEntry::LookupTable(entry) => Arc::new(entry.sensor(folder)),
        SensorEntry::Grid { viewpoint } => Arc::new(Grid(Point3::from(*viewpoint))),
    }
}

#[derive(Debug)]
struct Spherical {
    theta: AngularScan,
    phi: AngularScan,
}

impl Sensor for Spherical {
    fn load(&self, file: &ViewFile, notes: &mut Vec<String>) -> Result<FramedImage, ReadError> {
        let image = file.load_image(notes)?;
        let radar = ImagingRadar::new(image.size(), self.theta, self.phi);
        let frame = Arc::new(radar.map_err(|e| file.bad_sensor(e))?);
        Ok(FramedImage { frame, image })
    }

    /// Exchanged angles are a transposed image.
    fn reads(&self, order: ImageOrder) -> bool {
        order != ImageOrder::SwappedCamera
    }
}

/// Points whose rays start in one point.
#[derive(Debug)]
struct Grid(Point3);

impl Sensor for Grid {
    fn load(&self, file: &ViewFile, notes: &mut Vec<String>) -> Result<FramedImage, ReadError> {
        let (size, points) = file.load_points(notes)?;
        let grid = PointGrid::new(size, points, RayStarts::Viewpoint(self.0));
        let (grid, image) = grid.map_err(|e| file.unusable("the grid", e))?;
        Ok(FramedImage { frame: Arc::new(grid), image })
    }
}
