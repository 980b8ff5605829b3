//! From a scene and a sensor plan to a model and its accuracy, all in memory.

use crate::failure::Failure;
use transect::evaluate::Accuracy;
use transect::{Setup, Unwatched, reconstruct};
use transect_device::View;
use transect_model::Model;
use transect_workflow::simulation::{PreparedScene, SensorPlan};
use transect_workflow::{ScoreLimits, simulated_accuracy};

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
    let setup = Setup::new(scene.description.unit, scene.description.planes.clone());
    let model = reconstruct(&views, &setup, &Unwatched)?.model;
    Ok(Outcome { views, model })
}

impl Outcome {
    /// Scores the model on the part of the scene that the views could see.
    pub fn accuracy(&self, scene: &PreparedScene) -> Result<Accuracy, Failure> {
        let (views, limits) = (self.views.clone(), ScoreLimits::default());
        Ok(simulated_accuracy(&self.model, &scene.truth, views, &limits)?)
    }
}
