//! The curves of all views at once: the default way to fuse a plane.
//!
//! **Problem.** Several views measured parts of the same section. Wanted: one curve where they
//! overlap, more accurate than any single one. No duplicate, no fork, nothing invented, and both
//! sides of a thin sheet. The same result for any order of views.
//!
//! **Idea.** The dissertation merges curves two by two (5.2 to 5.5). Every merge moves the curve a
//! little, so errors add up, and the last view weighs as much as all before it. Here every view's
//! curves stay as they were measured, and the common curve is estimated from all of them at once.
//! Direction tells neighbouring surfaces apart, as in Figure 5.5.
//!
//! **Steps**, in four rooms. Each hands one type on to the next.
//! 1. `measure` → `Observation`s and the plane's `Scale`.
//!    * Nodes of all views, in an order that depends on the measurements alone, with direction,
//!      error and weight. Weights fall towards open ends, where real scanners overshoot.
//!    * The spread between views sets the overlap threshold. The views' systematic errors, which
//!      grow with the incidence, are part of all weights.
//!    * Where these errors exceed a third of a footprint, the views' curves move onto a common
//!      course. A view counts in it by its errors there, which may go with its noise.
//! 2. `estimate` → `PlacedNode`s.
//!    * Groups of observations beside each other; rough fits treat a group as one.
//!    * Thinning: best supported first, a group moves across the curve onto a robust line through
//!      its neighbours, and absorbs what lies beside it. The neighbours never move, so nothing
//!      drifts.
//!    * Clusters: each node takes the weighted mean of the *original* places it absorbed.
//!    * Final place: a robust parabola or arc, in the widest window that agrees with all narrower
//!      ones.
//! 3. `connect` → `Chain`s.
//!    * Links: cheapest first, one successor and one predecessor. The views' own curves suggest
//!      links. No link crosses ground in the shadow of a view (`ground.rs`).
//!    * Cover: longest chain first; what lies beside an accepted chain is cut away.
//!    * Ends: joined where they meet and where the curve goes on, turned round thin tips, cut back
//!      where they cross. Gaps are counted in samples of the coarsest view there. Short chains
//!      that only one view measured are left out, and open ones beside a closed chain (`spurs.rs`).
//!      Nodes that run backwards within their noise are left out, too (`hooks.rs`).
//! 4. `shape` → curves.
//!    * Rings: closed chains that cannot be told from a circle become one.
//!    * Corners: where two sides meet at an angle, the curve goes through the place at which they
//!      do.
//!
//! Last, [`consensus`] leaves out units that cross better ones (`planar.rs`).
//!
//! **Departures from the source.** Everything from the groups on replaces 5.5.2. The rule table of
//! 5.4 holds for the result as an invariant instead of deciding each merge.
//!
//! **Cost.** Each step gathers neighbours from a grid. Measuring, aligning (some rounds), grouping,
//! clustering and looking for witnesses of links visit every observation. All other steps visit
//! groups or nodes, whose number depends on the length of the result, not on the number of views.
//!
//! **Limits.** Poses must be right within the overlap threshold: fusion cannot repair registration.

mod connect;
mod estimate;
pub(crate) mod measure;
mod options;
mod shape;
mod steps;
mod tuning;
mod window;

pub use options::{ConsensusOptions, Steps};
pub use steps::{ChainStep, ConsensusSteps, NodeStep, ObservationStep};

use crate::fused_plane::{FusedPlane, FusionCounts, longest_first};
use crate::ground::Ground;
use crate::planar::{Shortest, without_crossings};
use connect::Chains;
use estimate::Estimate;
use measure::{Measurements, Observations};
use transect_geometry::Curve;

/// The errors of the views of a plane, as the views show them, in the length unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Standard deviation of one view's curve against the common one.
    pub spread: f64,
    /// Overlap threshold.
    pub threshold: f64,
    /// Median footprint.
    pub spacing: f64,
}

/// The errors of the views as [`consensus`] measures them; `None` without nodes.
pub fn measure(views: &[&[Curve]], options: &ConsensusOptions) -> Option<Measured> {
    let observations = Observations::collect(views, &options.steps);
    let Measurements { scale, spread, .. } = Measurements::new(observations, options)?;
    Some(Measured { spread, threshold: scale.threshold, spacing: scale.spacing })
}

/// Fuses the curves of one plane; one slice of curves per view, in any order.
///
/// All curves are in one coordinate system of the plane, in one length unit, and have the solid on
/// their left. So have those of the result. Views without nodes give a plane without curves.
///
/// ```
/// use transect_fusion::{ConsensusOptions, consensus};
/// use transect_geometry::{Curve, Node, Point2};
///
/// // Two views of one wall, 4 mm apart, overlapping from 4 m to 6 m.
/// let wall = |from: i32, to: i32, y: f64| {
///     let node = |k| Node::at(Point2::new(0.1 * f64::from(k), y)).with_footprint(0.1);
///     Curve::new((from..=to).map(node).collect(), false).map(|curve| vec![curve])
/// };
/// let (left, right) = (wall(0, 60, 0.0)?, wall(40, 90, 0.004)?);
/// let plane = consensus(&[&left, &right], &ConsensusOptions::default());
///
/// assert_eq!(plane.curves.len(), 1);
/// assert!(plane.curves[0].length() > 8.9);
/// assert!(plane.spread < 0.005);
/// # Ok::<(), transect_geometry::CurveError>(())
/// ```
pub fn consensus(views: &[&[Curve]], options: &ConsensusOptions) -> FusedPlane {
    fuse(views, options, |_, _, _| ())
}

/// Fuses as [`consensus`] does, and also returns the observations, the nodes and the chains.
pub fn consensus_steps(
    views: &[&[Curve]],
    options: &ConsensusOptions,
) -> (FusedPlane, ConsensusSteps) {
    let mut steps = ConsensusSteps::default();
    let plane = fuse(views, options, |measured, estimate, chains| {
        steps = ConsensusSteps::new(measured, estimate, chains);
    });
    (plane, steps)
}

/// Fuses the curves of all views; `watch` gets what the first three rooms handed on.
fn fuse(
    views: &[&[Curve]],
    options: &ConsensusOptions,
    watch: impl FnOnce(&Measurements, &Estimate, &[connect::Chain]),
) -> FusedPlane {
    let nodes = views.iter().copied().flatten().map(|curve| curve.nodes().len()).sum();
    let observations = Observations::collect(views, &options.steps);
    let Some(measured) = Measurements::new(observations, options) else {
        let counts = FusionCounts { observations: nodes, ..FusionCounts::default() };
        return FusedPlane { counts, ..FusedPlane::default() };
    };
    let mut estimate = Estimate::new(&measured);
    let ground = Ground::new(&measured.observations, &measured.grid);
    let Chains { chains, dropped } = connect::connect(&mut estimate, &measured, &ground);
    watch(&measured, &estimate, &chains);
    let (curves, refused) = shape::shape(estimate, chains, &measured, &ground);
    let dropped = dropped + refused;
    let unknown = measured.scale.spacing;
    let shortest = Shortest { footprints: options.shortest_footprints, unknown };
    let (mut curves, crossings) = without_crossings(curves, shortest);
    curves.sort_by(longest_first);
    FusedPlane {
        curves,
        spread: measured.spread,
        view_error: measured.view_error,
        sigma_is_noise_alone: measured.observations.err_by_noise_alone(),
        noise: measured.noise,
        threshold: measured.scale.threshold,
        counts: FusionCounts { observations: nodes, dropped, crossings },
        growth: None,
    }
}
