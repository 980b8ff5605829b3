//! `scan.json`: the manifest of a scan.
//!
//! ```json
//! { "name": "room", "unit": "m", "sigma": 0.004,
//!   "planes": { "normal": [0, 0, 1], "offset": 0.05, "interval": 0.05 },
//!   "views": [
//!     { "file": "range_000.npy", "sensor": "spherical", "rows": 512, "cols": 1024,
//!       "theta0": -3.14, "dtheta": 0.006, "phi0": -1.3, "dphi": 0.005,
//!       "pose": [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1] } ] }
//! ```
//!
//! | key | meaning |
//! |---|---|
//! | `unit` | length unit of everything: `m dm cm mm um in ft`; no default |
//! | `sigma` | standard deviation of a range along its ray; optional |
//! | `planes` | plane k is normal · p = offset + k · interval; optional |
//! | `planes.guide` | a curve instead of the normal: `{"kind": "spline", "points": [[x, y, z], …]}`; `"kind": {"polyline": RADIUS}` is straight pieces with corners rounded by arcs up to that radius |
//! | `file` | the image, relative to the manifest |
//! | `pose` | 16 numbers, row-major, sensor to world |
//! | `pose_true` | the same, if it is known to be better; kept as information, never used |
//! | `rows`, `cols` | of the range image; optional, but must be right |
//! | `sensor` | one of the following, each with keys of its own |
//!
//! | sensor | keys and image |
//! |---|---|
//! | `spherical` | `theta0 dtheta phi0 dphi` in radians: column j looks along theta0 + j · dtheta, row i along phi0 + i · dphi; pixels hold the range |
//! | `pinhole` | `fx fy cx cy` in pixels, `distortion` or `rays`, `holds`; pixels hold the depth along z or the ray's length; see `sensor/pinhole.rs` |
//! | `light_stripe` | camera, base line, mirror, laser angles, `stripe`; pixels hold the stripe's place in its camera row, or are found in a stack of intensity images; see `sensor/light_stripe.rs` |
//! | `lookup_table` | `calibration`, scanning angles, linear axis, mounting; pixels hold the place on the detector; see `sensor/lookup_table.rs` |
//! | `grid` | `viewpoint` [x, y, z], where all rays start; a `.npy` of rows × cols × 3 points |
//!
//! Images are `.npy`, NaN or 0 = missing, in the unit of the sensor's pixels (the length unit for
//! ranges and depths), or 16-bit grey `.png` with `depth_scale` in that unit per count, 0 and 65535
//! = missing. Files that keys name are relative to the manifest. Notes by other programs (`scene`,
//! `size`, `truth`, `seed`, `comment`, `description`) are accepted; any other key is told, also one
//! of another sensor. `NaN` and `Infinity`, which some programs write though JSON has no such
//! numbers, are read as "not a number".

mod keys;
mod read;
mod sensor;
#[cfg(test)]
mod tests;
mod word;

pub use sensor::{
    AnglesEntry, LensEntry, LightStripeEntry, LookupTableEntry, PinholeEntry, SensorEntry,
    StripeEntry, ViewpointsEntry,
};

use crate::pose::{self, Pose};
use crate::sensor_source::SensorSource;
use crate::{Place, PlanesEntry, ReadError, Scan, ScanView};
use serde::Serialize;
use std::collections::HashSet;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect_geometry::LengthUnit;

/// What a manifest says, before any image is touched.
#[derive(Debug, Clone, PartialEq)]
pub struct Manifest {
    /// What reports call the scan.
    pub name: String,
    /// The unit of every length; `None` if nobody has said it yet.
    pub unit: Option<LengthUnit>,
    /// Standard deviation of a range along its ray, in the length unit, if known.
    pub sigma: Option<f64>,
    /// The planes to model on, if the scan asks for some.
    pub planes: Option<PlanesEntry>,
    /// Longest side of the box around a simulated scene, in the length unit: information for
    /// programs that score models in shares of it.
    pub size: Option<f64>,
    /// The views in order.
    pub views: Vec<ViewEntry>,
}

/// One view of a manifest.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ViewEntry {
    /// The image's file, relative to the manifest or absolute.
    pub file: String,
    /// Kind of sensor and its parameters.
    #[serde(flatten)]
    pub sensor: SensorEntry,
    /// Rows of the image, to be checked against the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rows: Option<usize>,
    /// Columns of the image, to be checked against the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cols: Option<usize>,
    /// Length units per count, for `.png` images.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_scale: Option<f64>,
    /// `world_from_sensor`, row-major homogeneous; see [`row_major`](crate::row_major).
    pub pose: [f64; 16],
    /// The pose that is known to be right, where `pose` may not be; kept for those who compare,
    /// never used for modelling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose_true: Option<[f64; 16]>,
}

/// Opens a manifest as a scan.
pub(crate) fn open(path: &Path, unit: Option<LengthUnit>) -> Result<Scan, ReadError> {
    let (manifest, notes) = read_manifest(path)?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let mut scan = to_scan(path, &folder, &manifest, unit)?;
    scan.notes.splice(0..0, notes);
    scan.inputs.insert(0, path.to_owned());
    Ok(scan)
}

/// Reads a manifest, with a note for every key nobody knows.
///
/// # Errors
/// [`ReadError`] naming file, view and key if something is missing or not what it should be.
pub fn read_manifest(path: &Path) -> Result<(Manifest, Vec<String>), ReadError> {
    let text = crate::error::read_text(path)?;
    read::manifest(path, &text)
}

/// The scan a manifest describes; `path` is what messages name, `folder` where files are.
pub(crate) fn to_scan(
    path: &Path,
    folder: &Path,
    manifest: &Manifest,
    unit: Option<LengthUnit>,
) -> Result<Scan, ReadError> {
    let unit = crate::scan::settle_unit(path, manifest.unit, unit)?;
    if let Some(planes) = &manifest.planes {
        let usable = planes.family();
        usable.map_err(|e| ReadError::unusable(path, Place::Whole, "\"planes\"", e))?;
    }
    if manifest.views.is_empty() {
        return Err(ReadError::damaged(path, Place::Whole, "there are no views"));
    }
    let mut repairs = Repairs::default();
    let mut sensors = Sensors { folder, made: Vec::new() };
    let mut views = Vec::with_capacity(manifest.views.len());
    for (number, entry) in manifest.views.iter().enumerate() {
        let at = Place::View { number, name: entry.file.clone() };
        let pose = pose::from_row_major(&entry.pose)
            .map_err(|problem| ReadError::damaged(path, at.clone(), problem))?;
        repairs.count(&pose, &at);
        views.push(ScanView {
            name: entry.file.clone(),
            path: folder.join(&entry.file),
            sensor: sensors.source(&entry.sensor),
            stated_rows: entry.rows,
            stated_cols: entry.cols,
            depth_scale: entry.depth_scale,
            world_from_sensor: pose.world_from_sensor,
            sigma: manifest.sigma,
        });
    }
    Ok(Scan {
        name: manifest.name.clone(),
        unit,
        sigma: manifest.sigma,
        planes: manifest.planes.clone(),
        inputs: files(&views)?,
        notes: repairs.note(path, views.len()).into_iter().collect(),
        views,
    })
}

/// The sensors of a manifest's views: views that say the same share one, so that its tables are
/// made once.
struct Sensors<'a> {
    folder: &'a Path,
    made: Vec<(&'a SensorEntry, Arc<SensorSource>)>,
}

impl<'a> Sensors<'a> {
    fn source(&mut self, entry: &'a SensorEntry) -> Arc<SensorSource> {
        if let Some((_, known)) = self.made.iter().find(|(e, _)| *e == entry) {
            return Arc::clone(known);
        }
        let source = Arc::new(SensorSource::new(self.folder, entry));
        self.made.push((entry, Arc::clone(&source)));
        source
    }
}

/// Every file the views are read from, each once: images first, then what their sensors name.
fn files(views: &[ScanView]) -> Result<Vec<PathBuf>, ReadError> {
    let mut files: Vec<PathBuf> = Vec::new();
    let mut seen = HashSet::new();
    let mut add = |file: PathBuf| {
        if seen.insert(file.clone()) {
            files.push(file);
        }
    };
    for view in views {
        view.sensor.image_files(&view.path)?.into_iter().for_each(&mut add);
    }
    views.iter().filter_map(|v| v.sensor.file()).map(Path::to_owned).for_each(add);
    Ok(files)
}

/// Poses that were replaced by the nearest rotation: one note for all of them.
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

/// Writes a manifest that [`Scan::open`] reads, one view per line.
///
/// # Errors
/// What `out` says.
pub fn write_manifest(manifest: &Manifest, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{{ \"name\": {},", serde_json::to_string(&manifest.name)?)?;
    if let Some(unit) = manifest.unit {
        writeln!(out, "  \"unit\": {},", serde_json::to_string(&unit)?)?;
    }
    if let Some(sigma) = manifest.sigma {
        writeln!(out, "  \"sigma\": {},", serde_json::to_string(&sigma)?)?;
    }
    if let Some(planes) = &manifest.planes {
        writeln!(out, "  \"planes\": {},", serde_json::to_string(&planes)?)?;
    }
    if let Some(size) = manifest.size {
        writeln!(out, "  \"size\": {},", serde_json::to_string(&size)?)?;
    }
    write!(out, "  \"views\": [")?;
    for (number, view) in manifest.views.iter().enumerate() {
        let separator = if number > 0 { "," } else { "" };
        write!(out, "{separator}\n    {}", serde_json::to_string(view)?)?;
    }
    writeln!(out, " ] }}")
}
