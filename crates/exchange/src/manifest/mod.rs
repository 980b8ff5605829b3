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
//! | `file` | the image, relative to the manifest |
//! | `pose` | 16 numbers, row-major, sensor to world |
//! | `rows`, `cols` | optional; must be the image's |
//! | `spherical` | `theta0 dtheta phi0 dphi` in radians: column j looks along theta0 + j · dtheta, row i along phi0 + i · dphi; pixels hold the range |
//! | `pinhole` | `fx fy cx cy` in pixels; pixels hold the depth along z |
//! | `grid` | `viewpoint` [x, y, z], where all rays start; a `.npy` of rows × cols × 3 points |
//!
//! Images are `.npy` in the length unit, NaN or 0 = missing, or 16-bit grey `.png` with
//! `depth_scale` in length units per count, 0 and 65535 = missing. Notes by other programs
//! (`scene`, `size`, `truth`, `seed`, `comment`, `description`, `pose_true`) are accepted; any other key is
//! told. `NaN` and `Infinity`, which some programs write though JSON has no such numbers, are
//! read as "not a number".

mod keys;
mod read;
#[cfg(test)]
mod tests;

use crate::pose::{self, Pose};
use crate::scan::SensorSource;
use crate::{Place, PlanesEntry, ReadError, Scan, ScanView};
use serde::Serialize;
use std::io::{self, Write};
use std::path::Path;
use transect_geometry::{LengthUnit, Point3};
use transect_sensors::{AngularScan, Intrinsics};

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
}

/// The sensors a manifest can name.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
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
    /// A depth camera; all in pixels.
    Pinhole {
        /// Focal length along columns.
        fx: f64,
        /// Focal length along rows.
        fy: f64,
        /// Column of the optical axis.
        cx: f64,
        /// Row of the optical axis.
        cy: f64,
    },
    /// An organised grid of points.
    Grid {
        /// Where all rays start, in the sensor frame and the length unit.
        viewpoint: [f64; 3],
    },
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
    if let Some(planes) = manifest.planes {
        let usable = planes.family();
        usable.map_err(|e| ReadError::unusable(path, Place::Whole, "\"planes\"", e))?;
    }
    if manifest.views.is_empty() {
        return Err(ReadError::damaged(path, Place::Whole, "there are no views"));
    }
    let mut repairs = Repairs::default();
    let mut views = Vec::with_capacity(manifest.views.len());
    for (number, entry) in manifest.views.iter().enumerate() {
        let at = Place::View { number, name: entry.file.clone() };
        let pose = pose::from_row_major(&entry.pose)
            .map_err(|problem| ReadError::damaged(path, at.clone(), problem))?;
        repairs.count(&pose, &at);
        views.push(scan_view(folder, entry, &pose, manifest.sigma));
    }
    Ok(Scan {
        name: manifest.name.clone(),
        unit,
        sigma: manifest.sigma,
        planes: manifest.planes,
        inputs: views.iter().map(|v| v.path.clone()).collect(),
        notes: repairs.note(path, views.len()).into_iter().collect(),
        views,
    })
}

fn scan_view(folder: &Path, entry: &ViewEntry, pose: &Pose, sigma: Option<f64>) -> ScanView {
    let sensor = match entry.sensor {
        SensorEntry::Spherical { theta0, dtheta, phi0, dphi } => SensorSource::Spherical {
            theta: AngularScan::from_radians(theta0, dtheta),
            phi: AngularScan::from_radians(phi0, dphi),
        },
        SensorEntry::Pinhole { fx, fy, cx, cy } => {
            SensorSource::Pinhole(Intrinsics { fx, fy, cx, cy })
        }
        SensorEntry::Grid { viewpoint } => SensorSource::Grid(Point3::from(viewpoint)),
    };
    ScanView {
        name: entry.file.clone(),
        path: folder.join(&entry.file),
        sensor,
        stated_rows: entry.rows,
        stated_cols: entry.cols,
        depth_scale: entry.depth_scale,
        world_from_sensor: pose.world_from_sensor,
        sigma,
    }
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
    if let Some(planes) = manifest.planes {
        writeln!(out, "  \"planes\": {},", serde_json::to_string(&planes)?)?;
    }
    write!(out, "  \"views\": [")?;
    for (number, view) in manifest.views.iter().enumerate() {
        let separator = if number > 0 { "," } else { "" };
        write!(out, "{separator}\n    {}", serde_json::to_string(view)?)?;
    }
    writeln!(out, " ] }}")
}
