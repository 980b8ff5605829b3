//! The curves of one plane from several views to one set of curves (dissertation, chapter 5).
//!
//! The one decision of this crate: fusion happens **in a plane**, with nothing but oriented curves;
//! direction tells surfaces apart. It refuses to know sensors, storage and other planes.
//!
//! * [`mod@consensus`]: all views at once, the default;
//! * [`mod@pairwise`]: view by view and curve by curve, the dissertation's own way;
//! * [`agreement()`]: whether views contradict each other, the sign of a wrong pose;
//! * [`envelopes`], [`screening`], [`pattern`]: the dissertation's envelopes and overlap rules (5.3, 5.4).

mod agreement;
pub mod consensus;
pub mod envelopes;
mod grid;
pub mod pairwise;
pub mod pattern;
pub mod screening;

pub use agreement::{Agreement, agreement};
pub use consensus::{ConsensusOptions, Measured, consensus, measure};
pub use pairwise::{PairwiseOptions, pairwise};

use consensus::observations::Observations;
use serde::{Deserialize, Serialize};
use transect_geometry::Curve;

/// How the curves of a plane are fused.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
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
pub fn fuse_plane(views: &[&[Curve]], method: &FusionMethod) -> FusedPlane {
    match method {
        FusionMethod::Consensus(options) => consensus(views, options),
        FusionMethod::Pairwise(options) => pairwise(views, options),
    }
}

/// The same, and how each view agrees with the others: what is needed of the views is collected once.
pub fn fuse_and_compare(views: &[&[Curve]], method: &FusionMethod) -> (FusedPlane, Vec<Agreement>) {
    let observations = Observations::collect(
        views,
        &match method {
            FusionMethod::Consensus(options) => options.steps,
            FusionMethod::Pairwise(_) => consensus::Steps::ALL,
        },
    );
    let agreement = agreement::between(&observations, views.len());
    let plane = match method {
        FusionMethod::Consensus(options) => consensus::fuse(observations, options),
        FusionMethod::Pairwise(options) => pairwise(views, options),
    };
    (plane, agreement)
}

/// The fused curves of one plane.
#[derive(Debug, Clone, Default)]
pub struct FusedPlane {
    /// The curves, longest first.
    pub curves: Vec<Curve>,
    /// Measured standard deviation of one view's curve against the common one, in the length unit;
    /// of one view alone, or of views that do not overlap, the median of their nodes' own.
    pub spread: f64,
    /// Distance within which curves of the same direction were taken for one, in the length unit.
    pub threshold: f64,
    /// What went in and what was left out.
    pub counts: FusionCounts,
}

/// Counts of one plane's fusion.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FusionCounts {
    /// Nodes of all views.
    pub observations: usize,
    /// Nodes kept for the result before tidying.
    pub kept: usize,
    /// Nodes left out. Of `consensus`: kept ones beside a better curve, too short to be one, or a
    /// step to the side. Of `pairwise`: observations farther than the threshold from every fused curve.
    pub dropped: usize,
    /// Pairs of curves that overlap as the rules forbid, and stay beside each other. Always 0 for
    /// `consensus`, which resolves them.
    pub refused: usize,
}
