//! The promises that every model keeps, as errors that say where one is broken.

use crate::CurveIndex;
use transect_geometry::{GuideError, PlaneIndex};

/// An invariant that a model breaks, with the place.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InvariantError {
    /// A plane does not come after the one stored before it.
    #[error("plane {0} is out of order")]
    PlaneOutOfOrder(PlaneIndex),
    /// The guide, offset or interval makes no plane family.
    #[error("the section planes are invalid")]
    Planes(#[source] GuideError),
    /// A plane lies before the first or after the last station of a curved guide.
    #[error("plane {0} lies beyond the ends of the guide")]
    BeyondGuide(PlaneIndex),
    /// A plane has curves but is not among the selected planes.
    #[error("plane {0} has curves but is not a selected plane")]
    NotSelected(PlaneIndex),
    /// The guide's direction does not have length 1.
    #[error("the guide direction has length {0}, not 1")]
    GuideNotUnit(f64),
    /// A section without curves is stored.
    #[error("plane {0} has no curves")]
    EmptySection(PlaneIndex),
    /// The envelope recorded with a curve is not the one around its nodes.
    #[error("the envelope of curve {curve} on plane {plane} is not the one around its nodes")]
    CurveEnvelope {
        /// The plane it is on.
        plane: PlaneIndex,
        /// Its place among the plane's curves.
        curve: CurveIndex,
    },
    /// The envelope recorded with a plane is not the one around its curves.
    #[error("the envelope of plane {0} is not the one around its curves")]
    PlaneEnvelope(PlaneIndex),
    /// A view's pose is not a rigid motion with finite numbers.
    #[error("view {0:?} has a pose that is not a rigid motion")]
    Pose(String),
    /// A view's noise is negative, NaN or infinite.
    #[error("view {name:?} has the range noise {sigma}, which must be finite and at least 0")]
    Sigma {
        /// Name of the view.
        name: String,
        /// The noise recorded with it.
        sigma: f64,
    },
}
