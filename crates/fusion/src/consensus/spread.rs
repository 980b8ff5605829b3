//! How far apart the views are: the measured spread that sets the overlap threshold.
//!
//! The distance from a node to the curve of *one randomly drawn* other view is a fair sample of the
//! difference between two views. The nearest of all other views would read too low by a factor that
//! grows with the number of views.

use super::common::{Common, Pair};
use super::observations::{Observation, Observations, median};
use crate::grid::PointGrid;

/// Nodes looked at: one of so many, as neighbours say the same, but the median of so few is off by more
/// than a tenth, and that of so many good to a few percent.
const STEP: usize = 20;
const FEW: usize = 300;
const MANY: usize = 500;

/// So many times more are looked at where there are layers: how many of them count depends on the spread.
const MORE: usize = 5;

/// Fewest distances that make a spread.
const FEWEST_SAMPLES: usize = 8;

/// How far another view is looked for, in footprints and standard deviations of the node.
const SEARCH_FOOTPRINTS: f64 = 4.0;
const SEARCH_SIGMAS: f64 = 6.0;

/// Share of that distance looked at first, and how many spreads it must hold.
const NEARBY: f64 = 0.4;
const RADIUS_SPREADS: f64 = 4.5;

/// Median of |x| for a normal x of standard deviation 1.
const MEDIAN_OF_NORMAL: f64 = 0.6745;

/// Spread between views, in the length unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread {
    /// Standard deviation of one view's curve against the common one, registration included.
    pub between: f64,
    /// The part of it that the nodes' own errors do not explain.
    pub common: Common,
}

/// The spread between views; `None` where no two views overlap.
pub(super) fn between_views(
    observations: &Observations,
    grid: &PointGrid,
    (spacing, steps): (f64, super::Steps),
    same_way: f64,
) -> Option<Spread> {
    if observations.sources.len() < 2 {
        return None;
    }
    // As a rule views lie so close to each other that a look nearby misses none of them.
    let near =
        if steps.nearby_spread { measure(observations, grid, NEARBY, same_way) } else { None };
    let all_seen = NEARBY * SEARCH_FOOTPRINTS * spacing;
    near.filter(|_| steps.nearby_spread)
        .filter(|s| RADIUS_SPREADS * s.between <= all_seen)
        .or_else(|| measure(observations, grid, 1.0, same_way))
}

/// The spread within a share of the search distance.
fn measure(o: &Observations, grid: &PointGrid, share: f64, same_way: f64) -> Option<Spread> {
    let count = o.all.len();
    let more = if o.rooms.is_empty() { 1 } else { MORE };
    let step = count.div_ceil(more * MANY).max(STEP / more).min(count.div_ceil(FEW));
    // One anywhere in each stretch: views with as many nodes each are not to be asked in one place.
    let anywhere = |first: usize| first + (mixed(first as u64) % step as u64) as usize;
    let samples = (0..count).step_by(step).map(anywhere).filter(|k| *k < count);
    let pair = |k| distance_to_other(o, grid, k, (share, same_way));
    let mut pairs: Vec<Pair> = samples.filter_map(pair).collect();
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
    Some(Spread { between, common: Common::of(&pairs, between) })
}

/// How far from a node another curve is looked for.
pub(super) fn search_distance(here: &Observation) -> f64 {
    SEARCH_FOOTPRINTS * here.footprint + SEARCH_SIGMAS * here.sigma
}

/// Distance across the curve to one other view, drawn from those that saw this place, at its node that
/// lies most nearly beside: the nearest one would be near across the curve too, and read too low.
fn distance_to_other(
    o: &Observations,
    grid: &PointGrid,
    k: usize,
    (share, same_way): (f64, f64),
) -> Option<Pair> {
    let here = &o.all[k];
    let radius = share * search_distance(here);
    let room = o.room(k);
    let (mut drawn, mut along, mut pair) = (u64::MAX, f64::INFINITY, None);
    grid.within(&here.position, radius, |j, d| {
        let there = &o.all[j];
        if there.view == here.view || there.tangent.dot(&here.tangent) < same_way {
            return;
        }
        // The view of the lowest number drawn is the one.
        let number = mixed((k as u64) << 32 | u64::from(there.view));
        if number > drawn {
            return;
        }
        let how_far = d.dot(&there.tangent).abs();
        let distance = there.tangent.perp(&d).abs();
        if (number, how_far) < (drawn, along) && distance <= room {
            (drawn, along) = (number, how_far);
            let variance = here.sigma.powi(2) + there.sigma.powi(2);
            let squared_tangents = here.tan_incidence.powi(2) + there.tan_incidence.powi(2);
            pair = Some(Pair { distance, variance, squared_tangents });
        }
    });
    pair
}

/// A number without relation to its neighbours (the finaliser of SplitMix64).
fn mixed(k: u64) -> u64 {
    let k = k.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let k = (k ^ (k >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let k = (k ^ (k >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    k ^ (k >> 31)
}
