//! `cargo xtask evaluate`: how accurate a model is.

use super::planes::parse_length;
use super::report_file::Written;
use crate::failure::Failure;
use crate::table::{Row, print};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use transect::evaluate::{EvaluateOptions, duplication, evaluate, evaluate_seen};
use transect_device::View;
use transect_exchange::{Scan, TriangleMesh, read_mesh, read_truth};
use transect_geometry::{Curve, PlaneIndex, Point2};
use transect_model::Model;
use transect_scene::{Mesh, Visibility, merge_overlaps, sections};

/// Tolerance where none is given, as a share of the plane interval.
const TOLERANCE_SHARE: f64 = 0.2;

/// Options of `evaluate`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder that `reconstruct` wrote.
    model: PathBuf,
    /// Mesh to compare with (.ply, .stl or .obj) [default: the truth of a simulated scan; without one, only
    /// duplication is measured].
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
    /// Distance within which a curve counts as right [default: a fifth of the plane interval; where planes were
    /// inserted, of the widest that is left].
    #[arg(long, value_name = "LENGTH")]
    tolerance: Option<String>,
}

/// What a model is compared with.
#[derive(Debug)]
pub enum Reference {
    /// A mesh of the real thing.
    Mesh(PathBuf),
    /// The truth of a simulated scan, and the scan itself, which tells what could be seen.
    Simulated { truth: PathBuf, scan: PathBuf },
    /// Nothing: only what the curves tell about themselves.
    Nothing,
}

impl Reference {
    /// The truth that lies beside a scan, if any.
    pub fn beside(scan: &Path) -> Self {
        let folder = if scan.is_dir() { Some(scan) } else { scan.parent() };
        let truth = folder.map(|f| f.join("truth.npz")).filter(|t| t.is_file());
        truth.map_or(Self::Nothing, |truth| Self::Simulated { truth, scan: scan.to_owned() })
    }

    /// The truth beside the scan that a model was made of, if any.
    fn of_model(folder: &Path) -> Self {
        let text = std::fs::read_to_string(folder.join("report.json")).ok();
        let written: Option<Written> = text.and_then(|t| serde_json::from_str(&t).ok());
        written.map_or(Self::Nothing, |w| Self::beside(&w.scan))
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let reference = match &arguments.reference {
        Some(mesh) => Reference::Mesh(mesh.clone()),
        None => Reference::of_model(&arguments.model),
    };
    if matches!(reference, Reference::Nothing) {
        eprintln!("note: no reference mesh and no truth beside the scan: duplication only");
    }
    let scored = score(&arguments.model, &reference, &arguments.limits)?;
    print(&scored.agreement.into_iter().chain(scored.counts).collect::<Vec<_>>());
    Ok(())
}

/// The rows of an evaluation.
#[derive(Debug, Default)]
pub struct Scored {
    /// How well curves and truth agree.
    pub agreement: Vec<Row>,
    /// How much there is of both.
    pub counts: Vec<Row>,
}

/// Scores the model in a folder.
pub fn score(folder: &Path, reference: &Reference, limits: &Limits) -> Result<Scored, Failure> {
    let model = Model::load(folder.join("model.transect"))?;
    let (planes, unit) = (model.planes().clone(), model.unit());
    let options = limits.options(&model)?;
    let curves: BTreeMap<PlaneIndex, Vec<Curve>> =
        model.sections().map(|(k, s)| (k, s.curves().cloned().collect())).collect();
    let accuracy = match reference {
        Reference::Nothing => {
            let counts = duplication(&curves, options.tolerance)?.rows(unit);
            return Ok(Scored { counts: rows(counts), ..Scored::default() });
        }
        Reference::Mesh(path) => {
            let mesh = read_mesh(path)?.mesh;
            let truth = cut(path, &solid(mesh), &model)?;
            evaluate(&planes, &curves, &truth, &options)?
        }
        Reference::Simulated { truth, scan } => {
            let surface = solid(read_truth(truth)?);
            let sections = cut(truth, &surface, &model)?;
            // Solids of a scene may overlap: what lies inside another is no surface.
            let united = sections.into_iter().map(|(k, c)| (k, merge_overlaps(c))).collect();
            let visible = Visibility::new(&surface, views(scan)?)?;
            let seen =
                |k: PlaneIndex, p: &Point2| visible.sees(&planes.frame(k).world_from_plane(p));
            evaluate_seen(&planes, &curves, &united, &seen, &options)?
        }
    };
    let agreement = rows(accuracy.agreement_rows(unit));
    let counts = rows(accuracy.rows(unit)).split_off(agreement.len());
    Ok(Scored { agreement, counts })
}

impl Limits {
    fn options(&self, model: &Model) -> Result<EvaluateOptions, Failure> {
        let unit = model.unit();
        let tolerance = match &self.tolerance {
            Some(text) => parse_length(unit, "--tolerance", text)?,
            None => TOLERANCE_SHARE * widest_interval(model),
        };
        if tolerance <= 0.0 {
            return Err(Failure::Usage(format!("--tolerance must be positive, got {tolerance}")));
        }
        let from = self.from.as_ref().map(|t| parse_length(unit, "--from", t)).transpose()?;
        Ok(EvaluateOptions { tolerance, from })
    }
}

fn rows(rows: Vec<transect::evaluate::Row>) -> Vec<Row> {
    rows.into_iter().map(|r| Row::new(r.metric, r.value, r.unit)).collect()
}

fn solid(mesh: TriangleMesh) -> Mesh {
    Mesh { vertices: mesh.vertices, faces: mesh.faces }
}

/// The widest interval between neighbouring planes that both have curves.
fn widest_interval(model: &Model) -> f64 {
    let pairs = model.sections().zip(model.sections().skip(1));
    let neighbours = pairs
        .map(|((a, _), (b, _))| (a, b))
        .filter(|(a, b)| model.selection().next_after(*a) == Some(*b));
    let steps = neighbours.map(|(a, b)| b.0.abs_diff(a.0)).max().unwrap_or(1);
    model.planes().interval() * steps as f64
}

/// The truth on the planes that the model was asked for.
fn cut(
    path: &Path,
    mesh: &Mesh,
    model: &Model,
) -> Result<BTreeMap<PlaneIndex, Vec<Curve>>, Failure> {
    let mut cut = sections(mesh, model.planes()).map_err(|e| Failure::with_file(path, e))?;
    cut.retain(|k, _| model.selection().contains(*k));
    Ok(cut)
}

fn views(scan: &Path) -> Result<Vec<View>, Failure> {
    let scan = Scan::open(scan)?;
    let views: Result<Vec<View>, _> =
        scan.views.par_iter().map(|v| v.load().map(|(view, _)| view)).collect();
    Ok(views?)
}
