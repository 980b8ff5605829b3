//! Scoring a model against a mesh, or against the truth that a simulation left.

use crate::WorkflowError;
use crate::table::Row;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use transect::evaluate::{
    Accuracy, EvaluateOptions, Extent, ExtentError, duplication, evaluate, evaluate_seen,
};
use transect_device::View;
use transect_exchange::{Scan, TRUTH_FILE, TriangleMesh, read_mesh, read_truth};
use transect_geometry::{Curve, Length, LengthUnit, PlaneIndex, Point2};
use transect_model::Model;
use transect_scene::{
    MergeError, Mesh, MeshError, SceneError, Visibility, merge_overlaps, sections,
};

/// Tolerance where none is given, as a share of the plane interval. Chosen by hand.
/// Doubled, curves twice as far off count as right.
const TOLERANCE_SHARE: f64 = 0.2;

/// Share of a model's length that is right by the mesh of its object, at least. Chosen by hand:
/// models of depth cameras reach 0.8 within the usual tolerance. Doubled, no mesh in another unit
/// is found.
const GOOD: f64 = 0.5;

/// How many times more of a model is right in the mesh's true unit, at least. Chosen by hand: a
/// wrong unit leaves the few places where both surfaces cross. Doubled, noisy models with half
/// of their length right must have less than a twelfth right in the wrong unit.
const FAR_BETTER: f64 = 3.0;

/// The part of a model that is scored, and the distance that counts as right.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ScoreLimits {
    /// Only planes from this station on.
    pub from: Option<Length>,
    /// Distance within which a curve counts as right. Without it, a fifth of the plane interval;
    /// where planes were inserted, of the widest interval that is left.
    pub tolerance: Option<Length>,
}

/// The shape that a model is compared with.
#[derive(Debug, Clone, PartialEq)]
pub enum Reference {
    /// A mesh of the real object.
    Mesh(PathBuf),
    /// The truth of a simulated scan.
    Simulated {
        /// The file of the truth.
        truth: PathBuf,
        /// The scan, from which follows the part of the truth that the views could see.
        scan: PathBuf,
    },
    /// None: the score only counts curves and duplicates.
    Nothing,
}

impl Reference {
    /// The truth that lies beside a scan, if any.
    pub fn beside(scan: &Path) -> Self {
        let folder = if scan.is_dir() { Some(scan) } else { scan.parent() };
        let truth = folder.map(|f| f.join(TRUTH_FILE)).filter(|t| t.is_file());
        truth.map_or(Self::Nothing, |truth| Self::Simulated { truth, scan: scan.to_owned() })
    }
}

/// The rows of a score.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Score {
    /// How well curves and truth agree.
    pub agreement: Vec<Row>,
    /// The numbers and lengths of both.
    pub counts: Vec<Row>,
}

/// Scores a model.
///
/// # Errors
/// [`WorkflowError`] if a limit is no usable length, or the reference cannot be read.
pub fn score(
    model: &Model,
    reference: &Reference,
    limits: &ScoreLimits,
) -> Result<Score, WorkflowError> {
    let unit = model.unit();
    let accuracy = match reference {
        Reference::Nothing => {
            let options = limits.options(model)?;
            let counts = duplication(&curves(model), options.tolerance)?.rows(unit);
            return Ok(Score { counts, ..Score::default() });
        }
        Reference::Mesh(path) => {
            let mesh = solid(read_mesh(path)?.mesh);
            let extents = extent(model).zip(Extent::of(mesh.vertices.iter().copied()));
            let margin = limits.options(model)?.tolerance;
            let checked = extents.map_or(Ok(()), |(ours, theirs)| ours.check(&theirs, margin));
            let unfit = WorkflowError::unusable(path, "the mesh does not fit the model");
            checked.map_err(&unfit)?;
            if let Some(problem) = coarse_coordinates(&mesh, margin, unit) {
                return Err(WorkflowError::file(path, problem));
            }
            let uncut = WorkflowError::unusable(path, "the mesh cannot be cut");
            let truth = cut(&mesh, model).map_err(uncut)?;
            if let (true, Some((ours, theirs))) = (truth.is_empty(), extents) {
                return Err(unfit(ours.uncut(&theirs)));
            }
            let options = limits.options(model)?;
            let accuracy = evaluate(model.planes(), &curves(model), &truth, &options)?;
            if let (true, Some(extents)) = (right(&accuracy) < GOOD, extents) {
                let found = other_unit(&mesh, model, extents, (right(&accuracy), &options))?;
                found.map_or(Ok(()), |e| Err(WorkflowError::file(path, e)))?;
            }
            accuracy
        }
        Reference::Simulated { truth, scan } => {
            simulated_accuracy(model, &solid(read_truth(truth)?), views(scan)?, limits)?
        }
    };
    let agreement = accuracy.agreement_rows(unit);
    let counts = accuracy.rows(unit).split_off(agreement.len());
    Ok(Score { agreement, counts })
}

/// The share of a model's length that is right.
fn right(accuracy: &Accuracy) -> f64 {
    1.0 - accuracy.off.unwrap_or(1.0)
}

/// Why the coordinates of a mesh are too coarse for a tolerance; `None` if they are not.
fn coarse_coordinates(mesh: &Mesh, tolerance: f64, unit: LengthUnit) -> Option<String> {
    let coordinates = || mesh.vertices.iter().flat_map(|p| <[f64; 3]>::from(p.coords));
    let is_single = coordinates().all(|c| f64::from(c as f32) == c);
    let largest = coordinates().map(f64::abs).fold(0.0, f64::max);
    let step = largest * f64::from(f32::EPSILON);
    (is_single && step > tolerance).then(|| {
        format!(
            "coordinates up to {largest:.0} {unit} are stored as 32-bit numbers, whose steps are \
             {step:.4} {unit} there, more than the tolerance of {tolerance:.4} {unit}; store the \
             mesh as OBJ or as PLY of 64-bit numbers, or subtract one offset from scan and mesh"
        )
    })
}

/// Why a mesh is the reference of a model in another unit; `None` if it is not. `right_now` is the
/// share of the model that is right by the mesh as it is.
fn other_unit(
    mesh: &Mesh,
    model: &Model,
    (ours, theirs): (Extent, Extent),
    (right_now, options): (f64, &EvaluateOptions),
) -> Result<Option<ExtentError>, WorkflowError> {
    let of_model = curves(model);
    let (mut best, mut found) = (f64::max(GOOD, FAR_BETTER * right_now), None);
    for factor in ours.unit_factors(&theirs) {
        let vertices = mesh.vertices.iter().map(|p| (p.coords * factor).into()).collect();
        let scaled = Mesh { vertices, faces: mesh.faces.clone() };
        let truth = cut(&scaled, model)?;
        let share = right(&evaluate(model.planes(), &of_model, &truth, options)?);
        if share >= best {
            (best, found) = (share, Some(ours.in_other_unit(&theirs, factor)));
        }
    }
    Ok(found)
}

/// Scores a model against the part of a simulated scene's surface that the views could see.
///
/// # Errors
/// [`WorkflowError`] if a limit is no usable length, or the surface cannot be cut.
pub fn simulated_accuracy(
    model: &Model,
    surface: &Mesh,
    views: Vec<View>,
    limits: &ScoreLimits,
) -> Result<Accuracy, WorkflowError> {
    let (planes, options) = (model.planes(), limits.options(model)?);
    // Solids of a scene may overlap: the part of one inside another is no surface.
    let cut = cut(surface, model)?.into_par_iter();
    let truth: Result<_, MergeError> = cut.map(|(k, c)| Ok((k, merge_overlaps(c)?))).collect();
    let truth = truth.map_err(SceneError::from)?;
    let visible = Visibility::new(surface, views)?;
    let seen = |k: PlaneIndex, points: &[Point2]| {
        let frame = planes.frame(k);
        let in_world: Vec<_> = points.iter().map(|p| frame.world_from_plane(p)).collect();
        visible.sees(&in_world)
    };
    Ok(evaluate_seen(planes, &curves(model), &truth, &seen, &options)?)
}

impl ScoreLimits {
    fn options(&self, model: &Model) -> Result<EvaluateOptions, WorkflowError> {
        let unit = model.unit();
        let tolerance = match self.tolerance {
            Some(tolerance) => tolerance.in_unit(unit),
            None => TOLERANCE_SHARE * widest_interval(model),
        };
        if tolerance <= 0.0 {
            let problem = format!("the tolerance must be a positive length, got {tolerance}");
            return Err(WorkflowError::setting("tolerance", problem));
        }
        let from = self.from.map(|from| from.in_unit(unit));
        let last =
            model.sections().map(|(k, _)| model.planes().station(k)).fold(f64::MIN, f64::max);
        if let Some(from) = from.filter(|from| *from > last) {
            let problem =
                format!("no plane is at {from} {unit} or beyond; the last one is at {last}");
            return Err(WorkflowError::setting("from", problem));
        }
        let options = EvaluateOptions::new(tolerance);
        Ok(from.map_or(options, |station| options.from_station(station)))
    }
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

/// A model's curves by plane.
fn curves(model: &Model) -> BTreeMap<PlaneIndex, Vec<Curve>> {
    model.sections().map(|(k, s)| (k, s.curves().cloned().collect())).collect()
}

/// The box around a model's curves.
fn extent(model: &Model) -> Option<Extent> {
    Extent::of(model.sections().flat_map(|(k, section)| {
        let frame = model.planes().frame(k);
        let nodes = section.curves().flat_map(Curve::nodes);
        nodes.map(move |node| frame.world_from_plane(&node.position))
    }))
}

/// The sections of a surface on the planes that the model was asked for.
fn cut(surface: &Mesh, model: &Model) -> Result<BTreeMap<PlaneIndex, Vec<Curve>>, MeshError> {
    let mut cut = sections(surface, model.planes())?;
    cut.retain(|k, _| model.selection().contains(*k));
    Ok(cut)
}

fn views(scan: &Path) -> Result<Vec<View>, WorkflowError> {
    let scan = Scan::open(scan)?;
    let views: Result<Vec<View>, _> =
        scan.views.par_iter().map(|v| v.load().map(|(view, _)| view)).collect();
    Ok(views?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_in_steps_larger_than_the_tolerance_are_refused() {
        let mesh = |x: f64| Mesh { vertices: vec![[x, 2.5, 0.0].into()], faces: Vec::new() };
        let metre = LengthUnit::Metre;
        let problem = coarse_coordinates(&mesh(5_300_000.5), 0.1, metre).unwrap();
        assert!(problem.contains("whose steps are 0.6318 m there"), "{problem}");
        for (x, tolerance) in [(5_300_000.5, 1.0), (5_300_000.3, 0.1), (300.5, 0.001)] {
            assert_eq!(coarse_coordinates(&mesh(x), tolerance, metre), None, "{x}, {tolerance}");
        }
    }
}
