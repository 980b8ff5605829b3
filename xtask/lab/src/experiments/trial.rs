//! From a scene and a sensor plan to a model and its accuracy, all in memory.

use crate::failure::Failure;
use rayon::prelude::*;
use std::path::Path;
use transect::evaluate::{Accuracy, EvaluateOptions};
use transect::{PoseReport, Reconstruction, Setup, Unwatched, ViewSource, reconstruct};
use transect_device::View;
use transect_exchange::{Scan, read_mesh};
use transect_geometry::{LengthUnit, PlaneFamily, StraightGuide, Vector3};
use transect_model::Model;
use transect_register::{CoarseView, RefineOptions, refine};
use transect_scene::{Mesh, Noise};
use transect_workflow::simulation::{PreparedScene, describe};
use transect_workflow::{ScoreLimits, simulated_accuracy};

/// The `[[station]]` of a square camera at a place, looking at the origin.
pub fn camera([x, y, z]: [f64; 3], pixels: usize, field_deg: f64) -> String {
    format!(
        "[[station]]\nsensor = \"pinhole\"\nrows = {pixels}\ncols = {pixels}\n\
         field_of_view = {field_deg}\nat = [{x}, {y}, {z}]\nlook_at = [0, 0, 0]\n"
    )
}

/// A bundled scene, ready to be simulated.
pub fn bundled(name: &str) -> Result<PreparedScene, Failure> {
    Ok(PreparedScene::new(describe(Path::new(name))?)?)
}

/// The same without noise.
pub fn bundled_without_noise(name: &str) -> Result<PreparedScene, Failure> {
    let mut description = describe(Path::new(name))?;
    description.noise = Noise::NONE;
    Ok(PreparedScene::new(description)?)
}

/// A public scan with the planes that the documentation shows it on.
pub struct Public {
    pub views: Vec<View>,
    pub planes: PlaneFamily,
}

/// The Stanford bunny, and the published mesh that was merged from the same scans.
pub fn bunny(data: &Path) -> Result<(Public, Mesh), Failure> {
    let folder = data.join("stanford_bunny");
    let views = load(&Scan::open(&folder.join("bun.conf"))?)?;
    let mesh = read_mesh(&folder.join("reference/bun_zipper.ply"))?.mesh;
    let mesh = Mesh { vertices: mesh.vertices, faces: mesh.faces };
    Ok((Public { views, planes: across([0.0, 1.0, 0.0], 0.001)? }, mesh))
}

/// How the bunny is held against its mesh: the scans do not show the base, and the mesh closes it.
pub fn bunny_options() -> EvaluateOptions {
    EvaluateOptions::new(0.0005).from_station(BUNNY_FROM)
}

/// The bunny's lowest station with a whole surface, in metres.
pub const BUNNY_FROM: f64 = 0.06;

/// The red kitchen: 50 depth images.
pub fn red_kitchen(data: &Path) -> Result<Public, Failure> {
    let views = load(&Scan::open(&data.join("rgbd_redkitchen"))?)?;
    Ok(Public { views, planes: across([0.0, -1.0, 0.0], 0.1)? })
}

/// The views of a scan on disk.
pub fn load(scan: &Scan) -> Result<Vec<View>, Failure> {
    let views: Result<Vec<View>, _> =
        scan.views.par_iter().map(|v| v.load().map(|(view, _)| view)).collect();
    Ok(views?)
}

/// Planes across a normal, from the origin on.
fn across(normal: [f64; 3], interval: f64) -> Result<PlaneFamily, Failure> {
    let guide = StraightGuide::along(Vector3::from(normal));
    let planes = guide.and_then(|guide| PlaneFamily::new(guide, 0.0, interval));
    planes.map_err(|e| Failure::because(e.to_string()))
}

/// The default methods on a scene's planes.
pub fn setup(scene: &PreparedScene) -> Setup {
    Setup::new(scene.description.unit, scene.description.planes.clone())
}

/// The number of pixels of all views.
pub fn pixels(views: &[View]) -> usize {
    views.iter().map(|v| v.image().size().pixels()).sum()
}

/// The model of views, with the default methods.
pub fn model(views: &[View], unit: LengthUnit, planes: PlaneFamily) -> Result<Model, Failure> {
    Ok(reconstruct(views, &Setup::new(unit, planes), &Unwatched)?.model)
}

/// The model of views of a scene, with the default methods.
pub fn scene_model(scene: &PreparedScene, views: &[View]) -> Result<Model, Failure> {
    Ok(reconstruct(views, &setup(scene), &Unwatched)?.model)
}

/// The result of views of a scene, and the model's score on the part that they could see.
pub fn scored(
    scene: &PreparedScene,
    views: &[View],
    setup: &Setup,
) -> Result<(Reconstruction, Accuracy), Failure> {
    let result = reconstruct(views, setup, &Unwatched)?;
    let limits = ScoreLimits::default();
    let accuracy = simulated_accuracy(&result.model, &scene.truth, views.to_vec(), &limits)?;
    Ok((result, accuracy))
}

/// Median and 95 % quantile of the distances from the true sections.
pub fn errors(scene: &PreparedScene, views: &[View], setup: &Setup) -> Result<[f64; 2], Failure> {
    let (_, Accuracy { median, p95, .. }) = scored(scene, views, setup)?;
    Ok([median, p95].map(|error| error.unwrap_or(f64::INFINITY)))
}

/// The views at refined poses.
pub fn at_refined_poses(views: &[View]) -> Result<Vec<View>, Failure> {
    let copies: Vec<CoarseView> = views.iter().map(CoarseView::new).collect();
    let poses = refine(&copies, &RefineOptions::default())?.poses;
    let pairs = views.iter().zip(poses);
    let views: Result<Vec<View>, _> =
        pairs.map(|(view, pose)| view.with_pose(pose.world_from_sensor)).collect();
    Ok(views?)
}

/// The views at refined poses, without the errors that their depth cameras make alike.
pub fn corrected(views: &[View]) -> Result<Vec<View>, Failure> {
    let options = Some(RefineOptions::default());
    let report = PoseReport::new(views, options.as_ref(), LengthUnit::Metre, &Unwatched)?;
    let posed = report.posed(views);
    let loaded: Result<Vec<View>, _> =
        posed.iter().map(|source| source.load().map(|loaded| loaded.view)).collect();
    loaded.map_err(|e| Failure::because(e.to_string()))
}
