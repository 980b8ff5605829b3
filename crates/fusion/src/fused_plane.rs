//! The result of fusing one plane.

use crate::consensus::measure::canonical;
use crate::pairwise::GrowthCounts;
use std::cmp::Ordering;
use transect_geometry::Curve;

/// The fused curves of one plane.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FusedPlane {
    /// The curves, longest first as they are fused. A run that leaves out nodes puts the pieces of
    /// a curve in its place.
    pub curves: Vec<Curve>,
    /// Measured standard deviation of one view's curve against the fused one, in the length unit.
    /// With one view, or views that do not overlap: the median of their nodes' own.
    pub spread: f64,
    /// The part of the spread that each view errs by as a whole, head-on, in the length unit; 0
    /// where noise explains the spread, or no two views overlap.
    pub view_error: f64,
    /// Whether the standard deviations of the nodes hold the noise of the pixels alone: no error
    /// that a view makes as a whole was found, or the method adds none, as `pairwise`.
    pub sigma_is_noise_alone: bool,
    /// Median standard deviation of the views' nodes by their own noise, in the length unit.
    pub noise: f64,
    /// Distance within which curves of the same direction count as one, in the length unit.
    pub threshold: f64,
    /// How many nodes went in and were left out.
    pub counts: FusionCounts,
    /// How the plane grew by `pairwise`; `None` for `consensus`, which merges all views at once.
    pub growth: Option<GrowthCounts>,
}

/// Counts of one plane's fusion.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FusionCounts {
    /// Nodes of all views.
    pub observations: usize,
    /// Nodes left out. Of `consensus`: placed nodes beside a better curve, on a curve that is too
    /// short, or on a chain that is no curve. Of `pairwise`: observations farther than the
    /// threshold from every fused curve.
    pub dropped: usize,
    /// Crossings of the curves that the last step resolved.
    pub crossings: usize,
}

/// The order of the curves of a fused plane: the longest first, and curves of equal length by all
/// that is known of them.
pub(crate) fn longest_first(a: &Curve, b: &Curve) -> Ordering {
    let by_length = b.length().total_cmp(&a.length());
    by_length.then_with(|| canonical(a, b))
}
