//! From a manifest to a scan: poses checked, sensors shared, files listed.

use super::entry::Manifest;
use super::sensor::{self, Sensor, SensorEntry};
use crate::pose::{self, Pose};
use crate::scan::{FramedImage, LoadView};
use crate::view_file::ViewFile;
use crate::{Place, ReadError, Scan, ScanView};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect_geometry::LengthUnit;

/// A view of a manifest: its image file, and its sensor.
#[derive(Debug)]
struct ManifestView {
    file: ViewFile,
    /// Views with equal entries share one sensor, and with it the sensor's tables.
    sensor: Arc<dyn Sensor>,
}

impl LoadView for ManifestView {
    fn load(&self, notes: &mut Vec<String>) -> Result<FramedImage, ReadError> {
        self.sensor.load(&self.file, notes)
    }
}

/// The scan a manifest describes. Messages name `path`; files are relative to `folder`.
pub(crate) fn to_scan(
    path: &Path,
    folder: &Path,
    manifest: &Manifest,
    unit: Option<LengthUnit>,
) -> Result<Scan, ReadError> {
    let unit = settle_unit(path, manifest.unit, unit)?;
    if let Some(planes) = &manifest.planes {
        let usable = planes.family();
        usable.map_err(|e| ReadError::unusable(path, Place::Whole, "\"planes\"", e))?;
    }
    if manifest.views.is_empty() {
        return Err(ReadError::damaged(path, Place::Whole, "there are no views"));
    }
    let mut repairs = Repairs::default();
    let mut sensors = Sensors { folder, made: Vec::new() };
    let mut files = Files::default();
    let mut views = Vec::with_capacity(manifest.views.len());
    for (number, entry) in manifest.views.iter().enumerate() {
        let at = Place::View { number, name: entry.file.clone() };
        let pose = pose::from_row_major(&entry.pose)
            .map_err(|problem| ReadError::damaged(path, at.clone(), problem))?;
        repairs.count(&pose, &at);
        let sensor = sensors.get_or_make(&entry.sensor);
        let file = ViewFile {
            path: folder.join(&entry.file),
            stated_rows: entry.rows,
            stated_cols: entry.cols,
            scale: entry.scale,
            missing: entry.missing,
        };
        sensor.image_files(&file.path)?.into_iter().for_each(|image| files.add(image));
        let (name, path) = (entry.file.clone(), file.path.clone());
        let source = Arc::new(ManifestView { file, sensor });
        let view = ScanView::new(name, path, pose.world_from_sensor, source);
        views.push(view.with_sigma(manifest.sigma));
    }
    sensors.made.iter().filter_map(|(_, s)| s.file()).for_each(|f| files.add(f.to_owned()));
    Ok(Scan {
        name: manifest.name.clone(),
        unit,
        sigma: manifest.sigma,
        planes: manifest.planes.clone(),
        inputs: files.list,
        notes: repairs.note(path, views.len()).into_iter().collect(),
        views,
    })
}

/// The unit of a scan: the stated one, or the caller's if none is stated.
fn settle_unit(
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

/// The sensors of a manifest's views. Equal entries get the same sensor, so that its tables are
/// made once.
struct Sensors<'a> {
    folder: &'a Path,
    made: Vec<(&'a SensorEntry, Arc<dyn Sensor>)>,
}

impl<'a> Sensors<'a> {
    fn get_or_make(&mut self, entry: &'a SensorEntry) -> Arc<dyn Sensor> {
        if let Some((_, known)) = self.made.iter().find(|(e, _)| *e == entry) {
            return Arc::clone(known);
        }
        let sensor = sensor::of_entry(self.folder, entry);
        self.made.push((entry, Arc::clone(&sensor)));
        sensor
    }
}

/// A list of files without repetitions.
#[derive(Default)]
struct Files {
    list: Vec<PathBuf>,
    known: HashSet<PathBuf>,
}

impl Files {
    fn add(&mut self, file: PathBuf) {
        if self.known.insert(file.clone()) {
            self.list.push(file);
        }
    }
}

/// Counts poses that were replaced by the nearest rotation, for one note about all of them.
#[derive(Default)]
struct Repairs {
    count: usize,
    worst: f64,
    worst_at: Option<Place>,
}

impl Repairs {
    fn count(&mut self, pose: &Pose, at: &Place) {
        let Some(deviation) = pose.repaired else { return };
        self.count += 1;
        if deviation > self.worst {
            (self.worst, self.worst_at) = (deviation, Some(at.clone()));
        }
    }

    fn note(&self, path: &Path, views: usize) -> Option<String> {
        let (count, worst, path) = (self.count, self.worst, path.display());
        let at = self.worst_at.as_ref()?;
        Some(format!(
            "{path}: {count} of {views} poses replaced by the nearest rotation; \
             largest deviation from orthonormal {worst:.1e}{at}"
        ))
    }
}
