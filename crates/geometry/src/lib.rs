//! The parts of a cross-section model: a guide, section planes along it, oriented plane curves.
//!
//! The one decision of this crate: **a curve has its solid on the left**, seen from the positive
//! side of the plane's normal (dissertation, sections 2.4.3 and 2.5.2). Outer boundaries therefore
//! run counter-clockwise and holes clockwise in plane coordinates, and signed areas add up.
//!
//! It does not know sensors, files or fusion. All lengths are in the model's one length unit; all
//! coordinates are `f64`.
//!
//! * [`LengthUnit`]: the unit of all lengths; [`Length`]: a length with its own unit;
//! * [`Guide`], [`StraightGuide`], [`CurvedGuide`], [`PlaneFamily`], [`PlaneIndex`],
//!   [`PlaneFrame`]: the planes;
//! * [`Node`], [`Curve`], [`EndReason`], [`Envelope`]: the curves on them;
//! * [`fit_splines`]: a curve as cubic B-splines within a tolerance;
//! * [`CurveUnit`], [`Foot`], [`Side`]: the distance of a point from a curve, and its side.

mod crossings;
mod curve;
mod curve_error;
mod end_reason;
mod envelope;
mod guide;
mod length_unit;
mod plane_frame;
mod space;
mod splines;
mod unit;

pub use crossings::{UnitPlace, crossings};
pub use curve::{Curve, Node, StoredNode};
pub use curve_error::CurveError;
pub use end_reason::EndReason;
pub use envelope::Envelope;
pub use guide::{
    CurvedGuide, Guide, GuideError, GuideKind, MAX_GUIDE_POINTS, NoStation, PlaneFamily,
    PlaneIndex, StraightGuide,
};
pub use length_unit::{Length, LengthError, LengthUnit};
pub use plane_frame::PlaneFrame;
pub use space::{Isometry3, Point2, Point3, Vector2, Vector3};
pub use splines::{CubicSpline, CurveSplines, SplineError, fit_splines};
pub use unit::{CurveUnit, Foot, Side};
