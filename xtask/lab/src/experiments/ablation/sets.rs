//! The sets that steps are measured on: partial models made once, and what their curves are held
//! against.

use super::super::trial::{self, Public};
use super::crossings;
use super::worth::Figures;
use crate::bench::timing::once;
use crate::failure::Failure;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;
use transect::evaluate::{Accuracy, EvaluateOptions, evaluate, evaluate_seen};
use transect_device::View;
use transect_exchange::{Scan, TriangleMesh, read_truth};
use transect_fusion::{ConsensusOptions, FusionMethod, fuse_plane};
use transect_geometry::{Curve, PlaneFamily, PlaneIndex, Point2};
use transect_partial::{Method, partial_model};
use transect_scene::{BUNDLED_SCENES, Mesh, Visibility, merge_overlaps, sections};
use transect_workflow::simulation::SensorPlan;

/// Distance within which a curve counts as right, as a share of the plane interval, where no size
/// is known.
const TOLERANCE_SHARE: f64 = 0.2;

/// The same as a share of a peers' set's size.
const SIZE_SHARE: f64 = 0.002;

/// Where sets come from.
pub struct Sources<'a> {
    /// Folder of the public scans.
    pub data: &'a Path,
    pub peers: Option<&'a Path>,
}

/// Loads a set with the curves that a method finds.
type Load<'a> = dyn Fn(&Method) -> Result<Set, Failure> + 'a;

/// A set that is not loaded yet.
pub struct Source<'a> {
    pub name: String,
    /// Reads or simulates the views and finds their curves.
    pub load: Box<Load<'a>>,
}

impl<'a> Source<'a> {
    fn new(name: &str, load: impl Fn(&Method) -> Result<Set, Failure> + 'a) -> Self {
        Self { name: name.to_owned(), load: Box::new(load) }
    }
}

impl Sources<'_> {
    /// All sets that are there.
    pub fn list(&self) -> Result<Vec<Source<'_>>, Failure> {
        let bundled = |(name, _): (&'static str, _)| Source::new(name, move |m| bundled(name, m));
        // The mask and the jug of the true-size scanners repeat what the other scenes hold.
        let other = |(name, _): &(&str, _)| !["hyscan_mask", "smart_eye_jug"].contains(name);
        let mut list: Vec<_> = BUNDLED_SCENES.into_iter().filter(other).map(bundled).collect();
        if self.data.is_dir() {
            list.push(Source::new("bunny", |m| bunny(self.data, m)));
            list.push(Source::new("kitchen halves", |m| halves(self.data, m)));
        }
        if let Some(peers_folder) = self.peers {
            let entries = std::fs::read_dir(peers_folder);
            let entries = entries.map_err(|e| Failure::with_file(peers_folder, e))?;
            let mut folders: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
            folders.retain(|f| f.join("truth.npz").is_file());
            folders.sort();
            list.extend(folders.into_iter().map(|folder| {
                let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
                Source::new(&name, move |m| peers(&folder, m))
            }));
        }
        Ok(list)
    }
}

type Sections = BTreeMap<PlaneIndex, Vec<Curve>>;

/// The curves of some views on a plane, view by view.
type Observed = BTreeMap<PlaneIndex, Vec<Vec<Curve>>>;

/// A set, ready to be fused.
pub struct Set {
    planes: PlaneFamily,
    /// One part, or two halves that are held against each other.
    parts: Vec<Observed>,
    /// Time of finding the views' curves.
    pub finding_seconds: f64,
    reference: Option<Reference>,
    options: EvaluateOptions,
}

/// What is known of the real thing.
struct Reference {
    truth: Sections,
    /// What the views could see of it; `None` if all of it counts.
    visible: Option<Visibility>,
}

/// Fused curves and the time it took.
pub struct Fused {
    parts: Vec<Sections>,
    pub seconds: f64,
}

impl Set {
    /// Fuses all planes of all parts.
    pub fn fuse(&self, options: &ConsensusOptions) -> Fused {
        let method = FusionMethod::Consensus(*options);
        let plane = |(k, views): (&PlaneIndex, &Vec<Vec<Curve>>)| {
            let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
            let mut curves = Vec::new();
            let seconds = once(|| curves = fuse_plane(&slices, &method).curves);
            (*k, curves, seconds)
        };
        let mut seconds = 0.0;
        let part = |observed: &Observed| -> Sections {
            let fused: Vec<_> = observed.par_iter().map(plane).collect();
            seconds += fused.iter().map(|f| f.2).sum::<f64>();
            fused.into_iter().map(|(k, curves, _)| (k, curves)).collect()
        };
        let parts = self.parts.iter().map(part).collect();
        Fused { parts, seconds }
    }

    /// Holds fused curves against the truth, or two halves against each other.
    pub fn score(&self, fused: &Fused) -> Result<Figures, Failure> {
        let accuracies = match (&self.reference, fused.parts.as_slice()) {
            (Some(reference), [curves]) => vec![self.accuracy(curves, reference)?],
            (_, [even, odd]) => vec![
                evaluate(&self.planes, even, odd, &self.options)?,
                evaluate(&self.planes, odd, even, &self.options)?,
            ],
            _ => return Err(Failure::because("a set has neither a truth nor two halves")),
        };
        let crossings =
            fused.parts.iter().flat_map(|p| p.values()).map(|curves| crossings::count(curves));
        Ok(Figures::new(&accuracies, crossings.sum(), fused.seconds))
    }

    fn accuracy(&self, curves: &Sections, reference: &Reference) -> Result<Accuracy, Failure> {
        let Reference { truth, visible } = reference;
        let Some(visible) = visible else {
            return Ok(evaluate(&self.planes, curves, truth, &self.options)?);
        };
        let seen = |k: PlaneIndex, points: &[Point2]| {
            let frame = self.planes.frame(k);
            let in_world: Vec<_> = points.iter().map(|p| frame.world_from_plane(p)).collect();
            visible.sees(&in_world)
        };
        Ok(evaluate_seen(&self.planes, curves, truth, &seen, &self.options)?)
    }
}

fn bundled(scene: &str, method: &Method) -> Result<Set, Failure> {
    let stage = trial::bundled(scene)?;
    let views = stage.simulate(&SensorPlan::OWN)?.views;
    let planes = stage.description.planes.clone();
    let tolerance = TOLERANCE_SHARE * planes.interval();
    simulated(planes, (views, &stage.truth), tolerance, method)
}

fn peers(folder: &Path, method: &Method) -> Result<Set, Failure> {
    let scan = Scan::open(folder)?;
    let Some(entry) = &scan.planes else {
        return Err(Failure::with_file(folder, "the scan states no planes"));
    };
    let planes = entry.family().map_err(|e| Failure::because(e.to_string()))?;
    let text = std::fs::read_to_string(folder.join("scan.json"))
        .map_err(|e| Failure::with_file(folder, e))?;
    let manifest: serde_json::Value =
        serde_json::from_str(&text).map_err(|e| Failure::with_file(folder, e))?;
    let size = manifest.get("size").and_then(serde_json::Value::as_f64);
    let tolerance = size.map_or(TOLERANCE_SHARE * planes.interval(), |s| SIZE_SHARE * s);
    let mesh = solid(read_truth(&folder.join("truth.npz"))?);
    simulated(planes, (trial::load(&scan)?, &mesh), tolerance, method)
}

fn simulated(
    planes: PlaneFamily,
    (views, mesh): (Vec<View>, &Mesh),
    tolerance: f64,
    method: &Method,
) -> Result<Set, Failure> {
    let cut = sections(mesh, &planes)?;
    let truth: Sections = cut.into_iter().map(|(k, c)| (k, merge_overlaps(c))).collect();
    let (found, finding_seconds) = observed(&views, &planes, method)?;
    let visible = Some(Visibility::new(mesh, views)?);
    let options = EvaluateOptions::new(tolerance);
    let (parts, reference) = (vec![found], Some(Reference { truth, visible }));
    Ok(Set { planes, parts, finding_seconds, reference, options })
}

fn bunny(data: &Path, method: &Method) -> Result<Set, Failure> {
    let (Public { views, planes }, mesh) = trial::bunny(data)?;
    let truth = sections(&solid(mesh), &planes)?;
    let (found, finding_seconds) = observed(&views, &planes, method)?;
    let options = trial::bunny_options();
    let (parts, reference) = (vec![found], Some(Reference { truth, visible: None }));
    Ok(Set { planes, parts, finding_seconds, reference, options })
}

/// The even frames and the odd ones.
fn halves(data: &Path, method: &Method) -> Result<Set, Failure> {
    let Public { views, planes } = trial::red_kitchen(data)?;
    let half = |first: usize| {
        let views: Vec<View> = views.iter().skip(first).step_by(2).cloned().collect();
        observed(&views, &planes, method)
    };
    let ((even, even_seconds), (odd, odd_seconds)) = (half(0)?, half(1)?);
    let (parts, finding_seconds) = (vec![even, odd], even_seconds + odd_seconds);
    let options = EvaluateOptions::new(0.02);
    Ok(Set { planes, parts, finding_seconds, reference: None, options })
}

fn solid(mesh: TriangleMesh) -> Mesh {
    Mesh { vertices: mesh.vertices, faces: mesh.faces }
}

/// The curves of all views, by plane and view, and the seconds that finding them took.
fn observed(
    views: &[View],
    planes: &PlaneFamily,
    method: &Method,
) -> Result<(Observed, f64), Failure> {
    let began = Instant::now();
    let partial = |view: &View| partial_model(view, planes, method);
    let models: Result<Vec<_>, _> = views.par_iter().map(partial).collect();
    let models = models.map_err(|e| Failure::because(e.to_string()))?;
    let seconds = began.elapsed().as_secs_f64();
    let mut observed = Observed::new();
    for (k, model) in models.into_iter().enumerate() {
        for found in model.planes {
            let of_plane = observed.entry(found.plane).or_default();
            of_plane.resize(views.len(), Vec::new());
            of_plane[k].extend(found.curves.into_iter().map(|c| c.curve));
        }
    }
    Ok((observed, seconds))
}
