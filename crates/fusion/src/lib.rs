//! The curves of one plane from several views to one set of curves (dissertation, chapter 5).
//!
//! The decision of this crate: fusion happens **in a plane**, with nothing but oriented curves;
//! direction tells surfaces apart. It does not know sensors, storage and other planes.
//!
//! * [`mod@consensus`]: all views at once, the default;
//! * [`mod@pairwise`]: view by view and curve by curve, the dissertation's own way;
//! * [`envelopes`], [`screening`], [`pattern`]: the dissertation's envelopes and overlap rules
//!   (5.3, 5.4).
//!
//! `cargo run -p transect-fusion --example two_views` fuses two views of a room's corner.

pub mod consensus;
pub mod envelopes;
mod fused_plane;
mod grid;
mod ground;
pub mod pairwise;
pub mod pattern;
mod planar;
pub mod screening;
mod sequence;

pub use consensus::{ConsensusOptions, Measured, consensus, measure};
pub use fused_plane::{FusedPlane, FusionCounts};
pub use pairwise::{PairwiseOptions, pairwise};

use serde::{Deserialize, Serialize};
use transect_geometry::Curve;

/// How the curves of a plane are fused.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FusionMethod {
    /// All views at once: the default. The order of views changes nothing.
    Consensus(ConsensusOptions),
    /// View by view and curve by curve, as chapter 5 describes it; every merge moves the curve.
    Pairwise(PairwiseOptions),
}

impl Default for FusionMethod {
    fn default() -> Self {
        Self::Consensus(ConsensusOptions::default())
    }
}

/// Fuses the curves of one plane, given view by view.
///
/// ```
/// use transect_fusion::{FusionMethod, fuse_plane};
/// use transect_geometry::{Curve, Node, Point2};
///
/// // Each of two views saw three quarters of a circle of radius 1.
/// let view = |from: u32| {
///     let node = |k: u32| {
///         let angle = f64::from(from + k).to_radians();
///         Node::at(Point2::new(angle.cos(), angle.sin())).with_footprint(0.017)
///     };
///     Curve::new((0..270).map(node).collect(), false).map(|curve| vec![curve])
/// };
/// let (first, second) = (view(0)?, view(180)?);
/// let plane = fuse_plane(&[&first, &second], &FusionMethod::default());
///
/// assert_eq!(plane.curves.len(), 1);
/// assert!(plane.curves[0].is_closed());
/// assert!(plane.curves[0].nodes().iter().all(|n| (n.position.coords.norm() - 1.0).abs() < 1e-4));
/// # Ok::<(), transect_geometry::CurveError>(())
/// ```
pub fn fuse_plane(views: &[&[Curve]], method: &FusionMethod) -> FusedPlane {
    match method {
        FusionMethod::Consensus(options) => consensus(views, options),
        FusionMethod::Pairwise(options) => pairwise(views, options),
    }
}
