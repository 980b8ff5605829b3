//! How far apart the views are: the measured spread that sets the overlap threshold.
//!
//! The distance from a node to the curve of *one randomly drawn* other view is a fair sample of the
//! difference between two views. The distance to the nearest of all other views would be too small,
//! by a factor that grows with the number of views.

use super::super::options::{ConsensusOptions, Steps};
use super::super::tuning::spread::*;
use super::observations::{Observation, Observations, median};
use super::view_error::{Pair, ViewError};
use crate::grid::PointGrid;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use transect_geometry::{Envelope, Point2};

/// Spread between views, in the length unit.
#[derive(Debug, Clone)]
pub(crate) struct Spread {
    /// Standard deviation of one view's curve against the common one, with the registration error.
    pub between_views: f64,
    /// The pairs of nodes that show it.
    pub pairs: Vec<Pair>,
}

impl Spread {
    /// The part that the nodes' own errors do not explain; 0 of a single view. `with_noise`:
    /// whether a part of it may go with the noise.
    pub fn view_error(&self, with_noise: bool, steps: &Steps) -> ViewError {
        if self.pairs.is_empty() {
            return ViewError::default();
        }
        let sought = [true, with_noise, steps.incidence_error];
        ViewError::of(&self.pairs, self.between_views, sought)
    }
}

/// How far from a node another curve is searched for.
pub(super) fn search_distance(here: &Observation) -> f64 {
    SEARCH_FOOTPRINTS * here.footprint + SEARCH_SIGMAS * here.sigma
}

/// The observations of one view, which follow each other.
struct OfView {
    view: u32,
    first: usize,
    grid: PointGrid,
    /// The rectangle that its observations fill.
    around: Option<Envelope>,
}

impl OfView {
    /// Whether an observation can be within a distance of a place. Rounding is far smaller than the
    /// part that is added.
    fn reaches(&self, place: &Point2, distance: f64) -> bool {
        self.around.is_some_and(|around| around.grown(1.001 * distance).contains(place))
    }
}

/// The inputs of the search for other views.
pub(super) struct Search<'a> {
    observations: &'a Observations,
    views: Vec<OfView>,
    options: &'a ConsensusOptions,
}

impl<'a> Search<'a> {
    pub fn new(observations: &'a Observations, options: &'a ConsensusOptions) -> Self {
        let mut first = 0;
        let views = observations.all.chunk_by(|a, b| a.view == b.view).map(|seen| {
            let places: Vec<Point2> = seen.iter().map(|o| o.position).collect();
            let cell = SEARCH_FOOTPRINTS * observations.spacing();
            let grid = PointGrid::new(&places, cell);
            let around = Envelope::around(&places);
            let of_view = OfView { view: seen[0].view, first, grid, around };
            first += seen.len();
            of_view
        });
        Self { observations, views: views.collect(), options }
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
        let (mut share, mut found) = (1.0, usual.clone());
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
        Some(Spread { between_views: between_two / std::f64::consts::SQRT_2, pairs })
    }

    /// The distance across the curve to one other view, drawn from those that measured this place:
    /// the one with the lowest number.
    fn pair_with_another_view(&self, k: usize, share: f64) -> Option<Pair> {
        let here = &self.observations.all[k];
        let (place, reach) = (here.position, share * search_distance(here));
        let number = |of: &OfView| mixed((k as u64) << 32 | u64::from(of.view));
        let others = self.views.iter().enumerate();
        let others = others.filter(|(_, of)| of.view != here.view && of.reaches(&place, reach));
        let mut drawn: BinaryHeap<Reverse<(u64, usize)>> =
            others.map(|(at, of)| Reverse((number(of), at))).collect();
        std::iter::from_fn(|| drawn.pop())
            .find_map(|Reverse((_, at))| self.pair_with(&self.views[at], k, share))
    }

    /// The distance to a view; `None` where it did not measure the place.
    ///
    /// Of the view's nodes the one counts that lies most nearly beside: the nearest one would be
    /// near across the curve too.
    fn pair_with(&self, view: &OfView, k: usize, share: f64) -> Option<Pair> {
        let here = &self.observations.all[k];
        let same_way = self.options.direction_limit_rad.cos();
        let (mut along, mut pair) = (f64::INFINITY, None);
        view.grid.within(&here.position, share * search_distance(here), |j, d| {
            let there = &self.observations.all[view.first + j];
            let how_far = d.dot(&there.tangent).abs();
            if how_far < along && there.tangent.dot(&here.tangent) >= same_way {
                along = how_far;
                pair = Some(Pair {
                    distance: there.tangent.perp(&d).abs(),
                    variance: here.sigma.powi(2) + there.sigma.powi(2),
                    squared_tangents: here.squared_tangent() + there.squared_tangent(),
                });
            }
        });
        pair
    }
}

/// A number without relation to its neighbours (the finaliser of SplitMix64).
fn mixed(k: u64) -> u64 {
    let k = k.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let k = (k ^ (k >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let k = (k ^ (k >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    k ^ (k >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_geometry::{Curve, Node};

    /// The pair that a search of all observations finds.
    fn slow(search: &Search<'_>, k: usize, share: f64) -> Option<f64> {
        let here = &search.observations.all[k];
        let reach = share * search_distance(here);
        let same_way = search.options.direction_limit_rad.cos();
        let near = search.observations.all.iter().filter(|there| {
            let is_near = (there.position - here.position).norm() <= reach;
            is_near && there.view != here.view && there.tangent.dot(&here.tangent) >= same_way
        });
        let number = |there: &Observation| mixed((k as u64) << 32 | u64::from(there.view));
        let along =
            |there: &Observation| (there.position - here.position).dot(&there.tangent).abs();
        let first =
            near.min_by(|a, b| number(a).cmp(&number(b)).then(along(a).total_cmp(&along(b))));
        first.map(|there| there.tangent.perp(&(there.position - here.position)).abs())
    }

    #[test]
    fn the_drawn_view_is_that_of_a_search_of_all_observations() {
        let arc = |view: u32| {
            let node = |k: u32| {
                let angle = 0.3 * f64::from(view) + 0.01 * f64::from(k);
                let radius = 1.0 + 0.004 * f64::from(view * 7 % 5) + 0.001 * f64::from(k * 13 % 7);
                Node::at(Point2::new(radius * angle.cos(), radius * angle.sin()))
                    .with_sigma(0.002)
                    .with_footprint(0.01)
            };
            vec![Curve::new((0..150).map(node).collect(), false).unwrap()]
        };
        let views: Vec<Vec<Curve>> = (0..12).map(arc).collect();
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        let options = ConsensusOptions::default();
        let observations = Observations::collect(&slices, &options.steps);
        let search = Search::new(&observations, &options);
        let mut found = [0; 2];
        for k in (0..observations.all.len()).step_by(7) {
            for share in [0.1, 0.4, 1.0, 5.0] {
                let pair = search.pair_with_another_view(k, share).map(|pair| pair.distance);
                assert_eq!(pair, slow(&search, k, share), "{k}, {share}");
                found[usize::from(pair.is_some())] += 1;
            }
        }
        assert!(found[0] > 50 && found[1] > 500, "{found:?}");
    }
}
