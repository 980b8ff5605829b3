//! From a manifest to a scan: poses checked, sensors shared, files listed.

use super::entry::{Manifest, ViewEntry};
use super::sensor::{self, Sensor, SensorEntry};
use crate::pose;
use crate::scan::{FramedImage, LoadView};
use crate::view_file::ViewFile;
use crate::{Place, ReadError, Scan, ScanView};
use std::collections::{BTreeMap, HashSet};
use std::path::Path;
use std::sync::Arc;
use transect_device::{ImageOrder, Note};
use transect_geometry::LengthUnit;

/// Most numbers of views that a note lists. Chosen by hand; doubled, the note takes two lines.
const NUMBERS: usize = 8;

/// A view of a manifest: its image file, and its sensor.
#[derive(Debug, Clone)]
struct ManifestView {
    file: ViewFile,
    /// Views with equal entries share one sensor, and with it the sensor's tables.
    sensor: Arc<dyn Sensor>,
}

impl LoadView for ManifestView {
    fn load(&self, notes: &mut Vec<String>) -> Result<FramedImage, ReadError> {
        self.sensor.load(&self.file, notes)
    }

    fn in_order(&self, order: ImageOrder) -> Option<Arc<dyn LoadView>> {
        let reads = self.file.order.is_none() && self.sensor.reads(order);
        let file = ViewFile { order: Some(order), ..self.file.clone() };
        reads.then(|| Arc::new(Self { file, ..self.clone() }) as Arc<dyn LoadView>)
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
    let mut repairs = Vec::new();
    // Equal entries get the same sensor, so that its tables are made once.
    let mut sensors: Vec<(&SensorEntry, Arc<dyn Sensor>)> = Vec::new();
    let mut inputs = Vec::new();
    let mut views = Vec::with_capacity(manifest.views.len());
    for (number, entry) in manifest.views.iter().enumerate() {
        let at = Place::View { number, name: entry.file.clone() };
        let pose = pose::from_row_major(&entry.pose)
            .map_err(|problem| ReadError::damaged(path, at.clone(), problem))?;
        repairs.extend(pose.repaired.map(|deviation| (deviation, at)));
        let known = sensors.iter().find(|(made_of, _)| *made_of == &entry.sensor);
        let sensor = known.map(|(_, sensor)| Arc::clone(sensor)).unwrap_or_else(|| {
            let made = sensor::of_entry(folder, &entry.sensor);
            sensors.push((&entry.sensor, Arc::clone(&made)));
            made
        });
        let file = view_file(folder, entry);
        inputs.extend(sensor.image_files(&file.path)?);
        let name = entry.name.as_ref().unwrap_or(&entry.file).clone();
        let path = file.path.clone();
        let source = Arc::new(ManifestView { file, sensor });
        let view = ScanView::new(name, path.clone(), pose.world_from_sensor, source);
        let view = match entry.image_order {
            Some(order) => view.in_order(order).ok_or_else(|| no_order(&path, order))?,
            None => view,
        };
        let view = view.with_sigma(manifest.sigma).with_pose_sigma(entry.pose_sigma);
        views.push(view.with_surface_sigma(entry.surface_sigma));
    }
    inputs.extend(sensors.iter().filter_map(|(_, sensor)| Some(sensor.file()?.to_owned())));
    let mut known = HashSet::new();
    inputs.retain(|file| known.insert(file.clone()));
    Ok(Scan {
        name: manifest.name.clone(),
        unit,
        sigma: manifest.sigma,
        planes: manifest.planes.clone(),
        inputs,
        notes: pose::repairs_note(path, &repairs, views.len())
            .into_iter()
            .chain(repeated_files(manifest).map(|text| Note::about(path.display(), text)))
            .collect(),
        views,
    })
}

/// A note on every file that several views name.
fn repeated_files(manifest: &Manifest) -> impl Iterator<Item = String> {
    let mut views: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (number, view) in manifest.views.iter().enumerate() {
        views.entry(&view.file).or_default().push(number);
    }
    views.into_iter().filter(|(_, numbers)| numbers.len() > 1).map(|(file, numbers)| {
        let (count, first) = (numbers.len(), numbers.iter().take(NUMBERS));
        let first = first.map(usize::to_string).collect::<Vec<_>>().join(", ");
        let more = if count > NUMBERS { ", …" } else { "" };
        format!(
            "{count} views have the same image {file}: views {first}{more}; expected an image of \
             its own for every view; correct \"file\", or remove the repeated views"
        )
    })
}

/// The image file of a view.
fn view_file(folder: &Path, entry: &ViewEntry) -> ViewFile {
    ViewFile {
        path: folder.join(&entry.file),
        stated_rows: entry.rows,
        stated_cols: entry.cols,
        scale: entry.scale,
        missing: entry.missing,
        order: None,
    }
}

/// The error for a view whose images are in one order only.
pub(crate) fn no_order(view: &Path, order: ImageOrder) -> ReadError {
    let problem = format!(
        "images of this format and sensor cannot be read as {order}: images of depth cameras \
         and of angular scans can (swapped-camera: of depth cameras without distortion), once"
    );
    ReadError::unsupported(view, Place::Whole, problem)
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
