//! The sets that steps are measured on: partial models made once, and what their curves are held
//! against.

use super::super::trial;
use super::crossings;
use super::worth::Figures;
use crate::bench::timing::once;
use crate::failure::Failure;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;
use transect::evaluate::{Accuracy, EvaluateOptions, evaluate, evaluate_seen};
use transect_device::View;
use transect_exchange::{Scan, TriangleMesh, read_mesh, read_truth};
use transect_fusion::{ConsensusOptions, FusionMethod, fuse_plane};
use transect_geometry::{Curve, PlaneFamily, PlaneIndex, Point2, StraightGuide, Vector3};
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
    pub shared: &'a Path,
    pub peers: Option<&'a Path>,
}

/// A set that is not loaded yet.
pub enum Source {
    Bundled(&'static str),
    Bunny(PathBuf),
    Halves(PathBuf),
    Peers(PathBuf),
}

impl Sources<'_> {
    /// All sets that are there.
    pub fn list(&self) -> Result<Vec<Source>, Failure> {
        let mut list: Vec<_> = BUNDLED_SCENES.iter().map(|(n, _)| Source::Bundled(n)).collect();
        let data = |name: &str| Some(self.shared.join("data").join(name)).filter(|d| d.is_dir());
        list.extend(data("stanford_bunny").map(Source::Bunny));
        list.extend(data("rgbd_redkitchen").map(Source::Halves));
        if let Some(peers) = self.peers {
            let entries = std::fs::read_dir(peers).map_err(|e| Failure::with_file(peers, e))?;
            let mut folders: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
            folders.retain(|f| f.join("truth.npz").is_file());
            folders.sort();
            list.extend(folders.into_iter().map(Source::Peers));
        }
        Ok(list)
    }
}

impl Source {
    pub fn name(&self) -> String {
        match self {
            Self::Bundled(name) => (*name).to_owned(),
            Self::Bunny(_) => "bunny".to_owned(),
            Self::Halves(_) => "kitchen halves".to_owned(),
            Self::Peers(folder) => {
                folder.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
            }
        }
    }

    /// Reads or simulates the views and finds their curves.
    pub fn load(&self, method: &Method) -> Result<Set, Failure> {
        let name = self.name();
        match self {
            Self::Bundled(scene) => bundled(name, scene, method),
            Self::Bunny(folder) => bunny(name, folder, method),
            Self::Halves(folder) => halves(name, folder, method),
            Self::Peers(folder) => peers(name, folder, method),
        }
    }
}

type Sections = BTreeMap<PlaneIndex, Vec<Curve>>;

/// The curves of some views on a plane, view by view.
type Observed = BTreeMap<PlaneIndex, Vec<Vec<Curve>>>;

/// A set, ready to be fused.
pub struct Set {
    pub name: String,
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
    /// What the views could see of it, and what was asked so far; `None` if all of it counts.
    visible: Option<Visible>,
}

struct Visible {
    rays: Visibility,
    asked: BTreeMap<PlaneIndex, Mutex<HashMap<[u64; 2], bool>>>,
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
        let seen = |k: PlaneIndex, p: &Point2| visible.sees(&self.planes, k, p);
        Ok(evaluate_seen(&self.planes, curves, truth, &seen, &self.options)?)
    }
}

impl Visible {
    fn new(mesh: &Mesh, views: Vec<View>, truth: &Sections) -> Result<Self, Failure> {
        let asked = truth.keys().map(|k| (*k, Mutex::default())).collect();
        Ok(Self { rays: Visibility::new(mesh, views)?, asked })
    }

    fn sees(&self, planes: &PlaneFamily, k: PlaneIndex, p: &Point2) -> bool {
        let see = || self.rays.sees(&planes.frame(k).world_from_plane(p));
        let Some(Ok(mut asked)) = self.asked.get(&k).map(Mutex::lock) else { return see() };
        *asked.entry([p.x.to_bits(), p.y.to_bits()]).or_insert_with(see)
    }
}

fn bundled(name: String, scene: &str, method: &Method) -> Result<Set, Failure> {
    let stage = trial::bundled(scene)?;
    let views = stage.simulate(&SensorPlan::OWN)?.views;
    let planes = stage.description.planes.clone();
    let tolerance = TOLERANCE_SHARE * planes.interval();
    simulated(name, planes, (views, &stage.truth), tolerance, method)
}

fn peers(name: String, folder: &Path, method: &Method) -> Result<Set, Failure> {
    let scan = Scan::open(folder)?;
    let Some(entry) = &scan.planes else {
        return Err(Failure::because(format!("{name}: the scan states no planes")));
    };
    let planes = entry.family().map_err(|e| Failure::because(e.to_string()))?;
    let text = std::fs::read_to_string(folder.join("scan.json"))
        .map_err(|e| Failure::with_file(folder, e))?;
    let manifest: serde_json::Value =
        serde_json::from_str(&text).map_err(|e| Failure::with_file(folder, e))?;
    let size = manifest.get("size").and_then(serde_json::Value::as_f64);
    let tolerance = size.map_or(TOLERANCE_SHARE * planes.interval(), |s| SIZE_SHARE * s);
    let mesh = solid(read_truth(&folder.join("truth.npz"))?);
    simulated(name, planes, (load(&scan)?, &mesh), tolerance, method)
}

fn simulated(
    name: String,
    planes: PlaneFamily,
    (views, mesh): (Vec<View>, &Mesh),
    tolerance: f64,
    method: &Method,
) -> Result<Set, Failure> {
    let cut = sections(mesh, &planes)?;
    let truth: Sections = cut.into_iter().map(|(k, c)| (k, merge_overlaps(c))).collect();
    let (found, finding_seconds) = observed(&views, &planes, method)?;
    let visible = Some(Visible::new(mesh, views, &truth)?);
    let options = EvaluateOptions::new(tolerance);
    let (parts, reference) = (vec![found], Some(Reference { truth, visible }));
    Ok(Set { name, planes, parts, finding_seconds, reference, options })
}

fn bunny(name: String, folder: &Path, method: &Method) -> Result<Set, Failure> {
    let planes = upright([0.0, 1.0, 0.0], 0.001)?;
    let views = load(&Scan::open(&folder.join("bun.conf"))?)?;
    let mesh = solid(read_mesh(&folder.join("reference/bun_zipper.ply"))?.mesh);
    let truth = sections(&mesh, &planes)?;
    let (found, finding_seconds) = observed(&views, &planes, method)?;
    // The scans do not show the base, and the reference closes it.
    let options = EvaluateOptions::new(0.0005).from_station(0.06);
    let (parts, reference) = (vec![found], Some(Reference { truth, visible: None }));
    Ok(Set { name, planes, parts, finding_seconds, reference, options })
}

/// The even frames and the odd ones.
fn halves(name: String, folder: &Path, method: &Method) -> Result<Set, Failure> {
    let planes = upright([0.0, -1.0, 0.0], 0.1)?;
    let views = load(&Scan::open(folder)?)?;
    let half = |first: usize| {
        let views: Vec<View> = views.iter().skip(first).step_by(2).cloned().collect();
        observed(&views, &planes, method)
    };
    let ((even, even_seconds), (odd, odd_seconds)) = (half(0)?, half(1)?);
    let (parts, finding_seconds) = (vec![even, odd], even_seconds + odd_seconds);
    let options = EvaluateOptions::new(0.02);
    Ok(Set { name, planes, parts, finding_seconds, reference: None, options })
}

fn upright(normal: [f64; 3], interval: f64) -> Result<PlaneFamily, Failure> {
    let guide = StraightGuide::along(Vector3::from(normal));
    let planes = guide.and_then(|guide| PlaneFamily::new(guide, 0.0, interval));
    planes.map_err(|e| Failure::because(e.to_string()))
}

fn solid(mesh: TriangleMesh) -> Mesh {
    Mesh { vertices: mesh.vertices, faces: mesh.faces }
}

fn load(scan: &Scan) -> Result<Vec<View>, Failure> {
    let views: Result<Vec<View>, _> =
        scan.views.par_iter().map(|v| v.load().map(|(view, _)| view)).collect();
    Ok(views?)
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
