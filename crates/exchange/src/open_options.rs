//! How a scan is opened: what the caller says in place of its files.

use crate::{Place, ReadError};
use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use transect_device::{ImageOrder, ImageSize};
use transect_geometry::LengthUnit;
use transect_sensors::Intrinsics;

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
    pub camera: Option<CameraOption>,
    /// Length units per count of integer depth images, in place of the layout's convention.
    pub depth_scale: Option<f64>,
    /// Largest difference between the times of an image and of its pose, in seconds.
    pub max_time_difference: Option<f64>,
    /// Rows and columns of a point file whose header states no grid.
    pub grid: Option<ImageSize>,
    /// Number of rings of a rotating lidar whose file has no ring field.
    pub rings: Option<usize>,
    /// The order of the pixels in the images' files, if it is another than the sensors'.
    pub image_order: Option<ImageOrder>,
}

impl OpenOptions {
    /// Refuses options that the format of a scan has no use for.
    pub(crate) fn refuse_unused(&self, path: &Path, used: &[&str]) -> Result<(), ReadError> {
        let given = [
            ("--poses", self.poses.is_some()),
            ("--camera", self.camera.is_some()),
            ("--depth-scale", self.depth_scale.is_some()),
            ("--max-time-difference", self.max_time_difference.is_some()),
            ("--grid", self.grid.is_some()),
            ("--rings", self.rings.is_some()),
        ];
        let unused = given.iter().find(|(name, given)| *given && !used.contains(name));
        let Some((name, _)) = unused else { return Ok(()) };
        let problem = format!("{name} has no meaning for a scan of this format; leave it out");
        Err(ReadError::unsupported(path, Place::Whole, problem))
    }
}

/// A camera as a caller states it.
#[derive(Debug, Clone, PartialEq)]
pub enum CameraOption {
    /// A file: JSON with `intrinsic_matrix` (Open3D) or `fx fy ppx ppy` (RealSense), or a text of
    /// 3 × 3 or 4 × 4 numbers or of `fx fy cx cy`.
    File(PathBuf),
    /// The numbers themselves.
    Numbers(Intrinsics),
}

impl FromStr for CameraOption {
    type Err = Infallible;

    /// Four numbers with commas between them are intrinsics; any other text names a file.
    fn from_str(text: &str) -> Result<Self, Infallible> {
        let parsed: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
        Ok(match parsed.as_deref() {
            Some(&[fx, fy, cx, cy]) => Self::Numbers(Intrinsics { fx, fy, cx, cy }),
            _ => Self::File(text.into()),
        })
    }
}
