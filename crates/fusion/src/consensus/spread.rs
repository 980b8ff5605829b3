//! How far apart the views are: the measured spread that sets the overlap threshold.
//!
//! The distance from a node to the curve of *one randomly drawn* other view is a fair sample of the
//! difference between two views. The nearest of all other views would read too low by a factor that
//! grows with the number of views.

use super::observations::{Observations, median};
use crate::grid::PointGrid;

/// Nodes looked at: the median of this many is good to a few percent, and of more than this share of
/// all nodes to no less, as neighbours say the same.
const SAMPLES: usize = 1000;
const LEAST_STEP: usize = 12;

/// So few nodes are all looked at.
const FEW: usize = 300;

/// Fewest distances that make a spread.
const FEWEST_SAMPLES: usize = 8;

/// How far another view is looked for, in footprints and standard deviations of the node.
const SEARCH_FOOTPRINTS: f64 = 4.0;
const SEARCH_SIGMAS: f64 = 6.0;

/// Share of that distance looked at first.
const NEARBY: f64 = 0.4;

/// Median of |x| for a normal x of standard deviation 1.
const MEDIAN_OF_NORMAL: f64 = 0.6745;

/// Spread between views, in the length unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread {
    /// Standard deviation of one view's curve against the common one, registration included.
    pub between: f64,
    /// The part of it that the nodes' own errors do not explain: what a view's neighbouring nodes err
    /// by in common (random effects model).
    pub common: f64,
}

/// The spread between views; `None` where no two views overlap.
pub(super) fn between_views(
    observations: &Observations,
    grid: &PointGrid,
    same_way: f64,
) -> Option<Spread> {
    if observations.sources.len() < 2 {
        return None;
    }
    let count = observations.all.len();
    let least = if count > FEW { LEAST_STEP } else { 1 };
    let step = count.div_ceil(SAMPLES).max(least);
    let samples = (0..observations.all.len()).step_by(step);
    let mut pairs: Vec<Pair> =
        samples.filter_map(|k| distance_to_other(observations, grid, k, same_way)).collect();
    if pairs.len() < FEWEST_SAMPLES {
        return None;
    }
    // Pairs of different surfaces are in the sample; a shrinking cut leaves them behind.
    for _ in 0..3 {
        let spread = median(pairs.iter().map(|p| p.distance)) / MEDIAN_OF_NORMAL;
        pairs.retain(|p| p.distance <= 4.0 * spread);
    }
    let between = median(pairs.iter().map(|p| p.distance)) / MEDIAN_OF_NORMAL;
    let between = between / std::f64::consts::SQRT_2;
    let own = 0.5 * median(pairs.iter().map(|p| p.variance));
    Some(Spread { between, common: (between * between - own).max(0.0).sqrt() })
}

/// Two nodes of different views beside each other.
#[derive(Debug, Clone, Copy)]
struct Pair {
    /// Across the curve.
    distance: f64,
    /// Sum of the variances of both by their own errors.
    variance: f64,
}

/// Distance across the curve to one other view, drawn by the node's number, at its node that lies
/// most nearly beside: the nearest one would be near across the curve too, and read too low.
fn distance_to_other(o: &Observations, grid: &PointGrid, k: usize, same_way: f64) -> Option<Pair> {
    let here = &o.all[k];
    let others = o.sources.len() as u64 - 1;
    let drawn = (here.view as u64 + 1 + mixed(k as u64) % others) % o.sources.len() as u64;
    let radius = SEARCH_FOOTPRINTS * here.footprint + SEARCH_SIGMAS * here.sigma;
    // A node within half a footprint of the place beside is the one, as a rule soon found.
    let close = beside(o, grid, (k, drawn as u32), (NEARBY * radius, same_way));
    let found = match close {
        Some((along, pair)) if along <= 0.5 * here.footprint => Some((along, pair)),
        _ => beside(o, grid, (k, drawn as u32), (radius, same_way)),
    };
    found.map(|(_, pair)| pair)
}

/// The node of a view within a radius that lies most nearly beside another one, and how far along.
fn beside(
    o: &Observations,
    grid: &PointGrid,
    (k, view): (usize, u32),
    (radius, same_way): (f64, f64),
) -> Option<(f64, Pair)> {
    let here = &o.all[k];
    let mut nearest: Option<(f64, Pair)> = None;
    grid.within(&here.position, radius, |j, d| {
        let there = &o.all[j];
        if there.view == view && there.tangent.dot(&here.tangent) >= same_way {
            let along = d.dot(&there.tangent).abs();
            if nearest.is_none_or(|(n, _)| along < n) {
                let variance = here.sigma.powi(2) + there.sigma.powi(2);
                let distance = there.tangent.perp(&d).abs();
                nearest = Some((along, Pair { distance, variance }));
            }
        }
    });
    nearest
}

/// A number without relation to its neighbours (the finaliser of SplitMix64).
fn mixed(k: u64) -> u64 {
    let k = k.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let k = (k ^ (k >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let k = (k ^ (k >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    k ^ (k >> 31)
}
