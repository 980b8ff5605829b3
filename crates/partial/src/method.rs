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
pub enum Method {
    /// All planes in one sweep over the image: the default, and faster by an order or two.
    OnePass(OnePassOptions),
    /// Plane by plane, as chapter 3 describes it.
    Dissertation(DissertationOptions),
}

impl Default for Method {
    fn default() -> Self {
        Self::OnePass(OnePassOptions::default())
    }
}

/// The partial model of a view.
///
/// ```
/// use std::sync::Arc;
/// use transect_device::{ImageSize, Isometry3, RangeImage, Vector3, View};
/// use transect_geometry::{PlaneFamily, StraightGuide};
/// use transect_partial::{EndReason, Method, partial_model};
/// use transect_sensors::{Intrinsics, Pinhole};
///
/// // A camera looks straight at a wall two units ahead.
/// let size = ImageSize { rows: 48, cols: 64 };
/// let camera = Pinhole::new(size, Intrinsics { fx: 120.0, fy: 120.0, cx: 31.5, cy: 23.5 })?;
/// let image = RangeImage::from_values(size, vec![2.0; size.pixels()])?;
/// let view = View::new("wall", image, Arc::new(camera), Isometry3::identity(), Some(0.0))?;
///
/// // Of horizontal planes 0.1 apart, those at -0.3, -0.2, ... 0.3 cross the image.
/// let planes = PlaneFamily::new(StraightGuide::along(Vector3::y())?, 0.0, 0.1)?;
/// let model = partial_model(&view, &planes, &Method::default())?;
/// assert_eq!(model.planes.len(), 7);
/// let curve = &model.planes[0].curves[0];
/// assert_eq!(curve.curve.nodes().len(), 64);
/// assert_eq!(curve.curve.ends(), [Some(EndReason::ImageBorder); 2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PartialError`] if the planes are too dense or too far for the view, or cross it too often.
/// Also if the sensor has no point for any value of the image.
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
