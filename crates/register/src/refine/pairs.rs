//! Pairs of views that see the same surface, and what their observations weigh.

use super::camera::Cameras;
use super::observations::{Observation, Pieces, Reach, Sample, Scene, State};
use crate::tuning::{
    BLOCKS, FACETS_SHARE, LEAST_MEETINGS, MOST_REPRESENTED, OVERLAP_SAMPLES, PARTNERS,
    QUANTILE_SAMPLES,
};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BTreeSet;
use transect_device::{ImageSize, median};

/// The observations of an ordered pair of views.
#[derive(Debug, Clone)]
pub struct Pair {
    pub a: usize,
    pub b: usize,
    pub of: Pieces,
    pub observations: Vec<Observation>,
    /// Variance that the noise does not explain.
    pub excess: f64,
    /// Variance of the direction of a patch's normal about each axis across it, in rad².
    pub turned: f64,
}

/// The observations of a pair, or half of them.
#[derive(Debug, Clone, Copy)]
pub struct Portion<'a> {
    pub pair: &'a Pair,
    /// The half, and the cells of the view whose image is halved.
    pub half: Option<(usize, ImageSize)>,
}

impl<'a> From<&'a Pair> for Portion<'a> {
    fn from(pair: &'a Pair) -> Self {
        Self { pair, half: None }
    }
}

impl<'a> Portion<'a> {
    /// The observations: blocks of two colours, as on a chess board, make the two halves.
    ///
    /// Both directions of a pair see a surface, so the image of the same view halves both.
    pub fn observations(self) -> impl Iterator<Item = &'a Observation> {
        let side = usize::from(self.pair.a > self.pair.b);
        self.pair.observations.iter().filter(move |o| {
            self.half.is_none_or(|(half, size)| {
                let (row, col) = (o.cells[side] / size.cols, o.cells[side] % size.cols);
                (row * BLOCKS / size.rows + col * BLOCKS / size.cols) % 2 == half
            })
        })
    }
}

impl Scene<'_> {
    /// The ordered pairs of views that may overlap: of each view, those with most of its surface in
    /// common.
    pub fn pairs(&self, state: State<'_>, reach: Reach) -> Vec<(usize, usize)> {
        let n = self.views.len();
        let probes: Vec<Vec<Sample>> = (0..n)
            .into_par_iter()
            .map(|a| self.first_samples(a, Pieces::Patches, OVERLAP_SAMPLES, state.cameras))
            .collect();
        let common = |k: usize| {
            let (a, b) = (k % n, k / n);
            let Some(probes) = probes.get(a).filter(|_| a != b) else { return 0 };
            let met = self.observe(probes, (a, b), Pieces::Patches, state, reach).len();
            if met * 50 >= probes.len().max(50) { met } else { 0 }
        };
        let common: Vec<usize> = (0..n * n).into_par_iter().map(common).collect();
        let both = |a: usize, b: usize| common[b * n + a] + common[a * n + b];
        let partners = |a: usize| {
            let mut others: Vec<usize> = (0..n).filter(|&b| both(a, b) > 0).collect();
            others.sort_by_key(|&b| (Reverse(both(a, b)), b));
            others.into_iter().take(PARTNERS).collect()
        };
        let partners: Vec<BTreeSet<usize>> = (0..n).map(partners).collect();
        let all = (0..n * n).filter(|&k| common[k] > 0).map(|k| (k % n, k / n));
        all.filter(|(a, b)| partners[*a].contains(b) || partners[*b].contains(a)).collect()
    }

    /// The observations of the given pairs at the given poses.
    pub fn observe_all(
        &self,
        pairs: &[(usize, usize)],
        state: State<'_>,
        reach: Reach,
        most: usize,
        spread: Spread,
    ) -> Vec<Pair> {
        let wanted = [(Pieces::Patches, most), (Pieces::Facets, most / FACETS_SHARE)];
        let of_all = wanted.map(|of| self.observe_pieces(of, pairs, state, reach, spread));
        of_all.into_iter().flatten().collect()
    }

    /// The observations of patches or of facets alone, of so many samples of a view at most.
    pub fn observe_pieces(
        &self,
        (of, most): (Pieces, usize),
        pairs: &[(usize, usize)],
        state: State<'_>,
        reach: Reach,
        spread: Spread,
    ) -> Vec<Pair> {
        let first = |a| self.first_samples(a, of, most, state.cameras);
        let samples: Vec<Vec<Sample>> = (0..self.views.len()).into_par_iter().map(first).collect();
        let observe = |&(a, b): &(usize, usize)| {
            let samples = samples.get(a).map_or(&[][..], Vec::as_slice);
            let observations = self.observe(samples, (a, b), of, state, reach);
            let (excess, turned) = (excess(&observations, spread), turned(&observations));
            Pair { a, b, of, observations, excess, turned }
        };
        let pairs: Vec<Pair> = pairs.par_iter().map(observe).collect();
        let met = pairs.into_iter().filter(|p| p.observations.len() >= LEAST_MEETINGS);
        let mut pairs: Vec<Pair> = met.collect();
        // Pairs are in the order of their second view.
        let by_second = pairs.par_chunk_by_mut(|x, y| x.b == y.b);
        by_second.for_each(|seen_by_b| self.share(seen_by_b, of, most));
        pairs
    }

    /// Finds the share of each observation of one view's patches or facets.
    ///
    /// A surface that `k` views see gives `k (k - 1)` ordered pairs, whose squares add up to `k`
    /// times those of the views against their mean. So each counts as `1 / k`. Where two views
    /// alone hold the others together, they count most.
    ///
    /// With a limit on the samples, an observation represents several samples. Other observations
    /// of its surface count as often as they represent samples, so that `k` does not depend on the
    /// limit. The observation itself counts [`MOST_REPRESENTED`] times at most: its weight would
    /// fall with the square of the thinning otherwise.
    ///
    /// The facets of a cell share what a patch would count, as they are of one edge. Measured on
    /// twelve scans of parts: with a patch's share for each of them, poses err by a third more.
    fn share(&self, pairs: &mut [Pair], of: Pieces, most: usize) {
        let view = pairs.first().and_then(|pair| self.views.get(pair.b));
        let mut seen = vec![1.0; view.map_or(0, |view| view.size().pixels())];
        let each = |pair: &Pair| match of {
            Pieces::Patches => {
                self.samples.get(pair.a).map_or(1.0, |s| (s.len() as f64 / most as f64).max(1.0))
            }
            Pieces::Facets => 1.0,
        };
        for pair in pairs.iter() {
            for o in &pair.observations {
                if let Some(views) = seen.get_mut(o.cells[1]) {
                    *views += each(pair);
                }
            }
        }
        for pair in pairs {
            let each = each(pair);
            for o in &mut pair.observations {
                let others = seen.get(o.cells[1]).map_or(1.0, |views| views - each);
                o.share = 1.0 / (others + each.min(MOST_REPRESENTED));
            }
        }
    }
}

/// How the variance that noise leaves unexplained is found.
///
/// A displaced view contradicts another one on part of its surfaces only: on one wall of three if
/// it is shifted along that wall's normal. A median would take that wall for an outlier.
#[derive(Debug, Clone, Copy)]
pub enum Spread {
    /// From the 90 % quantile, while poses may be far off.
    Wide,
    /// From the median, once they have settled.
    Narrow,
}

impl Spread {
    /// A share, and the square of a normal variable of variance 1 below which that share lies.
    /// Theory.
    fn quantile(self) -> (f64, f64) {
        match self {
            Self::Wide => (0.9, 2.7055),
            Self::Narrow => (0.5, 0.4549),
        }
    }
}

/// The variance that the noise leaves unexplained: with it, the quantile of the squared distances
/// over their variances is that of a normal variable.
fn excess(observations: &[Observation], spread: Spread) -> f64 {
    // As many as tell a quantile to a few per cent.
    let step = observations.len().div_ceil(QUANTILE_SAMPLES).max(1);
    let observations: Vec<_> = observations.iter().step_by(step).collect();
    let (share, normal) = spread.quantile();
    let mut ratios: Vec<f64> = Vec::with_capacity(observations.len());
    let mut quantile = |excess: f64| {
        ratios.clear();
        ratios.extend(observations.iter().map(|o| o.distance.powi(2) / (o.variance + excess)));
        let at = (ratios.len() as f64 * share) as usize;
        if ratios.is_empty() { 0.0 } else { *ratios.select_nth_unstable_by(at, f64::total_cmp).1 }
    };
    if quantile(0.0) <= normal {
        return 0.0;
    }
    let largest = observations.iter().map(|o| o.distance.powi(2)).fold(0.0, f64::max);
    let (mut low, mut high) = (0.0, largest / normal);
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        if quantile(middle) > normal { low = middle } else { high = middle }
    }
    high
}

/// The variance of normals about each of two axes: the median of what observations show. It leaves
/// creases and other surfaces out.
fn turned(observations: &[Observation]) -> f64 {
    let step = observations.len().div_ceil(QUANTILE_SAMPLES).max(1);
    median(observations.iter().step_by(step).map(|o| f64::from(o.turned))).unwrap_or(0.0)
}

/// Tukey's constant, for 95 % efficiency with normal errors. Theory.
const BIWEIGHT: f64 = 4.685;

impl Pair {
    /// The weight of an observation: Tukey's biweight over the variance.
    pub fn weight(&self, o: &Observation) -> f64 {
        let variance = o.variance + self.excess;
        let share = o.distance.powi(2) / (BIWEIGHT.powi(2) * variance);
        if share < 1.0 { (1.0 - share).powi(2) / variance } else { 0.0 }
    }

    /// The slopes of an observation over the unknowns of the cameras that are free, and their
    /// number.
    pub fn camera_terms(&self, o: &Observation, cameras: &Cameras) -> ([(usize, f64); 14], usize) {
        let (mut terms, mut count) = ([(0, 0.0); 14], 0);
        for (side, view) in [self.a, self.b].into_iter().enumerate() {
            let Some(nodes) = cameras.nodes(view, o.cells[side]) else { continue };
            let slope = f64::from(o.slopes.change[side]);
            let depth = f64::from(o.slopes.depths[side]);
            let offsets = nodes.map(|(node, share)| (node, share * slope * depth));
            let scale = cameras.free_scale(&nodes).map(|unknown| (unknown, slope));
            let focal = cameras.free_focal(&nodes).into_iter().flatten();
            let focal = focal.zip(o.slopes.focal[side].map(f64::from));
            let all = offsets.into_iter().chain(scale).chain(focal).zip(&mut terms[count..]);
            count += all.map(|(from, to)| *to = from).count();
        }
        (terms, count)
    }
}
