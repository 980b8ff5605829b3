//! From a scene and a plan to a model and its accuracy, all in memory.

use crate::failure::Failure;
use crate::simulation::{PreparedScene, SensorPlan};
use std::collections::BTreeMap;
use transect::evaluate::{Accuracy, EvaluateOptions, evaluate_seen};
use transect::{Setup, Unwatched, reconstruct};
use transect_device::View;
use transect_geometry::{Curve, PlaneIndex, Point2};
use transect_model::Model;
use transect_scene::{Visibility, merge_overlaps, sections};

/// Distance within which a curve counts as right, as a share of the plane interval: that of
/// `evaluate`.
const TOLERANCE_SHARE: f64 = 0.2;

/// What came of a simulated scan.
pub struct Outcome {
    /// What the sensors saw.
    pub views: Vec<View>,
    /// What was made of it.
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
    /// Scores the model on what the views could see of the scene.
    pub fn accuracy(&self, scene: &PreparedScene) -> Result<Accuracy, Failure> {
        let planes = scene.description.planes.clone();
        let truth = sections(&scene.truth, &planes)?;
        let united = truth.into_iter().map(|(k, c)| (k, merge_overlaps(c))).collect();
        let visible = Visibility::new(&scene.truth, self.views.clone())?;
        let seen = |k: PlaneIndex, p: &Point2| visible.sees(&planes.frame(k).world_from_plane(p));
        let options =
            EvaluateOptions::new(TOLERANCE_SHARE * planes.interval());
        Ok(evaluate_seen(&planes, &self.curves(), &united, &seen, &options)?)
    }

    /// The model's curves by plane.
    pub fn curves(&self) -> BTreeMap<PlaneIndex, Vec<Curve>> {
        self.model.sections().map(|(k, s)| (k, s.curves().cloned().collect())).collect()
    }
}
