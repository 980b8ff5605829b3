//! The curves of all views at once: the default way to fuse a plane.
//!
//! **Problem.** Several views saw parts of the same section. Wanted: one curve where they overlap,
//! more accurate than any single one; no duplicate, no fork, nothing invented, both sides of a thin
//! sheet, and the same result for any order of views.
//!
//! **Idea.** The dissertation merges curves two by two (5.2 to 5.5). Every merge moves the curve a
//! little, so errors add up and the last view weighs as much as all before it. Here every view
//! stays as it was seen, and the common curve is estimated from all of them in one go. Direction
//! tells neighbouring surfaces apart, as in Figure 5.5.
//!
//! **Steps.**
//! 1. Observations: nodes of all views in an order that depends on what was seen alone, with
//!    direction, and with weights that fall towards open ends, where real scanners overshoot.
//! 2. Spread between views, measured; it sets the overlap threshold. Where one view saw two surfaces side by
//!    side, half the gap between them bounds it. What a view's nodes err by in common, the more the more
//!    obliquely they saw a surface, is part of all weights.
//! 3. Groups of observations beside each other; one place stands for all of a group in rough fits.
//! 4. Thinning: best supported first, a group moves, across the curve, onto a robust line through its
//!    neighbours, and absorbs what lies beside it. The neighbours never move, so nothing drifts.
//!    What was absorbed before its turn needs no line: only every third to sixth group gets one.
//! 5. Clusters: each kept node takes the weighted mean of the *original* places it absorbed. Members
//!    of one view that share their errors count as fewer.
//! 6. Final place: a robust parabola or arc, its window the widest that agrees with all narrower ones.
//! 7. Links: shortest first, one successor and one predecessor; the views' own curves are asked, and their
//!    open ends trusted least.
//! 8. Cover: longest piece first, what lies beside an accepted piece is cut away.
//! 9. Ends: joined where they meet and where the curve goes on, turned round thin tips, cut back where they
//!    cross. Gaps count in samples of the coarsest view there; what was seen too little is left out.
//! 10. Rings: closed curves that nothing tells from a circle become one.
//! 11. Corners: where two sides meet at an angle, the curve goes through the place at which they do.
//!
//! **Departures from the source.** Everything from step 3 on replaces 5.5.2. The rule table of 5.4
//! holds for the result as an invariant instead of deciding each merge.
//!
//! **Cost.** Each step gathers neighbours from a grid. All of them work on groups or on what is kept,
//! whose number depends on the length of the result, not on the number of views; every observation
//! is only grouped and added to its cluster. Open ends are found through a grid as well. Not for
//! views whose poses are wrong by more than the overlap threshold: it cannot repair registration.

mod arc;
mod common;
mod corners;
mod ends;
mod fit;
mod groups;
mod layers;
mod link;
pub(crate) mod observations;
mod output;
mod parabola;
mod pieces;
mod place;
mod rings;
mod spread;
mod steps;
mod thin;
mod window;

use crate::grid::PointGrid;
use crate::{FusedPlane, FusionCounts};
use common::Common;
use nalgebra::Vector3;
use observations::{Observations, median};
use pieces::{Piece, Shortest};
use serde::{Deserialize, Serialize};
use spread::Spread;
pub use steps::Steps;
use transect_geometry::{Curve, Node, Point2, Vector2};

/// What can be set. Nothing is in the user's unit: lengths follow from measured spreads and
/// footprints.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ConsensusOptions {
    /// Overlap threshold in measured spreads between views. Two curves of the same direction that
    /// lie closer than this are one surface.
    pub threshold_spreads: f64,
    /// Largest angle between the directions of two observations of one surface, in radians.
    pub direction_limit_rad: f64,
    /// Shortest curve that is kept, in footprints that were seen: gaps do not count.
    pub shortest_footprints: f64,
    /// Steps to leave out, to measure what they are worth.
    #[doc(hidden)]
    #[serde(skip)]
    pub steps: Steps,
}

impl Default for ConsensusOptions {
    fn default() -> Self {
        Self {
            threshold_spreads: 8.0,
            direction_limit_rad: 50_f64.to_radians(),
            shortest_footprints: 4.0,
            steps: Steps::ALL,
        }
    }
}

/// Lengths of a plane that the steps share.
#[derive(Debug, Clone, Copy)]
struct Scale {
    /// Median footprint.
    spacing: f64,
    /// Overlap threshold across the curve.
    threshold: f64,
    /// The same in standard deviations of what it follows from.
    threshold_spreads: f64,
    /// Cosine of the largest angle between observations of one surface.
    same_way: f64,
    steps: Steps,
}

impl Scale {
    /// Smallest threshold in standard deviations of the node, and in footprints.
    const SIGMAS: f64 = 4.0;
    const FOOTPRINTS: f64 = 0.35;

    /// Smallest room of a layer that counts, in spreads between views. Where views differ by as much as
    /// all the room they read 1.9, however far apart they are.
    const ROOM_SPREADS: f64 = 2.2;

    fn new(
        observations: &mut Observations,
        grid: &PointGrid,
        options: &ConsensusOptions,
    ) -> (Self, Spread) {
        let spacing = observations.spacing();
        let sigma = median(observations.all.iter().map(|o| o.sigma));
        let same_way = options.direction_limit_rad.cos();
        // One view says nothing about the spread between views; its own error is all there is.
        let spread = |o: &Observations| {
            spread::between_views(o, grid, (spacing, options.steps), same_way)
                .unwrap_or(Spread { between: sigma, common: Common::default() })
        };
        if options.steps.layers {
            observations.rooms = layers::rooms(observations, same_way);
        }
        let mut measured = spread(observations);
        if layers::doubt(&mut observations.rooms, Self::ROOM_SPREADS * measured.between) {
            measured = spread(observations);
        }
        let least = (Self::SIGMAS * sigma).max(Self::FOOTPRINTS * spacing);
        let threshold_spreads = options.threshold_spreads;
        let threshold = (threshold_spreads * measured.between).max(least);
        (Self { spacing, threshold, threshold_spreads, same_way, steps: options.steps }, measured)
    }

    /// How far off a node may be that few views saw: the overlap threshold, more where they err by more.
    fn astray(&self, node: &Kept) -> f64 {
        self.threshold.max(self.threshold_spreads * node.common_variance.sqrt())
    }

    /// Overlap threshold for a node: wider where its own error is larger, and no wider than its room.
    fn across(&self, sigma: f64, room: f64) -> f64 {
        self.threshold.max(Self::SIGMAS * sigma).min(room)
    }
}

/// A node of the result, on its way.
#[derive(Debug, Clone, Copy)]
struct Kept {
    position: Point2,
    tangent: Vector2,
    sigma: f64,
    footprint: f64,
    /// Footprint of the coarsest node whose sample this one lies within: a gap no longer than that is
    /// none.
    spacing: f64,
    /// Half the gap to the next layer of the same direction.
    room: f64,
    /// Weighted mean of the original places of what this node absorbed.
    cluster: Point2,
    cluster_sigma: f64,
    /// Variance along the curve of the places in the cluster.
    along_variance: f64,
    weight: f64,
    /// Sum of the credits of what this node absorbed.
    credit: f64,
    views: u32,
    /// Variance of what its views err by in common.
    common_variance: f64,
    /// Length along the curve over which it shares its error with its neighbours.
    correlation: f64,
    /// Outward unit normal of the surface, or zero.
    normal: Vector3<f32>,
}

impl Kept {
    fn new(position: Point2, tangent: Vector2, footprint: f64) -> Self {
        let (cluster, sigma) = (position, 0.0);
        Self {
            position,
            tangent,
            sigma,
            footprint,
            spacing: footprint,
            room: f64::INFINITY,
            cluster,
            cluster_sigma: sigma,
            along_variance: 0.0,
            weight: 0.0,
            credit: 0.0,
            views: 0,
            common_variance: 0.0,
            correlation: 0.0,
            normal: Vector3::zeros(),
        }
    }

    fn node(&self) -> Node {
        Node::at(self.position)
            .with_sigma(self.sigma as f32)
            .with_footprint(self.footprint as f32)
            .with_weight(self.credit as f32)
            .with_views(self.views)
            .with_correlation(self.correlation as f32)
            .with_normal(Some(self.normal).filter(|normal| *normal != Vector3::zeros()))
    }
}

/// What the views of a plane say about their own errors, in the length unit.
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
    let mut observations = Observations::collect(views, &options.steps);
    if observations.all.is_empty() {
        return None;
    }
    let grid = PointGrid::new(&observations.positions(), observations.spacing());
    let (scale, spread) = Scale::new(&mut observations, &grid, options);
    Some(Measured { spread: spread.between, threshold: scale.threshold, spacing: scale.spacing })
}

/// Fuses the curves of one plane; one slice of curves per view, in any order.
pub fn consensus(views: &[&[Curve]], options: &ConsensusOptions) -> FusedPlane {
    fuse(Observations::collect(views, &options.steps), options)
}

/// The same from what was collected of the views.
pub(crate) fn fuse(mut observations: Observations, options: &ConsensusOptions) -> FusedPlane {
    if observations.all.is_empty() {
        return FusedPlane::default();
    }
    let grid = PointGrid::new(&observations.positions(), observations.spacing());
    let (scale, spread) = Scale::new(&mut observations, &grid, options);
    if options.steps.view_error {
        observations.weigh(&spread.common);
    }
    let mut thinned = thin::thin(&observations, &grid, &scale);
    place::place(&mut thinned.kept, &scale);
    if options.steps.spread_spacing {
        link::spread_spacing(&mut thinned.kept, &scale);
    }
    let next = link::link(&thinned.kept, &thinned.absorbed_by, &observations, &scale);
    let traced = pieces::trace(&next);
    let (mut tidied, dropped) = tidy(&thinned.kept, traced, &scale, options);
    let counts = FusionCounts {
        observations: observations.all.len(),
        kept: thinned.kept.len(),
        dropped,
        ..FusionCounts::default()
    };
    let kept = &mut thinned.kept;
    if options.steps.rings {
        rings::round(kept, &mut tidied);
    }
    if options.steps.corners {
        corners::sharpen(kept, &mut tidied, observations.pixel_noise(), &options.steps);
    }
    let ends = output::Ends::new(&observations, &thinned.absorbed_by, kept);
    let curves = output::curves(kept, tidied, &ends, options.steps.middle_nodes);
    FusedPlane { curves, spread: spread.between, threshold: scale.threshold, counts }
}

/// Covers, joins and cuts ends until pieces are curves.
fn tidy(
    kept: &[Kept],
    traced: Vec<Piece>,
    scale: &Scale,
    options: &ConsensusOptions,
) -> (Vec<Piece>, usize) {
    let (covered, mut dropped) = pieces::cover(kept, traced, scale, Shortest::PART);
    let mut pieces = covered;
    let st = &options.steps;
    let on = [st.join_meeting, st.join_smooth, st.join_hairpin, st.join_crossing];
    for (rule, _) in ends::RULES.into_iter().zip(on).filter(|r| r.1) {
        pieces = ends::join(kept, pieces, scale, &rule);
    }
    // What joining made longer may lie beside others, and what stayed short is no curve.
    let (pieces, short) = if st.second_cover {
        pieces::cover(kept, pieces, scale, Shortest::curve(options.shortest_footprints))
    } else {
        (
            pieces
                .into_iter()
                .filter(|p| p.nodes.len() >= 3 && p.footprints(kept) >= options.shortest_footprints)
                .collect(),
            0,
        )
    };
    let (pieces, spurs) =
        if st.spurs { pieces::without_spurs(kept, pieces, scale) } else { (pieces, 0) };
    dropped += short + spurs;
    let mut pieces = pieces;
    for piece in &mut pieces {
        let before = piece.nodes.len();
        pieces::straighten(kept, piece, st);
        dropped += before - piece.nodes.len();
    }
    let all: usize = pieces.iter().map(|p| p.nodes.len()).sum();
    pieces.retain(|p| !st.direction || p.has_direction(kept));
    let left: usize = pieces.iter().map(|p| p.nodes.len()).sum();
    (pieces, dropped + all - left)
}
