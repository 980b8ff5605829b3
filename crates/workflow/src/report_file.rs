//! `report.json`: the table of a run with everything needed to repeat it.

use crate::views::OpenScan;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect::{Report, Setup};
use transect_fusion::FusionMethod;
use transect_geometry::CurvedGuide;
use transect_model::open_regular;
use transect_partial::Method;

/// The content of `report.json` without the table and the costs.
#[derive(Debug, Serialize)]
pub struct ReportFile<'a> {
    tool: &'static str,
    version: &'static str,
    /// Absolute path of the scan.
    scan: PathBuf,
    unit: &'static str,
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

/// The options of a partial modeler.
fn partial_settings(method: &Method) -> Value {
    match method {
        Method::OnePass(o) => json!({
            "method": "one_pass",
            "max_incidence_deg": o.max_incidence_rad.to_degrees(),
            "jump_sigmas": o.jump_sigmas,
            "smooth": o.smooth,
        }),
        Method::Dissertation(o) => json!({
            "method": "dissertation",
            "jump_test": format!("{:?}", o.jump),
            "gap": o.gap,
            "thickness": o.thickness,
            "subpixel": o.subpixel.to_string(),
            "direction": format!("{:?}", o.direction),
            "smooth": o.smooth,
        }),
        other => json!({ "method": format!("{other:?}") }),
    }
}

/// The options of a fusion method.
fn fusion_settings(method: &FusionMethod) -> Value {
    match method {
        FusionMethod::Consensus(o) => json!({
            "method": "consensus",
            "threshold_spreads": o.threshold_spreads,
            "direction_limit_deg": o.direction_limit_rad.to_degrees(),
            "shortest_footprints": o.shortest_footprints,
        }),
        FusionMethod::Pairwise(o) => json!({
            "method": "pairwise",
            "tolerance": o.tolerance.map(|t| format!("{t:?}")),
            "threshold_spreads": o.threshold_spreads,
        }),
        other => json!({ "method": format!("{other:?}") }),
    }
}

#[derive(Debug, Serialize)]
struct Input {
    path: PathBuf,
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
            scan: std::path::absolute(path).unwrap_or_else(|_| path.to_owned()),
            unit: scan.unit.symbol(),
            settings: Settings {
                normal: setup.planes.guide().direction(0.0).into(),
                guide: setup.planes.guide().curved().cloned(),
                offset: setup.planes.offset(),
                interval: setup.planes.interval(),
                refine: report.refinement.as_ref().map(|r| [r.tolerance, r.least_interval]),
                partial: partial_settings(&setup.partial),
                fusion: fusion_settings(&setup.fusion),
            },
            inputs: scan.inputs.par_iter().filter_map(|p| input(p)).collect(),
            warnings: report.warnings(),
            reader_notes: &scan.notes,
            report,
        }
    }
}

/// Size and hash of an input; an input that has vanished meanwhile is left out.
fn input(path: &Path) -> Option<Input> {
    let mut bytes = Vec::new();
    open_regular(path).and_then(|mut file| file.read_to_end(&mut bytes)).ok()?;
    let hash = Sha256::digest(&bytes);
    let sha256 = hash.iter().map(|b| format!("{b:02x}")).collect();
    Some(Input { path: path.to_owned(), bytes: bytes.len() as u64, sha256 })
}
