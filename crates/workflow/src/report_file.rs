//! `report.json`: the table of a run, with its settings and the hashes of its inputs.

use crate::views::OpenScan;
use crate::{Check, Selection};
use rayon::prelude::*;
use serde::Serialize;
use serde_json::{Map, Value};
use sha2::{Digest, Sha256};
use std::io::{Error, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect::register::PoseReading;
use transect::{Report, Setup};
use transect_device::{ImageOrder, Note, PinholeScale};
use transect_exchange::{CameraOption, OpenOptions};
use transect_geometry::CurvedGuide;
use transect_model::open_regular;
use transect_sensors::Intrinsics;

/// The content of `report.json` without the table and the costs.
#[derive(Debug, Serialize)]
pub struct ReportFile<'a> {
    tool: &'static str,
    version: &'static str,
    /// Absolute path of the scan.
    scan: String,
    unit: &'static str,
    /// The part of the scan that was used.
    #[serde(skip_serializing_if = "Selection::is_whole")]
    selection: &'a Selection,
    /// The convention by which the poses were read, if it is not the scan's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pose_convention: Option<PoseReading>,
    /// The order in which the pixels were read, if it is not the scan's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    image_order: Option<ImageOrder>,
    /// Whether views without a file may have been left out.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    skip_missing: bool,
    /// What the user stated about the scan's files.
    #[serde(skip_serializing_if = "Stated::is_nothing")]
    stated: Stated,
    /// Checks of plausibility that were turned off.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    accepted: Vec<&'static str>,
    settings: Settings,
    inputs: Vec<Input>,
    warnings: Vec<String>,
    reader_notes: &'a [Note],
    #[serde(flatten)]
    report: &'a Report,
}

/// Options of a scan that its files leave open, as far as they were given.
#[derive(Debug, Default, PartialEq, Serialize)]
struct Stated {
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    poses: Option<String>,
    /// A file, or `fx`, `fy`, `cx` and `cy` in pixels.
    #[serde(skip_serializing_if = "Option::is_none")]
    camera: Option<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    depth_scale: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pixels_hold: Option<PinholeScale>,
    /// In seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    max_time_difference: Option<f64>,
    /// Rows and columns.
    #[serde(skip_serializing_if = "Option::is_none")]
    grid: Option<[usize; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rings: Option<usize>,
}

impl Stated {
    fn new(options: &OpenOptions) -> Self {
        let camera = options.camera.as_ref().map(|camera| match camera {
            CameraOption::File(path) => readable(path).into(),
            CameraOption::Numbers(Intrinsics { fx, fy, cx, cy }) => vec![*fx, *fy, *cx, *cy].into(),
        });
        Self {
            unit: options.unit.map(|unit| unit.symbol()),
            poses: options.poses.as_deref().map(readable),
            camera,
            depth_scale: options.depth_scale,
            pixels_hold: options.pixels_hold,
            max_time_difference: options.max_time_difference,
            grid: options.grid.map(|size| [size.rows, size.cols]),
            rings: options.rings,
        }
    }

    fn is_nothing(&self) -> bool {
        *self == Self::default()
    }
}

#[derive(Debug, Serialize)]
struct Settings {
    normal: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    guide: Option<Arc<CurvedGuide>>,
    offset: f64,
    interval: f64,
    /// Tolerance and smallest interval, where planes were inserted.
    #[serde(skip_serializing_if = "Option::is_none")]
    refine: Option<[f64; 2]>,
    /// How each view's curves were found, and with what.
    partial: Value,
    /// How the views' curves were fused, and with what.
    fusion: Value,
    /// Whether curves that more views looked through than measured are left out.
    free_space: bool,
}

/// A method as one object: its name, then its options.
fn with_options(method: &impl Serialize) -> Value {
    let named = serde_json::to_value(method).unwrap_or_default();
    let named = named.as_object().and_then(|named| named.iter().next());
    let Some((name, options)) = named else { return Value::Null };
    let mut all = Map::from_iter([("method".to_owned(), name.as_str().into())]);
    all.extend(options.as_object().cloned().unwrap_or_default());
    all.into()
}

/// A file that was read.
#[derive(Debug, Serialize)]
struct Input {
    path: String,
    #[serde(flatten)]
    content: Content,
}

/// What is known of a file's bytes when the report is written.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Content {
    Read {
        bytes: u64,
        sha256: String,
    },
    /// The file vanished after the run read it, or the system refuses to read it again.
    Unreadable {
        unreadable: String,
    },
}

impl<'a> ReportFile<'a> {
    /// The report of a run.
    ///
    /// `accepted` are the checks of plausibility that were turned off, `inputs` the files that the
    /// model was made of, and the truth that it is scored against.
    pub fn new(
        opened: &'a OpenScan,
        setup: &Setup,
        report: &'a Report,
        accepted: &[Check],
        inputs: &[PathBuf],
    ) -> Self {
        let (scan, path) = (opened.scan(), opened.path());
        Self {
            tool: "transect",
            version: env!("CARGO_PKG_VERSION"),
            scan: readable(&std::path::absolute(path).unwrap_or_else(|_| path.to_owned())),
            unit: scan.unit.symbol(),
            selection: &opened.selection,
            pose_convention: opened.reading,
            image_order: opened.options.image_order,
            skip_missing: opened.options.skip_missing,
            stated: Stated::new(&opened.options),
            accepted: accepted.iter().map(|check| check.name()).collect(),
            settings: Settings {
                normal: setup.planes.guide().direction(0.0).into(),
                guide: setup.planes.guide().curved().cloned(),
                offset: setup.planes.offset(),
                interval: setup.planes.interval(),
                refine: report.refinement.as_ref().map(|r| [r.tolerance, r.least_interval]),
                partial: with_options(&setup.partial),
                fusion: with_options(&setup.fusion),
                free_space: setup.free_space,
            },
            inputs: inputs.par_iter().map(|p| Input::of(p)).collect(),
            warnings: report.warnings(),
            reader_notes: &scan.notes,
            report,
        }
    }
}

/// A path as text. JSON holds no bytes that are not Unicode; they become replacement characters.
pub(crate) fn readable(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// Bytes of a file that are in memory at once while it is hashed: files of scanners have gigabytes.
const PART: usize = 1 << 18;

impl Input {
    fn of(path: &Path) -> Self {
        let unreadable = |error: Error| Content::Unreadable { unreadable: error.to_string() };
        let content = Content::of(path).unwrap_or_else(unreadable);
        Self { path: readable(path), content }
    }
}

/// The SHA-256 of a file as hexadecimal digits; `None` if the file cannot be read.
pub(crate) fn sha256(path: &Path) -> Option<String> {
    match Content::of(path) {
        Ok(Content::Read { sha256, .. }) => Some(sha256),
        _ => None,
    }
}

impl Content {
    fn of(path: &Path) -> Result<Self, Error> {
        let mut file = open_regular(path)?;
        let (mut hash, mut bytes, mut part) = (Sha256::new(), 0, vec![0; PART]);
        loop {
            let read = file.read(&mut part)?;
            if read == 0 {
                break;
            }
            hash.update(&part[..read]);
            bytes += read as u64;
        }
        let sha256 = hash.finalize().iter().map(|b| format!("{b:02x}")).collect();
        Ok(Self::Read { bytes, sha256 })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests may fail loudly")]
mod tests {
    use super::*;

    #[test]
    fn what_was_stated_is_reported_and_nothing_else() {
        let mut options = OpenOptions::default();
        assert!(Stated::new(&options).is_nothing());
        options.camera = Some("500,501,320,240".parse().unwrap());
        options.depth_scale = Some(0.001);
        options.grid = Some(transect_device::ImageSize { rows: 2, cols: 3 });
        let stated = serde_json::to_value(Stated::new(&options)).unwrap();
        let expected = serde_json::json!({
            "camera": [500.0, 501.0, 320.0, 240.0], "depth_scale": 0.001, "grid": [2, 3]
        });
        assert_eq!(stated, expected);
    }

    #[test]
    fn an_input_that_cannot_be_read_again_stays_in_the_list() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        std::fs::write(&path, "abc").unwrap();
        let entry = || serde_json::to_value(Input::of(&path)).unwrap();
        assert_eq!((&entry()["bytes"], entry().get("unreadable")), (&3.into(), None));
        std::fs::remove_file(&path).unwrap();
        let gone = entry();
        assert!(gone["path"].as_str().unwrap().ends_with("a.npy") && gone.get("sha256").is_none());
        assert!(!gone["unreadable"].as_str().unwrap().is_empty(), "{gone}");
    }
}
