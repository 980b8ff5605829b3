//! `report.json`: the table of a run, with its settings and the hashes of its inputs.

use crate::Selection;
use crate::views::OpenScan;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::{Map, Value};
use sha2::{Digest, Sha256};
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use transect::register::PoseReading;
use transect::{Report, Setup};
use transect_device::ImageOrder;
use transect_geometry::CurvedGuide;
use transect_model::open_regular;

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
    settings: Settings,
    inputs: Vec<Input>,
    warnings: Vec<String>,
    reader_notes: &'a [String],
    #[serde(flatten)]
    report: &'a Report,
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

#[derive(Debug, Serialize)]
struct Input {
    path: String,
    bytes: u64,
    sha256: String,
}

impl<'a> ReportFile<'a> {
    /// The report of a run.
    pub fn new(opened: &'a OpenScan, setup: &Setup, report: &'a Report) -> Self {
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
            settings: Settings {
                normal: setup.planes.guide().direction(0.0).into(),
                guide: setup.planes.guide().curved().cloned(),
                offset: setup.planes.offset(),
                interval: setup.planes.interval(),
                refine: report.refinement.as_ref().map(|r| [r.tolerance, r.least_interval]),
                partial: with_options(&setup.partial),
                fusion: with_options(&setup.fusion),
            },
            inputs: scan.inputs.par_iter().filter_map(|p| input(p)).collect(),
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

/// Size and hash of an input; an input that has vanished meanwhile is left out.
fn input(path: &Path) -> Option<Input> {
    let mut file = open_regular(path).ok()?;
    let (mut hash, mut bytes, mut part) = (Sha256::new(), 0, vec![0; PART]);
    loop {
        let read = file.read(&mut part).ok()?;
        if read == 0 {
            break;
        }
        hash.update(&part[..read]);
        bytes += read as u64;
    }
    let sha256 = hash.finalize().iter().map(|b| format!("{b:02x}")).collect();
    Some(Input { path: readable(path), bytes, sha256 })
}
