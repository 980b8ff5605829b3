//! How far apart the views are: the measured spread that sets the overlap threshold.
//!
//! The distance from a node to the curve of *one randomly drawn* other view is a fair sample of the
//! difference between two views. The distance to the nearest of all other views would be too small,
//! by a factor that grows with the number of views.

use super::super::options::ConsensusOptions;
use super::super::tuning::spread::*;
use super::observations::{Observation, Observations, median};
use super::view_error::{Pair, ViewError};
use crate::grid::PointGrid;

/// Spread between views, in the length unit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spread {
    /// Standard deviation of one view's curve against the common one, with the registration error.
    pub between_views: f64,
    /// The part of it that the nodes' own errors do not explain.
    pub view_error: ViewError,
}

/// How far from a node another curve is searched for.
pub(super) fn search_distance(here: &Observation) -> f64 {
    SEARCH_FOOTPRINTS * here.footprint + SEARCH_SIGMAS * here.sigma
}

/// What the search for other views needs.
pub(super) struct Search<'a> {
    observations: &'a Observations,
    /// The view of each observation: most that lie around a node are told by it alone.
    views: Vec<u32>,
    grid: &'a PointGrid,
    options: &'a ConsensusOptions,
}

impl<'a> Search<'a> {
    pub fn new(
        observations: &'a Observations,
        grid: &'a PointGrid,
        options: &'a ConsensusOptions,
    ) -> Self {
        let views = observations.all.iter().map(|o| o.view).collect();
        Self { observations, views, grid, options }
    }

    /// The spread between views; `None` where no two views overlap.
    ///
    /// The search begins nearby, since views usually lie close to each other. It grows until the
    /// spread lies well inside. If the spread grows as fast as the search, other surfaces make it,
    /// and the usual distance counts.
    pub fn spread_between_views(&self) -> Option<Spread> {
        if self.observations.sources.len() < 2 {
            return None;
        }
        let nearby = self.options.steps.nearby_spread.then(|| self.within(NEARBY_SHARE)).flatten();
        if let Some(nearby) = nearby.filter(|found| self.holds(found, NEARBY_SHARE)) {
            return Some(nearby);
        }
        let usual = self.within(1.0)?;
        // Only curves that will be moved onto each other may be farther apart.
        let widest = if self.options.steps.settle { WIDEST_SHARE } else { 1.0 };
        let (mut share, mut found) = (1.0, usual);
        while !self.holds(&found, share) && share < widest {
            share *= SHARE_GROWTH;
            found = self.within(share)?;
        }
        let evenly = found.between_views > EVEN_GROWTH * share * usual.between_views;
        Some(if share > 1.0 && evenly { usual } else { found })
    }

    /// Whether a spread lies well within the share of the search distance that showed it.
    fn holds(&self, found: &Spread, share: f64) -> bool {
        let searched = share * SEARCH_FOOTPRINTS * self.observations.spacing();
        NEARBY_SPREADS * found.between_views <= searched
    }

    /// The spread within a share of the search distance.
    fn within(&self, share: f64) -> Option<Spread> {
        let count = self.observations.all.len();
        let step = count.div_ceil(WANTED_SAMPLES).max(SAMPLE_EVERY);
        let step = step.min(count.div_ceil(MIN_SAMPLES));
        // One node anywhere in each stretch. At a fixed place, views with as many nodes each would
        // all be sampled at one place of the section.
        let anywhere = |first: usize| first + (mixed(first as u64) % step as u64) as usize;
        let samples = (0..count).step_by(step).map(anywhere).filter(|k| *k < count);
        let mut pairs: Vec<Pair> =
            samples.filter_map(|k| self.pair_with_another_view(k, share)).collect();
        if pairs.len() < MIN_PAIRS {
            return None;
        }
        // The sample holds pairs of different surfaces; a shrinking cut removes them.
        for _ in 0..3 {
            let spread = median(pairs.iter().map(|p| p.distance)) / MEDIAN_OF_NORMAL;
            pairs.retain(|p| p.distance <= CUT_SPREADS * spread);
        }
        let between_two = median(pairs.iter().map(|p| p.distance)) / MEDIAN_OF_NORMAL;
        let between_views = between_two / std::f64::consts::SQRT_2;
        Some(Spread { between_views, view_error: ViewError::of(&pairs, between_views) })
    }

    /// The distance across the curve to one other view, drawn from those that measured this place.
    ///
    /// Of that view's nodes the one counts that lies most nearly beside: the nearest one would be
    /// near across the curve too.
    fn pair_with_another_view(&self, k: usize, share: f64) -> Option<Pair> {
        let here = &self.observations.all[k];
        let same_way = self.options.direction_limit_rad.cos();
        // The view with the lowest number is drawn. The node's own has none.
        let number = |view: u32| mixed((k as u64) << 32 | u64::from(view));
        let views = 0..self.observations.sources.len() as u32;
        let numbers: Vec<Option<u64>> =
            views.map(|view| (view != here.view).then(|| number(view))).collect();
        let (mut drawn, mut along, mut pair) = (u64::MAX, f64::INFINITY, None);
        self.grid.within(&here.position, share * search_distance(here), |j, d| {
            let Some(number) = numbers[self.views[j] as usize].filter(|n| *n <= drawn) else {
                return;
            };
            let there = &self.observations.all[j];
            if there.tangent.dot(&here.tangent) < same_way {
                return;
            }
            let how_far = d.dot(&there.tangent).abs();
            let distance = there.tangent.perp(&d).abs();
            if (number, how_far) < (drawn, along) {
                (drawn, along) = (number, how_far);
                pair = Some(self.pair(here, there, distance));
            }
        });
        pair
    }

    fn pair(&self, here: &Observation, there: &Observation, distance: f64) -> Pair {
        let by_incidence = self.options.steps.incidence_error;
        let squared_tangents = here.squared_tangent() + there.squared_tangent();
        Pair {
            distance,
            variance: here.sigma.powi(2) + there.sigma.powi(2),
            squared_tangents: if by_incidence { squared_tangents } else { 0.0 },
        }
    }
}

/// A number without relation to its neighbours (the finaliser of SplitMix64).
fn mixed(k: u64) -> u64 {
    let k = k.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let k = (k ^ (k >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let k = (k ^ (k >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    k ^ (k >> 31)
}
