//! How the files of a view become a device frame and a range image: one module per kind of sensor.

mod distortion;
mod light_stripe;
mod lookup_table;
mod pinhole;
mod shared;
#[cfg(test)]
mod tests;

use crate::image_stack::ImageStack;
use crate::manifest::SensorEntry;
use crate::{ReadError, ScanView, image_file, ply};
use light_stripe::LightStripeSource;
use lookup_table::LookupTableSource;
use pinhole::PinholeSource;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect_device::{DeviceFrame, Point3, RangeImage};
use transect_sensors::{AngularScan, ImagingRadar, PointGrid, RayStarts, SensorError};

/// A view's device frame and its image.
pub(crate) type Loaded = (Arc<dyn DeviceFrame>, RangeImage);

/// What is known about a sensor before a view is loaded.
///
/// Views share it, and with it the tables that take long to make: those are made when the first
/// view is loaded, because they depend on the size of the image.
#[derive(Debug)]
pub(crate) enum SensorSource {
    Spherical {
        theta: AngularScan,
        phi: AngularScan,
    },
    Pinhole(PinholeSource),
    LightStripe(LightStripeSource),
    LookupTable(LookupTableSource),
    Grid(Point3),
    /// A PLY range grid of a triangulation scanner carried along x.
    TranslatedScan,
}

impl SensorSource {
    /// The sensor of a manifest's view; `folder` is where the manifest's files are.
    pub(crate) fn new(folder: &Path, entry: &SensorEntry) -> Self {
        match entry {
            SensorEntry::Spherical { theta0, dtheta, phi0, dphi } => Self::Spherical {
                theta: AngularScan::from_radians(*theta0, *dtheta),
                phi: AngularScan::from_radians(*phi0, *dphi),
            },
            SensorEntry::Pinhole(entry) => Self::Pinhole(PinholeSource::new(folder, entry)),
            SensorEntry::LightStripe(entry) => Self::LightStripe(LightStripeSource::new(entry)),
            SensorEntry::LookupTable(entry) => {
                Self::LookupTable(LookupTableSource::new(folder, entry))
            }
            SensorEntry::Grid { viewpoint } => Self::Grid(Point3::from(*viewpoint)),
        }
    }

    /// The file the sensor is read from, beside the images.
    pub(crate) fn file(&self) -> Option<&Path> {
        match self {
            Self::Pinhole(source) => source.file(),
            Self::LookupTable(source) => Some(source.file()),
            _ => None,
        }
    }

    /// The files which a view's `file` stands for: itself, or all images of a folder.
    pub(crate) fn image_files(&self, path: &Path) -> Result<Vec<PathBuf>, ReadError> {
        match self {
            Self::LightStripe(_) if path.is_dir() => ImageStack::files_of_folder(path),
            _ => Ok(vec![path.to_owned()]),
        }
    }

    /// The device frame and the image of a view.
    pub(crate) fn load(
        &self,
        view: &ScanView,
        notes: &mut Vec<String>,
    ) -> Result<Loaded, ReadError> {
        match self {
            Self::Spherical { theta, phi } => {
                let image = view.load_image(notes)?;
                let radar = ImagingRadar::new(image.size(), *theta, *phi);
                Ok((Arc::new(radar.map_err(|e| view.bad_sensor(e))?), image))
            }
            Self::Pinhole(source) => source.load(view, notes),
            Self::LightStripe(source) => source.load(view, notes),
            Self::LookupTable(source) => source.load(view, notes),
            Self::Grid(viewpoint) => {
                let (size, points) = image_file::read_points(view.path())?;
                view.check_size(size)?;
                grid(view, PointGrid::new(size, points, RayStarts::Viewpoint(*viewpoint)))
            }
            Self::TranslatedScan => {
                let grid = ply::read_range_grid(view.path())?;
                notes.extend(grid.notes);
                self::grid(view, PointGrid::from_translated_scan(grid.size, grid.points))
            }
        }
    }
}

fn grid(
    view: &ScanView,
    made: Result<(PointGrid, RangeImage), SensorError>,
) -> Result<Loaded, ReadError> {
    match made {
        Ok((grid, image)) => Ok((Arc::new(grid), image)),
        Err(e) => Err(view.unusable("the grid", e)),
    }
}
