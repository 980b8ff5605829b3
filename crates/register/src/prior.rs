//! How far poses may be wrong.

/// How far poses may be wrong, as standard deviations: finite numbers of 1e-12 or more.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PosePrior {
    /// Of the rotation about each axis, in radians.
    pub rotation: f64,
    /// Of the translation along each axis, in the model's length unit.
    pub translation: f64,
}

/// The least standard deviation, in radians or in the model's length unit. Theory: squares of its
/// inverse are still added to other numbers without loss of range. Doubled, nothing changes.
const LEAST: f64 = 1e-12;

/// Why a [`PosePrior`] cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PriorError {
    /// The prior of one view has a number that is not finite or too small.
    #[error(
        "view {view}: its pose has a standard deviation of {} rad and of {} in the unit of length; \
         expected finite numbers of 1e-12 or more, or no prior",
        prior.rotation,
        prior.translation
    )]
    OfView {
        /// The view's name.
        view: String,
        /// Its prior.
        prior: PosePrior,
    },
    /// The prior of all views has a number that is not finite or too small.
    #[error(
        "the prior of all views has a standard deviation of {} rad and of {} in the unit of \
         length; expected finite numbers of 1e-12 or more, or no prior",
        .0.rotation,
        .0.translation
    )]
    OfAll(PosePrior),
}

impl PosePrior {
    /// The larger of both standard deviations of each.
    pub(crate) fn or_wider(self, other: Self) -> Self {
        Self {
            rotation: self.rotation.max(other.rotation),
            translation: self.translation.max(other.translation),
        }
    }

    pub(crate) fn is_sound(&self) -> bool {
        [self.rotation, self.translation].iter().all(|sigma| sigma.is_finite() && *sigma >= LEAST)
    }
}
