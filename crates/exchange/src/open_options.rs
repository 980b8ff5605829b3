//! How a scan is opened: what the caller says in place of its files.

use std::path::PathBuf;
use std::str::FromStr;
use transect_device::{ImageOrder, ImageSize};
use transect_geometry::LengthUnit;
use transect_sensors::{Intrinsics, PinholeScale};

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
    /// The length that each pixel of a sequence of depth images holds; depth if not stated.
    pub pixels_hold: Option<PinholeScale>,
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
    /// The first given field without which the scan would be read in another way; its unit and the
    /// order of its pixels aside.
    pub fn first_given(&self) -> Option<&'static str> {
        self.unused(&[])
    }

    /// The first given field that is not among the used ones.
    pub(crate) fn unused(&self, used: &[&str]) -> Option<&'static str> {
        let given = [
            ("poses", self.poses.is_some()),
            ("camera", self.camera.is_some()),
            ("depth_scale", self.depth_scale.is_some()),
            ("pixels_hold", self.pixels_hold.is_some()),
            ("max_time_difference", self.max_time_difference.is_some()),
            ("grid", self.grid.is_some()),
            ("rings", self.rings.is_some()),
        ];
        given.into_iter().find(|(name, given)| *given && !used.contains(name)).map(|(name, _)| name)
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
    type Err = String;

    /// Numbers with commas between them are intrinsics, of which there are four; any other text
    /// names a file.
    fn from_str(text: &str) -> Result<Self, String> {
        let parsed: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
        match parsed.as_deref() {
            Some(&[fx, fy, cx, cy]) => {
                let intrinsics = Intrinsics { fx, fy, cx, cy };
                check_intrinsics(&intrinsics).map(|()| Self::Numbers(intrinsics))
            }
            None | Some([_]) => Ok(Self::File(text.into())),
            Some(numbers) => {
                let count = numbers.len();
                Err(format!("{count} numbers; expected the four numbers FX,FY,CX,CY, or a file"))
            }
        }
    }
}

/// Refuses numbers that no camera has. A focal length fy below 0 means that y points up (ICL-NUIM).
pub(crate) fn check_intrinsics(found: &Intrinsics) -> Result<(), String> {
    let Intrinsics { fx, fy, cx, cy } = *found;
    let wrong = |name: &str, value: f64, expected: &str| {
        Err(format!("{name} is {value}; expected {expected}, in pixels"))
    };
    if !(fx.is_finite() && fx > 0.0) {
        return wrong("fx", fx, "a focal length over 0");
    }
    if !fy.is_finite() || fy == 0.0 {
        return wrong("fy", fy, "a focal length over 0, or below 0 for a y axis that points up");
    }
    match [("cx", cx), ("cy", cy)].into_iter().find(|(_, value)| !value.is_finite()) {
        Some((name, value)) => wrong(name, value, "a finite number"),
        None => Ok(()),
    }
}
