//! From a scene and a sensor plan to a model and its accuracy, all in memory.

use crate::failure::Failure;
use std::path::Path;
use transect::evaluate::Accuracy;
use transect::{Setup, Unwatched, reconstruct};
use transect_device::View;
use transect_geometry::{LengthUnit, PlaneFamily};
use transect_model::Model;
use transect_scene::Noise;
use transect_workflow::simulation::{PreparedScene, SensorPlan, describe};
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

/// The model of views, with the default methods.
pub fn model(views: &[View], unit: LengthUnit, planes: PlaneFamily) -> Result<Model, Failure> {
    Ok(reconstruct(views, &Setup::new(unit, planes), &Unwatched)?.model)
}

/// The views of a simulated scan and their model.
pub struct Outcome {
    /// The views.
    pub views: Vec<View>,
    /// The model.
    pub model: Model,
}

/// Simulates a plan on a scene and reconstructs it.
pub fn run(scene: &PreparedScene, plan: &SensorPlan) -> Result<Outcome, Failure> {
    let views = scene.simulate(plan)?.views;
    let model = model(&views, scene.description.unit, scene.description.planes.clone())?;
    Ok(Outcome { views, model })
}

impl Outcome {
    /// The number of pixels of all views.
    pub fn pixels(&self) -> usize {
        self.views.iter().map(|v| v.image().size().pixels()).sum()
    }

    /// Scores the model on the part of the scene that the views could see.
    pub fn accuracy(&self, scene: &PreparedScene) -> Result<Accuracy, Failure> {
        let (views, limits) = (self.views.clone(), ScoreLimits::default());
        Ok(simulated_accuracy(&self.model, &scene.truth, views, &limits)?)
    }
}
