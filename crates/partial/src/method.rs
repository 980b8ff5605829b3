//! The ways to find a view's curves, behind one call.

use crate::dissertation::{self, DissertationOptions};
use crate::one_pass::{self, OnePassOptions};
use crate::{PartialError, PartialModel};
use serde::{Deserialize, Serialize};
use transect_device::View;
use transect_geometry::PlaneFamily;

/// How a view's curves are found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Method {
    /// All planes in one sweep over the image: the default, and faster by an order or two.
    OnePass(OnePassOptions),
    /// Plane by plane, as chapter 3 describes it; not for sensors without an inverse mapping.
    Dissertation(DissertationOptions),
}

impl Default for Method {
    fn default() -> Self {
        Self::OnePass(OnePassOptions::default())
    }
}

/// The partial model of a view.
///
/// # Errors
/// [`PartialError`] if the planes are too dense for the view, or the method is not for its sensor.
pub fn partial_model(
    view: &View,
    planes: &PlaneFamily,
    method: &Method,
) -> Result<PartialModel, PartialError> {
    match method {
        Method::OnePass(options) => one_pass::partial_model(view, planes, options),
        Method::Dissertation(options) => dissertation::partial_model(view, planes, options),
    }
}
