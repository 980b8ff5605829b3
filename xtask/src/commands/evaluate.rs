//! `cargo xtask evaluate`: how accurate a model is.

use super::planes::parse_length;
use super::report_file::Written;
use crate::failure::Failure;
use crate::table::{Row, print};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use transect::evaluate::{EvaluateOptions, duplication, evaluate};
use transect_exchange::{TriangleMesh, read_mesh, read_truth};
use transect_geometry::{Curve, PlaneFamily, PlaneIndex};
use transect_model::Model;
use transect_scene::{Mesh, merge_overlaps, sections};

/// Tolerance where none is given, as a share of the plane interval.
const TOLERANCE_SHARE: f64 = 0.2;

/// Options of `evaluate`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder that `reconstruct` wrote.
    model: PathBuf,
    /// Mesh to compare with: .ply, or .npz with vertices and faces [default: the truth of a
    /// simulated scan; without one, only duplication is measured].
    #[arg(long, value_name = "MESH")]
    reference: Option<PathBuf>,
    #[command(flatten)]
    limits: Limits,
}

/// What is compared.
#[derive(Debug, Default, clap::Args)]
pub struct Limits {
    /// Only planes from this station on; a bare number is in the model's unit.
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    from: Option<String>,
    /// Distance within which a curve counts as right [default: a fifth of the plane interval].
    #[arg(long, value_name = "LENGTH")]
    tolerance: Option<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let reference = arguments.reference.clone().or_else(|| truth_of(&arguments.model));
    if reference.is_none() {
        eprintln!("note: no reference mesh and no truth beside the scan: duplication only");
    }
    print(&score(&arguments.model, reference.as_deref(), &arguments.limits)?);
    Ok(())
}

/// The truth that lies beside a scan.
pub fn truth_beside(scan: &Path) -> Option<PathBuf> {
    let folder = if scan.is_dir() { scan } else { scan.parent()? };
    Some(folder.join("truth.npz")).filter(|t| t.is_file())
}

/// The truth beside the scan that a model was made of.
fn truth_of(model: &Path) -> Option<PathBuf> {
    let text = std::fs::read_to_string(model.join("report.json")).ok()?;
    let written: Written = serde_json::from_str(&text).ok()?;
    truth_beside(&written.scan)
}

/// Scores the model in a folder.
pub fn score(
    folder: &Path,
    reference: Option<&Path>,
    limits: &Limits,
) -> Result<Vec<Row>, Failure> {
    let model = Model::load(&folder.join("model.transect"))?;
    let (planes, unit) = (*model.planes(), model.unit());
    let tolerance = match &limits.tolerance {
        Some(text) => parse_length(unit, "--tolerance", text)?,
        None => TOLERANCE_SHARE * planes.interval(),
    };
    if tolerance <= 0.0 {
        return Err(Failure::Usage(format!("--tolerance must be positive, got {tolerance}")));
    }
    let from = limits.from.as_ref().map(|t| parse_length(unit, "--from", t)).transpose()?;
    let options = EvaluateOptions { tolerance, from };
    let curves: BTreeMap<PlaneIndex, Vec<Curve>> =
        model.sections().map(|(k, s)| (k, s.curves().cloned().collect())).collect();
    let rows = match reference {
        Some(mesh) => evaluate(&planes, &curves, &truth(mesh, &planes)?, &options)?.rows(unit),
        None => duplication(&curves, tolerance)?.rows(unit),
    };
    Ok(rows.into_iter().map(|r| Row::new(r.metric, r.value, r.unit)).collect())
}

/// The exact sections of a mesh; solids of a simulated scene that overlap are united.
fn truth(path: &Path, planes: &PlaneFamily) -> Result<BTreeMap<PlaneIndex, Vec<Curve>>, Failure> {
    let simulated = path.extension().is_some_and(|e| e == "npz");
    let TriangleMesh { vertices, faces } =
        if simulated { read_truth(path)? } else { read_mesh(path)?.mesh };
    let cut =
        sections(&Mesh { vertices, faces }, planes).map_err(|e| Failure::with_file(path, e))?;
    let unite = |curves| if simulated { merge_overlaps(curves) } else { curves };
    Ok(cut.into_iter().map(|(plane, curves)| (plane, unite(curves))).collect())
}
