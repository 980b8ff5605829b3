//! A scan: views that wait to be loaded, and what is known about all of them.

use crate::image_file::{self, Pixels};
use crate::sensor_source::SensorSource;
use crate::{Place, ReadError, Unusable, depth_folder, manifest, stanford};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect_device::{ImageSize, Isometry3, RangeImage, View};
use transect_geometry::{
    CurvedGuide, Guide, GuideError, LengthUnit, PlaneFamily, StraightGuide, Vector3,
};
use transect_sensors::SensorError;

/// The planes a scan's manifest asks for: plane k is `normal · p = offset + k · interval`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlanesEntry {
    /// Direction of the guide in the world; need not have unit length.
    pub normal: [f64; 3],
    /// Station of plane 0, in the model's length unit.
    pub offset: f64,
    /// Distance between neighbouring planes, in the model's length unit.
    pub interval: f64,
    /// A curved guide, along which stations count instead; the normal then means nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guide: Option<Arc<CurvedGuide>>,
}

impl PlanesEntry {
    /// The planes themselves.
    ///
    /// # Errors
    /// [`GuideError`] if the normal has no direction, the interval is not positive or the offset not
    /// finite.
    pub fn family(&self) -> Result<PlaneFamily, GuideError> {
        let guide = match &self.guide {
            Some(guide) => Arc::clone(guide).into(),
            None => Guide::from(StraightGuide::along(Vector3::from(self.normal))?),
        };
        PlaneFamily::new(guide, self.offset, self.interval)
    }
}

/// A registered set of range images, read except for the images.
///
/// Opening reads the small files only; [`ScanView::load`] reads one image. Views keep the order of
/// their manifest.
#[derive(Debug, Clone)]
pub struct Scan {
    /// What reports call it.
    pub name: String,
    /// The unit of every length in it.
    pub unit: LengthUnit,
    /// Standard deviation of a range along its ray, in the length unit, if stated.
    pub sigma: Option<f64>,
    /// The planes it asks for, if any.
    pub planes: Option<PlanesEntry>,
    /// The views in order.
    pub views: Vec<ScanView>,
    /// What the reader assumed, repaired or ignored; for the report.
    pub notes: Vec<String>,
    /// Every file the scan is made of, for hashing: the manifest first, then the views' images, then
    /// what their sensors are read from.
    pub inputs: Vec<PathBuf>,
}

impl Scan {
    /// Opens a scan whose files state their unit, or have one by convention.
    ///
    /// # Errors
    /// See [`Scan::open_with_unit`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        Self::open_with_unit(path, None)
    }

    /// Opens a scan: a folder with `scan.json`, a manifest (`*.json`), a Stanford configuration
    /// (`*.conf`), or a folder of depth images with poses and `camera-intrinsics.txt`.
    ///
    /// `unit` stands in for a unit the files do not state; it never converts.
    ///
    /// # Errors
    /// [`ReadError`] if the path is none of these, a file is damaged, the unit is missing, or it is
    /// stated and differs from `unit`.
    pub fn open_with_unit(path: &Path, unit: Option<LengthUnit>) -> Result<Self, ReadError> {
        let metadata = std::fs::metadata(path)
            .map_err(|source| ReadError::Io { path: path.to_owned(), source })?;
        let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        match extension.as_deref() {
            _ if metadata.is_dir() => open_folder(path, unit),
            Some("json") => manifest::open(path, unit),
            Some("conf") => stanford::open(path, unit),
            _ => Err(ReadError::NotAScan { path: path.to_owned() }),
        }
    }
}

fn open_folder(folder: &Path, unit: Option<LengthUnit>) -> Result<Scan, ReadError> {
    let manifest = folder.join("scan.json");
    if manifest.is_file() {
        return manifest::open(&manifest, unit);
    }
    if folder.join(depth_folder::INTRINSICS).is_file() {
        return depth_folder::open(folder, unit);
    }
    Err(ReadError::NotAScan { path: folder.to_owned() })
}

/// The unit of a scan from what its files state and what the caller says.
pub(crate) fn settle_unit(
    path: &Path,
    stated: Option<LengthUnit>,
    asked: Option<LengthUnit>,
) -> Result<LengthUnit, ReadError> {
    match (stated, asked) {
        (Some(stated), Some(asked)) if stated != asked => {
            Err(ReadError::UnitConflict { path: path.to_owned(), stated, asked })
        }
        (stated, asked) => {
            stated.or(asked).ok_or_else(|| ReadError::NoUnit { path: path.to_owned() })
        }
    }
}

/// One view of a scan, not yet loaded; cheap to keep and to send to another thread.
#[derive(Debug, Clone)]
pub struct ScanView {
    pub(crate) name: String,
    pub(crate) path: PathBuf,
    /// Shared by all views that say the same about theirs.
    pub(crate) sensor: Arc<SensorSource>,
    /// Rows and columns, where the manifest states them.
    pub(crate) stated_rows: Option<usize>,
    pub(crate) stated_cols: Option<usize>,
    /// Length units per count of an integer image.
    pub(crate) depth_scale: Option<f64>,
    pub(crate) world_from_sensor: Isometry3,
    pub(crate) sigma: Option<f64>,
}

impl ScanView {
    /// What reports call it: its file's name as the manifest gives it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The file that holds its image.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The pose: world coordinates from sensor coordinates.
    pub fn world_from_sensor(&self) -> &Isometry3 {
        &self.world_from_sensor
    }

    /// Reads the image and makes the view, with notes on what the reader found odd.
    ///
    /// # Errors
    /// [`ReadError`] naming the file if it is missing, damaged, of another size than stated, or
    /// without a single valid pixel.
    pub fn load(&self) -> Result<(View, Vec<String>), ReadError> {
        let mut notes = Vec::new();
        let (frame, image) = self.sensor.load(self, &mut notes)?;
        let view = View::new(self.name.clone(), image, frame, self.world_from_sensor, self.sigma);
        let view = view.map_err(|e| self.unusable("the view", e))?;
        let notes = notes.into_iter().map(|n| format!("{}: {n}", self.path.display())).collect();
        Ok((view, notes))
    }

    /// The range image in the view's file, of the size the manifest states.
    pub(crate) fn load_image(&self, notes: &mut Vec<String>) -> Result<RangeImage, ReadError> {
        let Pixels { size, values } = image_file::read(&self.path, self.depth_scale, notes)?;
        self.check_size(size)?;
        RangeImage::from_values(size, values).map_err(|e| self.unusable("the image", e))
    }

    /// What is wrong with something that was to be made of the view's numbers.
    pub(crate) fn unusable(&self, what: &'static str, why: impl Into<Unusable>) -> ReadError {
        ReadError::unusable(&self.path, Place::Whole, what, why)
    }

    pub(crate) fn bad_sensor(&self, why: SensorError) -> ReadError {
        self.unusable("the sensor", why)
    }

    pub(crate) fn check_size(&self, found: ImageSize) -> Result<(), ReadError> {
        let stated = ImageSize {
            rows: self.stated_rows.unwrap_or(found.rows),
            cols: self.stated_cols.unwrap_or(found.cols),
        };
        if stated == found {
            return Ok(());
        }
        let problem = format!("the image has {found}, but the manifest states {stated}");
        Err(ReadError::damaged(&self.path, Place::Whole, problem))
    }

    /// Refuses a stated number of rows or columns of a range image that is still in a stack.
    pub(crate) fn check_stated(
        &self,
        key: &str,
        stated: Option<usize>,
        found: usize,
        parts: &str,
    ) -> Result<(), ReadError> {
        match stated.filter(|s| *s != found) {
            Some(stated) => {
                let problem = format!("the stack has {found} {parts}, but \"{key}\" is {stated}");
                Err(ReadError::damaged(&self.path, Place::Whole, problem))
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_scan_is_told_what_would_be() {
        let folder = tempfile::tempdir().unwrap();
        let error = Scan::open(folder.path()).unwrap_err().to_string();
        assert!(error.contains("accepted are a folder with scan.json"), "{error}");
        let missing = Scan::open(&folder.path().join("nowhere")).unwrap_err();
        assert!(matches!(missing, ReadError::Io { .. }), "{missing}");
        let text = folder.path().join("notes.txt");
        std::fs::write(&text, "no scan").unwrap();
        assert!(matches!(Scan::open(&text), Err(ReadError::NotAScan { .. })));
    }

    #[test]
    fn views_can_be_loaded_on_other_threads() {
        fn shared_between_threads<T: Send + Sync>() {}
        shared_between_threads::<ScanView>();
        shared_between_threads::<ReadError>();
    }
}
