//! View by view and curve by curve: the dissertation's way to fuse a plane (5.2 to 5.5).
//!
//! **Problem.** Several views saw parts of the same section. Wanted: one curve where they overlap,
//! and no fork.
//!
//! **Idea.** A model grows. Each view's curves are held against those that are there; where two
//! overlap as the rules of 5.4 allow, they become one, half way between the two.
//!
//! **Steps.**
//! 1. Envelopes screen pairs of curves, and their common rectangle limits the search
//!    ([`crate::envelopes`], [`crate::screening`]; 5.3).
//! 2. Directions reject neighbouring surfaces (Figure 5.5).
//! 3. The parts a, b, c of both curves give one of 16 combinations, and the table says whether it
//!    can be ([`crate::pattern`]; 5.4).
//! 4. Projection on curve units verifies the overlap and names basis and distant curve
//!    (`verify.rs`; 5.5.1).
//! 5. The overlap is averaged (`average/mod.rs`; 5.5.2) and spliced in (`splice.rs`).
//! 6. The grown curve goes on to the next candidate (`grow.rs`; 5.2.2, 5.3.1).
//! 7. Where two curves fork, the shorter part is cut off and the rest is merged (`fork.rs`).
//! 8. Bridges over range jumps that another view saw are left out; units that no view measured are
//!    marked, and each node counts its views (`bridges.rs`).
//!
//! **Departures from the source** stand in each file. In all: the dissertation gives no threshold;
//! here it follows from the measured spread between the views, as for
//! [`consensus`](mod@crate::consensus). Where two curves fork, one is cut (`fork.rs`). Pairs that
//! cannot be cut or merged stay beside each other, and are counted. Bridges over ground in another
//! view's shadow are taken out, and units that no view measured are marked (`bridges.rs`).
//!
//! **When not to use it.** The result drifts with every merge, since midpoints of chords lie inside
//! an arc. The last view weighs as much as all before it, so the order of views shows. It is the
//! specification in the dissertation's terms, and the baseline for `consensus`.
//!
//! **Cost.** For each view, the length of its curves and of those they meet, times its logarithm.

mod average;
mod bridges;
mod fork;
mod grow;
mod splice;
mod steps;
mod strand;
mod verify;

pub use grow::{GrowingPlane, GrowthCase, GrowthCounts};
pub use splice::Refusal;
pub use steps::{MergeOutcome, MergeSteps, VerifiedOverlap, merge_steps};

use crate::consensus::ConsensusOptions;
use crate::consensus::measure::{Measurements, Observations};
use crate::envelopes::UnitIndex;
use crate::fused_plane::{FusedPlane, FusionCounts, longest_first};
use crate::ground::Ground;
use crate::pattern::OverlapTolerance;
use crate::planar::{Shortest, without_crossings};
use serde::{Deserialize, Serialize};
use transect_geometry::Curve;

/// Options. Without a tolerance no length is in the user's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct PairwiseOptions {
    /// When two curves overlap; `None` takes it from the measured spread between the views.
    pub tolerance: Option<OverlapTolerance>,
    /// Overlap threshold in measured spreads, if it is measured.
    pub threshold_spreads: f64,
}

impl Default for PairwiseOptions {
    fn default() -> Self {
        let threshold_spreads = ConsensusOptions::default().threshold_spreads;
        Self { tolerance: None, threshold_spreads }
    }
}

/// Stretches that count as nothing, in thresholds: what a curve needs to come within reach of
/// another under a flat angle.
const REMAINDER_THRESHOLDS: f64 = 4.0;

/// And in footprints: a single node off at the end of a curve is no fork.
const REMAINDER_FOOTPRINTS: f64 = 2.0;

/// Fuses the curves of one plane; one slice of curves per view, in the order of their arrival.
///
/// ```
/// use transect_fusion::{PairwiseOptions, pairwise};
/// use transect_geometry::{Curve, Node, Point2};
/// let wall = |from: i32, to: i32, y: f64| {
///     let nodes = (from..=to).map(|k| Node::at(Point2::new(0.1 * f64::from(k), y)));
///     vec![Curve::new(nodes.collect(), false).unwrap()]
/// };
/// let (left, right) = (wall(0, 60, 0.0), wall(40, 90, 0.004));
/// let fused = pairwise(&[&left, &right], &PairwiseOptions::default());
/// assert_eq!(fused.curves.len(), 1);
/// let middle = fused.curves[0].foot(&Point2::new(5.0, 0.0)).point;
/// assert!((middle.y - 0.002).abs() < 1e-9); // half way, in the length unit
/// ```
pub fn pairwise(views: &[&[Curve]], options: &PairwiseOptions) -> FusedPlane {
    pairwise_watched(views, options, &mut |_, _, _| ())
}

/// Fuses as [`pairwise`] does, and calls `watch` before each view: with its number, its curves
/// without the bridges that another view contradicts, and the plane so far.
pub fn pairwise_watched(
    views: &[&[Curve]],
    options: &PairwiseOptions,
    watch: &mut dyn FnMut(usize, &[Curve], &GrowingPlane),
) -> FusedPlane {
    let threshold_spreads = options.threshold_spreads;
    let mut measured = ConsensusOptions { threshold_spreads, ..ConsensusOptions::default() };
    // The views' curves are merged as they were measured.
    measured.steps.settle = false;
    let observations = Observations::collect(views, &measured.steps);
    let Some(measured) = Measurements::new(observations, &measured) else {
        return without_curves(views);
    };
    let (scale, spacing) = (measured.scale, measured.scale.spacing);
    let tolerance = options.tolerance.or_else(|| {
        let remainder =
            (REMAINDER_THRESHOLDS * scale.threshold).max(REMAINDER_FOOTPRINTS * spacing);
        OverlapTolerance::new(scale.threshold, scale.options.direction_limit_rad, remainder).ok()
    });
    // Only coordinates so large that distances overflow give no threshold. Nothing is near then.
    let Some(tolerance) = tolerance else { return without_curves(views) };
    let ground = Ground::new(&measured.observations, &measured.grid);
    let mut plane = GrowingPlane::new(tolerance);
    for (number, view) in views.iter().enumerate() {
        let kept = view.iter().flat_map(|curve| bridges::without_shadowed(curve, &ground));
        let kept: Vec<Curve> = kept.collect();
        watch(number, &kept, &plane);
        plane.grow(&kept);
    }
    let growth = Some(*plane.counts());
    let seen = |c: Curve| bridges::seen(c, &ground, spacing, tolerance.distance());
    let curves = plane.into_curves().into_iter().map(seen).collect();
    let shortest = Shortest { footprints: scale.options.shortest_footprints, unknown: spacing };
    let (mut curves, crossings) = without_crossings(curves, shortest);
    curves.sort_by(longest_first);
    let counts = FusionCounts {
        observations: views.iter().flat_map(|v| v.iter()).map(|c| c.nodes().len()).sum(),
        dropped: unseen(views, &curves, tolerance.distance()),
        crossings,
    };
    FusedPlane {
        curves,
        spread: measured.spread,
        view_error: measured.view_error,
        sigma_is_noise_alone: true,
        noise: measured.noise,
        threshold: tolerance.distance(),
        counts,
        growth,
    }
}

/// How many observations have no curve of the result within the threshold: left out as noise, on
/// the shorter of two ends, or moved away by one merge after another.
fn unseen(views: &[&[Curve]], curves: &[Curve], threshold: f64) -> usize {
    let index = UnitIndex::new(curves);
    let mut near = Vec::new();
    let nodes = views.iter().flat_map(|view| view.iter()).flat_map(Curve::nodes);
    nodes.filter(|node| !index.is_near(&node.position, threshold, &mut near)).count()
}

/// Nothing could be fused, and every node is counted as left out.
fn without_curves(views: &[&[Curve]]) -> FusedPlane {
    let observations = views.iter().flat_map(|v| v.iter()).map(|c| c.nodes().len()).sum();
    let counts = FusionCounts { observations, dropped: observations, ..FusionCounts::default() };
    FusedPlane { counts, ..FusedPlane::default() }
}
