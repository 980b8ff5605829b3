//! A scan as data: its views, which are loaded later, and the facts that hold for all of them.
//!
//! Every reader of a scan format makes a [`Scan`]. The formats are listed in `open.rs`; this file
//! knows none of them. A view keeps a [`LoadView`], which reads its image when it is asked to.

use crate::{Place, ReadError, Unusable};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect_device::{DeviceFrame, ImageOrder, Isometry3, Note, RangeImage, View, ViewError};
use transect_geometry::{
    CurvedGuide, Guide, GuideError, LengthUnit, PlaneFamily, StraightGuide, Vector3,
};

/// The section planes a scan asks for: plane k is `normal · p = offset + k · interval`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PlanesEntry {
    /// Direction of the guide in the world; it need not have unit length.
    #[serde(default = "upright")]
    pub normal: [f64; 3],
    /// Station of plane 0, in the scan's length unit.
    pub offset: f64,
    /// Distance between neighbouring planes, in the scan's length unit.
    pub interval: f64,
    /// A curved guide. If it is given, stations count along it and `normal` is not used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guide: Option<Arc<CurvedGuide>>,
}

/// The normal that files need not state beside a guide.
fn upright() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

impl PlanesEntry {
    /// Planes across a straight guide.
    pub fn new(normal: [f64; 3], offset: f64, interval: f64) -> Self {
        Self { normal, offset, interval, guide: None }
    }

    /// The planes themselves.
    ///
    /// # Errors
    /// [`GuideError`] if the normal has no direction, the interval is not positive or the offset
    /// is not finite.
    pub fn family(&self) -> Result<PlaneFamily, GuideError> {
        let guide = match &self.guide {
            Some(guide) => Arc::clone(guide).into(),
            None => Guide::from(StraightGuide::along(Vector3::from(self.normal))?),
        };
        PlaneFamily::new(guide, self.offset, self.interval)
    }
}

impl From<&PlaneFamily> for PlanesEntry {
    fn from(planes: &PlaneFamily) -> Self {
        Self {
            normal: planes.guide().direction(0.0).into(),
            offset: planes.offset(),
            interval: planes.interval(),
            guide: planes.guide().curved().cloned(),
        }
    }
}

/// A registered set of range images. Opening it reads the small files; the images stay on disk.
///
/// ```
/// use transect_device::ImageSize;
/// use transect_exchange::{Scan, write_file, write_npy_image};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let folder = tempfile::tempdir()?;
/// # let folder = folder.path();
/// let size = ImageSize { rows: 2, cols: 2 };
/// write_file(&folder.join("range.npy"), |out| write_npy_image(size, &[2.0; 4], out))?;
/// let manifest = r#"{ "unit": "m", "views": [
///     { "file": "range.npy", "sensor": "pinhole", "fx": 2, "fy": 2, "cx": 0.5, "cy": 0.5,
///       "pose": [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1] } ] }"#;
/// std::fs::write(folder.join("scan.json"), manifest)?;
///
/// let scan = Scan::open(folder)?;
/// assert_eq!(scan.views.len(), 1);
/// let (view, notes) = scan.views[0].load()?;
/// assert_eq!((view.name(), view.image().size()), ("range.npy", size));
/// assert!(notes.is_empty());
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Scan {
    /// The name that reports show.
    pub name: String,
    /// The unit of every length in the scan.
    pub unit: LengthUnit,
    /// Standard deviation of a range along its ray, in the length unit, if the scan states it.
    pub sigma: Option<f64>,
    /// The section planes the scan asks for, if any.
    pub planes: Option<PlanesEntry>,
    /// The views, in the order of the file that lists them.
    pub views: Vec<ScanView>,
    /// Assumptions, repairs and ignored content, for the report.
    pub notes: Vec<Note>,
    /// Every file of the scan, for hashing: first the file that lists the views, then their
    /// images, then the files of their sensors.
    pub inputs: Vec<PathBuf>,
}

/// How far a view's pose may be wrong, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoseSigma {
    /// Of the rotation about each axis, in radians.
    pub rotation: f64,
    /// Of the place along each axis, in the scan's length unit.
    pub translation: f64,
}

/// The form of a `surface_sigma` in messages.
pub(crate) const SURFACE_SIGMA: &str = "a finite length of 0 or more";

/// Whether a number can be a `surface_sigma`.
pub(crate) fn is_surface_sigma(sigma: f64) -> bool {
    sigma.is_finite() && sigma >= 0.0
}

/// One view of a scan, not yet loaded. It is cheap to clone and can be sent to another thread.
#[derive(Debug, Clone)]
pub struct ScanView {
    name: String,
    path: PathBuf,
    world_from_sensor: Isometry3,
    sigma: Option<f64>,
    pose_sigma: Option<PoseSigma>,
    surface_sigma: Option<f64>,
    source: Arc<dyn LoadView>,
}

/// Reads the image of one view and makes its device frame.
///
/// A format implements this for a type that holds the view's place: a file, or a part of a large
/// file with many views. Views of one file share it (through an `Arc`), and each loads its
/// own part, so that a scan is never in memory as a whole.
pub trait LoadView: fmt::Debug + Send + Sync {
    /// Reads the image. The texts of notes on repairs and ignored content go to `notes`.
    ///
    /// # Errors
    /// [`ReadError`] naming the file.
    fn load(&self, notes: &mut Vec<String>) -> Result<FramedImage, ReadError>;

    /// The same view, its file read in another order of pixels; `None` where the format or the
    /// sensor has one order only.
    fn in_order(&self, _: ImageOrder) -> Option<Arc<dyn LoadView>> {
        None
    }

    /// The part of its file that holds the view. Its notes name the file and this part.
    fn place(&self) -> Place {
        Place::Whole
    }
}

/// A range image and the device frame that its pixels belong to.
#[derive(Debug, Clone)]
pub struct FramedImage {
    /// The sensor's grid of rays.
    pub frame: Arc<dyn DeviceFrame>,
    /// The values on these rays.
    pub image: RangeImage,
}

impl ScanView {
    /// A view of `source`. `path` is the file that messages name.
    pub fn new(
        name: String,
        path: PathBuf,
        world_from_sensor: Isometry3,
        source: Arc<dyn LoadView>,
    ) -> Self {
        let (sigma, pose_sigma, surface_sigma) = (None, None, None);
        Self { name, path, world_from_sensor, sigma, pose_sigma, surface_sigma, source }
    }

    /// The same view with the standard deviation of a range along its ray; `None`: unknown.
    pub fn with_sigma(self, sigma: Option<f64>) -> Self {
        Self { sigma, ..self }
    }

    /// The same view with a statement of how far its pose may be wrong; `None`: unknown.
    pub fn with_pose_sigma(self, pose_sigma: Option<PoseSigma>) -> Self {
        Self { pose_sigma, ..self }
    }

    /// How far the pose may be wrong, if the scan states it.
    pub fn pose_sigma(&self) -> Option<PoseSigma> {
        self.pose_sigma
    }

    /// The same view with a statement of how far its surface may be off along its normals with its
    /// pose, in the scan's length unit; `None`: unknown.
    pub fn with_surface_sigma(self, surface_sigma: Option<f64>) -> Self {
        Self { surface_sigma, ..self }
    }

    /// How far the surface may be off along its normals, if the scan states it.
    pub fn surface_sigma(&self) -> Option<f64> {
        self.surface_sigma
    }

    /// The same view at another pose, with which its surface may be off by an unknown length.
    pub fn with_pose(self, world_from_sensor: Isometry3) -> Self {
        Self { world_from_sensor, surface_sigma: None, ..self }
    }

    /// The same view, its file read in another order of pixels; `None` where its format or its
    /// sensor has one order only.
    pub fn in_order(&self, order: ImageOrder) -> Option<Self> {
        Some(Self { source: self.source.in_order(order)?, ..self.clone() })
    }

    /// The name that reports show: for a manifest, the key `name`, else the image's file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The file that holds the view's image.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The pose: world coordinates from sensor coordinates.
    pub fn world_from_sensor(&self) -> &Isometry3 {
        &self.world_from_sensor
    }

    /// Reads the image and makes the view, with notes on repaired or ignored content.
    ///
    /// # Errors
    /// [`ReadError`] naming the file if it is missing, damaged, of another size than stated, or
    /// without a single valid pixel.
    pub fn load(&self) -> Result<(View, Vec<Note>), ReadError> {
        let mut texts = Vec::new();
        let FramedImage { frame, image } = self.source.load(&mut texts)?;
        let view = View::new(self.name.clone(), image, frame, self.world_from_sensor, self.sigma);
        let unusable = |error| {
            let reason = match error {
                ViewError::NoValidPixel => Unusable::EmptyView(error),
                other => other.into(),
            };
            ReadError::unusable(&self.path, Place::Whole, "the view", reason)
        };
        let about = self.about();
        let notes = texts.into_iter().map(|text| Note::about(&about, text)).collect();
        Ok((view.map_err(unusable)?, notes))
    }

    /// The file and the part of it that notes name.
    fn about(&self) -> String {
        let path = self.path.display();
        match self.source.place() {
            Place::Whole => path.to_string(),
            part => format!("{path}: {}", part.words()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_can_be_loaded_on_other_threads() {
        fn shared_between_threads<T: Send + Sync>() {}
        shared_between_threads::<ScanView>();
        shared_between_threads::<ReadError>();
    }
}
