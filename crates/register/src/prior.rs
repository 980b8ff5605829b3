//! How far poses may be wrong.

/// How far poses may be wrong, as standard deviations: finite numbers of 0 or more.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PosePrior {
    /// Of the rotation about each axis, in radians.
    pub rotation: f64,
    /// Of the translation along each axis, in the model's length unit.
    pub translation: f64,
}

/// Why a [`PosePrior`] cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PriorError {
    /// The prior of one view has a number that is negative or not finite.
    #[error(
        "view {view}: its pose has a standard deviation of {} rad and of {} in the unit of length; \
         expected finite numbers of 0 or more, or no prior",
        prior.rotation,
        prior.translation
    )]
    OfView {
        /// The view's name.
        view: String,
        /// Its prior.
        prior: PosePrior,
    },
    /// The prior of all views has a number that is negative or not finite.
    #[error(
        "the prior of all views has a standard deviation of {} rad and of {} in the unit of \
         length; expected finite numbers of 0 or more, or no prior",
        .0.rotation,
        .0.translation
    )]
    OfAll(PosePrior),
}

impl PosePrior {
    pub(crate) fn is_sound(&self) -> bool {
        [self.rotation, self.translation].iter().all(|sigma| sigma.is_finite() && *sigma >= 0.0)
    }
}
