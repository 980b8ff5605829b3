//! The sets that steps are measured on: their views, and what their curves are held against.

use super::super::trial::{self, Public};
use super::worth::Figures;
use crate::failure::Failure;
use crate::timing::once;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;
use transect::evaluate::{Accuracy, EvaluateOptions, evaluate, evaluate_seen};
use transect_device::View;
use transect_exchange::{MANIFEST_FILE, Scan, TRUTH_FILE, read_truth};
use transect_fusion::{ConsensusOptions, FusionMethod, fuse_plane};
use transect_geometry::{Curve, PlaneFamily, PlaneIndex, Point2, crossings};
use transect_partial::{Method, partial_model};
use transect_scene::{BUNDLED_SCENES, MergeError, Mesh, Visibility, merge_overlaps, sections};
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

impl Sources<'_> {
    /// The sets whose name is chosen, read or simulated when it is their turn.
    pub fn each(
        &self,
        chosen: impl Fn(&str) -> bool,
        mut measure: impl FnMut(&str, &Raw) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let mut take = |name: &str, load: &dyn Fn() -> Result<Raw, Failure>| match chosen(name) {
            true => measure(name, &load()?),
            false => Ok(()),
        };
        // The mask and the jug of the true-size scanners repeat what the other scenes hold.
        let repeated = ["hyscan_mask", "smart_eye_jug"];
        for (scene, _) in BUNDLED_SCENES.into_iter().filter(|(name, _)| !repeated.contains(name)) {
            take(scene, &|| bundled(scene))?;
        }
        take("bunny", &|| bunny(self.data))?;
        take("kitchen halves", &|| halves(self.data))?;
        let Some(folder) = self.peers else { return Ok(()) };
        let entries = std::fs::read_dir(folder).map_err(|e| Failure::with_file(folder, e))?;
        let mut folders: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
        folders.retain(|f| f.join(TRUTH_FILE).is_file());
        folders.sort();
        for folder in folders {
            let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
            take(&name, &|| peers(&folder))?;
        }
        Ok(())
    }
}

type Sections = BTreeMap<PlaneIndex, Vec<Curve>>;

/// The views of a set, and what their curves are held against.
pub struct Raw {
    planes: PlaneFamily,
    /// One part, or two halves that are held against each other.
    parts: Vec<Vec<View>>,
    reference: Option<Reference>,
    options: EvaluateOptions,
}

/// A set with the curves of its views, ready to be fused.
pub struct Set<'a> {
    raw: &'a Raw,
    /// The curves of each part by plane and view.
    parts: Vec<BTreeMap<PlaneIndex, Vec<Vec<Curve>>>>,
    /// Time of finding the views' curves.
    pub finding_seconds: f64,
}

/// The truth of a set.
struct Reference {
    truth: Sections,
    /// The part of it that the views could see; `None` if all of it counts.
    visible: Option<Visibility>,
}

impl Set<'_> {
    /// Fuses all planes of all parts, and scores the curves.
    pub fn figures(&self, options: &ConsensusOptions) -> Result<Figures, Failure> {
        let method = FusionMethod::Consensus(*options);
        let plane = |(k, views): (&PlaneIndex, &Vec<Vec<Curve>>)| {
            let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
            let mut curves = Vec::new();
            let seconds = once(|| curves = fuse_plane(&slices, &method).curves);
            (*k, curves, seconds)
        };
        let (mut seconds, mut crossed, mut parts) = (0.0, 0, Vec::new());
        for part in &self.parts {
            let fused: Vec<_> = part.par_iter().map(plane).collect();
            seconds += fused.iter().map(|f| f.2).sum::<f64>();
            crossed += fused.iter().map(|f| crossings(&f.1).len()).sum::<usize>();
            parts.push(fused.into_iter().map(|(k, curves, _)| (k, curves)).collect());
        }
        Ok(Figures::new(&self.raw.accuracies(&parts)?, crossed, seconds))
    }
}

impl Raw {
    /// Finds the curves of all views by a method.
    pub fn observed(&self, method: &Method) -> Result<Set<'_>, Failure> {
        let began = Instant::now();
        let mut parts = Vec::new();
        for views in &self.parts {
            let partial = |view: &View| partial_model(view, &self.planes, method);
            let models: Vec<_> = views.par_iter().map(partial).collect::<Result<_, _>>()?;
            let mut observed = BTreeMap::<PlaneIndex, Vec<Vec<Curve>>>::new();
            for (k, model) in models.into_iter().enumerate() {
                for found in model.planes {
                    let of_plane = observed.entry(found.plane).or_default();
                    of_plane.resize(views.len(), Vec::new());
                    of_plane[k].extend(found.curves.into_iter().map(|c| c.curve));
                }
            }
            parts.push(observed);
        }
        Ok(Set { raw: self, parts, finding_seconds: began.elapsed().as_secs_f64() })
    }

    /// Holds fused curves against the truth, or two halves against each other.
    fn accuracies(&self, parts: &[Sections]) -> Result<Vec<Accuracy>, Failure> {
        let halves = |a, b| evaluate(&self.planes, a, b, &self.options);
        match (&self.reference, parts) {
            (Some(reference), [curves]) => Ok(vec![self.accuracy(curves, reference)?]),
            (_, [even, odd]) => Ok(vec![halves(even, odd)?, halves(odd, even)?]),
            _ => Err(Failure::because("a set has neither a truth nor two halves")),
        }
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

fn bundled(scene: &str) -> Result<Raw, Failure> {
    let stage = trial::bundled(scene)?;
    let views = stage.simulate(&SensorPlan::OWN)?.views;
    let planes = stage.description.planes.clone();
    let tolerance = TOLERANCE_SHARE * planes.interval();
    simulated(planes, views, &stage.truth, tolerance)
}

fn peers(folder: &Path) -> Result<Raw, Failure> {
    let scan = Scan::open(folder)?;
    let Some(entry) = &scan.planes else {
        return Err(Failure::with_file(folder, "the scan states no planes"));
    };
    let planes = entry.family().map_err(|e| Failure::because(e.to_string()))?;
    let text = std::fs::read_to_string(folder.join(MANIFEST_FILE))?;
    let manifest: serde_json::Value = serde_json::from_str(&text)?;
    let size = manifest.get("size").and_then(serde_json::Value::as_f64);
    let tolerance = size.map_or(TOLERANCE_SHARE * planes.interval(), |s| SIZE_SHARE * s);
    let truth = read_truth(&folder.join(TRUTH_FILE))?;
    let mesh = Mesh { vertices: truth.vertices, faces: truth.faces };
    simulated(planes, trial::load(&scan)?, &mesh, tolerance)
}

fn simulated(
    planes: PlaneFamily,
    views: Vec<View>,
    mesh: &Mesh,
    tolerance: f64,
) -> Result<Raw, Failure> {
    let cut = sections(mesh, &planes)?;
    let truth: Result<_, MergeError> =
        cut.into_iter().map(|(k, c)| Ok((k, merge_overlaps(c)?))).collect();
    let truth = truth?;
    let visible = Some(Visibility::new(mesh, views.clone())?);
    let (reference, options) =
        (Some(Reference { truth, visible }), EvaluateOptions::new(tolerance));
    Ok(Raw { planes, parts: vec![views], reference, options })
}

fn bunny(data: &Path) -> Result<Raw, Failure> {
    let (Public { views, planes }, mesh) = trial::bunny(data)?;
    let truth = sections(&mesh, &planes)?;
    let (reference, options) = (Some(Reference { truth, visible: None }), trial::bunny_options());
    Ok(Raw { planes, parts: vec![views], reference, options })
}

/// The even frames and the odd ones.
fn halves(data: &Path) -> Result<Raw, Failure> {
    let Public { views, planes } = trial::red_kitchen(data)?;
    let half = |first: usize| views.iter().skip(first).step_by(2).cloned().collect();
    let (parts, options) = (vec![half(0), half(1)], EvaluateOptions::new(0.02));
    Ok(Raw { planes, parts, reference: None, options })
}
