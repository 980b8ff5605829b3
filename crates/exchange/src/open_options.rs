//! How a scan is opened: what the caller says in place of its files.

use std::path::PathBuf;
use transect_device::ImageSize;
use transect_geometry::LengthUnit;

/// How a scan is opened.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct OpenOptions {
    /// The unit of scans that do not state one. Lengths are never converted.
    pub unit: Option<LengthUnit>,
    /// Whether views without a file are left out, with a note. Otherwise they are an error.
    pub skip_missing: bool,
    /// The trajectory of a sequence of depth images, in place of the file that its layout has.
    pub poses: Option<PathBuf>,
    /// The camera of a sequence of depth images, in place of the file that its layout has.
    pub camera: Option<PathBuf>,
    /// Length units per count of integer depth images, in place of the layout's convention.
    pub depth_scale: Option<f64>,
    /// Largest difference between the times of an image and of its pose, in seconds.
    pub max_time_difference: Option<f64>,
    /// Rows and columns of a point file whose header states no grid.
    pub grid: Option<ImageSize>,
    /// Number of rings of a rotating lidar whose file has no ring field.
    pub rings: Option<usize>,
}

impl OpenOptions {
    /// The names of the given options that concern some formats only.
    pub(crate) fn given(&self) -> impl Iterator<Item = &'static str> {
        [
            ("--poses", self.poses.is_some()),
            ("--camera", self.camera.is_some()),
            ("--depth-scale", self.depth_scale.is_some()),
            ("--max-time-difference", self.max_time_difference.is_some()),
            ("--grid", self.grid.is_some()),
            ("--rings", self.rings.is_some()),
        ]
        .into_iter()
        .filter_map(|(name, is_given)| is_given.then_some(name))
    }
}
