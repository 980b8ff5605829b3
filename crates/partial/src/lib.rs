//! One view to oriented curves on every section plane: partial modelling (dissertation, chapter 3).
//!
//! The one decision of this crate: curves are found **in the range image**, where samples are
//! neighbours, and not among points in space. It refuses to know other views and storage.
//!
//! * [`partial_model`]: by either [`Method`];
//! * [`one_pass`]: all planes in one sweep over the image;
//! * [`dissertation`]: plane by plane, in the dissertation's own steps;
//! * [`subpixel`]: where a plane passes between two pixels (3.6);
//! * [`BreakRule`]: where neighbouring pixels do not belong to one surface (3.4.2);
//! * [`PartialCurve`]: a curve with what only its view knows of it;
//! * [`SectionAxes`]: levels and plane coordinates straight from sensor coordinates.

mod axes;
mod continuation;
pub mod dissertation;
mod error;
mod method;
mod model;
mod near_planes;
mod node_values;
pub mod one_pass;
mod partial_curve;
mod pixel_grid;
mod repeats;
pub mod subpixel;

pub use axes::SectionAxes;
pub use error::{MAX_CROSSINGS, MAX_LEVELS, PartialError};
pub use method::{Method, partial_model};
pub use model::{PartialCounts, PartialModel};
#[doc(hidden)]
pub use near_planes::near_planes;
pub use partial_curve::{PartialCurve, PlaneCurves};
pub use transect_geometry::EndReason;
pub use transect_image::{BreakRule, Instructions};
