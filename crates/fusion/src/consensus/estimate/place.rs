//! Final place of the nodes: a robust parabola, or arc, through the clusters around each.
//!
//! The window is the widest whose estimate differs from those of all narrower windows by no more
//! than random errors make it (Lepski's rule). It is wide along smooth curves and narrow at detail.
//! Errors that neighbours share leave narrow windows in agreement whatever their width. So the
//! *difference* is judged by its own standard deviation, not each estimate by its own.
//!
//! With a handful of windows, one of them differs by chance at every fifth node. So a single one is
//! passed over if the next wider one agrees again, and two in a row end the search. One of the two
//! narrowest may itself be off by chance.
//!
//! A parabola has an arc's second order. Fits follow the third and fourth too, as far as the bend
//! is known, so the error that is left comes from changes of the bend.

use super::super::measure::Scale;
use super::super::tuning::place::*;
use super::super::window::{Window, left_of};
use super::cluster::Cluster;
use super::fit::Fit;
use super::node::PlacedNode;
use super::parabola::{Limits, Sample, Windows};
use crate::grid::PointGrid;
use transect_geometry::Point2;

/// Places a node for every cluster; one without a fit stays on its rough line.
pub(super) fn place(clusters: &[Cluster], scale: &Scale) -> Vec<PlacedNode> {
    let mut near = Near::new(clusters, scale);
    clusters.iter().map(|here| placed(here, near.widest_fit(here))).collect()
}

fn placed(here: &Cluster, window: Option<WindowFit>) -> PlacedNode {
    let Cluster { position, tangent, correlation, evidence, .. } = *here;
    let sigma = |random: f64| (random.powi(2) + evidence.view_variance).sqrt();
    let spacing = evidence.footprint;
    let Some(WindowFit { fit, reach }) = window else {
        let sigma = sigma(evidence.random_sigma);
        return PlacedNode { position, tangent, sigma, correlation, spacing, evidence };
    };
    let normal = left_of(&tangent);
    PlacedNode {
        position: position + normal * fit.place,
        tangent: (tangent + normal * fit.slope).normalize(),
        sigma: sigma(fit.place_sigma),
        correlation: correlation.max(SHARED_WINDOW * reach),
        spacing,
        evidence,
    }
}

/// A fit and the half-width of its window.
#[derive(Debug, Clone, Copy)]
struct WindowFit {
    fit: Fit,
    reach: f64,
}

/// The error of a fit in the middle of a bend.
struct BendError {
    error: f64,
    /// Whether it does not matter: hidden by noise, or of a bend not known to be too strong.
    is_small: bool,
}

impl BendError {
    fn of(fit: &Fit, reach: f64, noisy_turns: bool) -> Self {
        let turn = 2.0 * fit.bend.abs() * reach;
        let sixth_order = (turn / SIXTH_ORDER_TURN).powi(2).min(1.0);
        let error = ARC_ERROR * sixth_order * turn.powi(3) * reach;
        let largest = if noisy_turns { LARGEST_NOISY_TURN } else { 0.0 };
        let hidden = turn <= largest && error <= ERROR_SHARE * fit.place_sigma;
        let known = turn - 4.0 * fit.bend_sigma * reach;
        Self { error, is_small: hidden || known <= LARGEST_WINDOW_TURN }
    }
}

/// Whether a fit agrees with those in narrower windows, of which one may be off by chance.
fn agrees(narrower: &[Fit], wide: &Fit, stray_windows: usize) -> bool {
    let mut strays = 0;
    narrower.iter().enumerate().all(|(step, narrow)| {
        let agrees = agree(narrow, wide, CONFIDENCE);
        strays += usize::from(!agrees);
        agrees || (strays == 1 && step < stray_windows && agree(narrow, wide, STRAY_CONFIDENCE))
    })
}

/// Whether a fit differs from one in a narrower window by at most so many standard deviations.
///
/// The wider window holds the samples of the narrower one. The errors of common samples cancel in
/// the difference, so its variance is that of the narrower fit less that of the wider.
fn agree(narrow: &Fit, wide: &Fit, confidence: f64) -> bool {
    let (before, after) = (narrow.place_sigma.powi(2), wide.place_sigma.powi(2));
    let variance = (before - after).max(LEAST_VARIANCE_SHARE * before);
    (wide.place - narrow.place).powi(2) <= confidence * confidence * variance
}

/// A neighbour in a node's own frame.
#[derive(Debug, Clone, Copy)]
struct Neighbour {
    number: u32,
    x: f64,
    y: f64,
}

/// The clusters around a node, gathered for several windows at once.
struct Near<'a> {
    clusters: &'a [Cluster],
    scale: &'a Scale,
    grid: PointGrid,
    /// How far along the curve clusters have been gathered.
    reach: f64,
    /// How many more nodes went beyond the first windows than did not.
    far: i32,
    /// In order along the curve.
    found: Vec<Neighbour>,
    windows: Windows,
    /// Fits in the windows accepted so far.
    narrower: Vec<Fit>,
}

impl<'a> Near<'a> {
    fn new(clusters: &'a [Cluster], scale: &'a Scale) -> Self {
        let places: Vec<Point2> = clusters.iter().map(|c| c.mean).collect();
        Self {
            clusters,
            scale,
            grid: PointGrid::new(&places, 2.0 * NARROWEST_FOOTPRINTS * scale.spacing),
            reach: 0.0,
            far: 0,
            found: Vec::new(),
            windows: Windows::new(*scale.steps()),
            narrower: Vec::new(),
        }
    }

    /// The fit in the widest window that agrees with all narrower ones.
    fn widest_fit(&mut self, here: &Cluster) -> Option<WindowFit> {
        let steps = *self.scale.steps();
        let stray_windows = if steps.stray_windows { STRAY_WINDOWS } else { 0 };
        let threshold = self.scale.across(here.evidence.random_sigma);
        let mut best: Option<WindowFit> = None;
        self.narrower.clear();
        self.reach = 0.0;
        let mut tried = 0;
        let mut passed = !steps.passed_window;
        for step in 0..WINDOWS {
            tried = step;
            let reach = half_width(here, step);
            self.gather_for(here, step, threshold);
            let limits = Limits { reach, across: across(threshold, reach), threshold };
            let Some(fit) = self.windows.fit(&limits) else {
                if best.is_none() {
                    continue;
                }
                break;
            };
            let agrees = agrees(&self.narrower, &fit, stray_windows);
            let bend = BendError::of(&fit, reach, steps.noisy_turns);
            let first_may = || steps.wide_first_window && bend.is_small && self.is_seen(&limits);
            match best {
                // A first fit across a gap would rest on far ground alone.
                None if step > LAST_FIRST_WINDOW && !first_may() => break,
                Some(_) if !bend.is_small || (!agrees && passed) => break,
                Some(_) if !agrees => {
                    passed = true;
                    continue;
                }
                _ => passed = !steps.passed_window,
            }
            self.narrower.push(fit);
            let place_sigma = fit.place_sigma.hypot(bend.error);
            best = Some(WindowFit { fit: Fit { place_sigma, ..fit }, reach });
        }
        self.far += if tried > GATHER_AHEAD { 1 } else { -1 };
        best.filter(|b| b.fit.place.abs() <= threshold)
    }

    /// Whether the samples of a window follow each other without a gap.
    fn is_seen(&self, limits: &Limits) -> bool {
        let inside = |s: &&Neighbour| s.x.abs() <= limits.reach && s.y.abs() <= limits.across;
        let mut samples = self.found.iter().filter(inside);
        let Some(mut last) = samples.next() else { return false };
        samples.all(|s| {
            let footprint = |n: &Neighbour| self.clusters[n.number as usize].evidence.footprint;
            let (step, coarser) = (s.x - last.x, footprint(last).max(footprint(s)));
            last = s;
            step <= GAP_FOOTPRINTS * coarser
        })
    }

    /// Gathers the clusters for a window and some wider ones, unless they are there already.
    fn gather_for(&mut self, here: &Cluster, step: i32, threshold: f64) {
        if half_width(here, step) <= self.reach {
            return;
        }
        let far = self.far > 0 && self.scale.steps().wide_gathering;
        let ahead = if far { WINDOWS } else { GATHER_AHEAD };
        let reach = half_width(here, (step + ahead).min(WINDOWS - 1));
        let window = Window {
            centre: here.position,
            tangent: here.tangent,
            reach,
            across: across(threshold, reach),
            same_way: self.scale.same_way,
        };
        let Self { clusters, found, .. } = self;
        found.clear();
        window.visit(&self.grid, |j, x, y| {
            if window.goes_along(&clusters[j].tangent) {
                found.push(Neighbour { number: j as u32, x, y });
            }
        });
        found.sort_unstable_by_key(|n| ordered(n.x as f32));
        let samples = found.iter().map(|n| sample(clusters, n));
        self.windows.begin(samples, half_width(here, 0));
        self.reach = reach;
    }
}

/// A neighbour as a sample of a fit.
fn sample(clusters: &[Cluster], n: &Neighbour) -> Sample {
    let Cluster { evidence, along_variance, correlation, .. } = clusters[n.number as usize];
    let (weight, sigma) = (evidence.weight, evidence.random_sigma);
    Sample { x: n.x, y: n.y, weight, sigma, along_variance, correlation }
}

/// An integer for each number, in the order of [`f32::total_cmp`]: integers sort faster.
fn ordered(x: f32) -> i32 {
    let bits = x.to_bits() as i32;
    if bits < 0 { bits ^ i32::MAX } else { bits }
}

/// Half-width along the curve of a node's windows, from the narrowest on.
fn half_width(here: &Cluster, step: i32) -> f64 {
    NARROWEST_FOOTPRINTS * here.evidence.footprint * WINDOW_GROWTH.powi(step)
}

/// Half-width of a window across: a bend leaves the tangent by up to half the reach where
/// directions still count as the same.
fn across(threshold: f64, reach: f64) -> f64 {
    threshold.max(0.5 * reach)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(place: f64, place_sigma: f64) -> Fit {
        Fit { place, place_sigma, ..Fit::default() }
    }

    #[test]
    fn one_of_the_narrowest_windows_may_be_off_by_chance() {
        let wide = fit(0.0, 0.2);
        // In standard deviations of the difference, about those of the narrower fit.
        let narrower = |places: &[f64]| -> Vec<Fit> {
            let sigmas = [1.0, 0.7, 0.5, 0.35];
            places.iter().zip(sigmas).map(|(p, s)| fit(p * s, s)).collect()
        };
        assert!(agrees(&narrower(&[1.5, -1.5, 1.0]), &wide, STRAY_WINDOWS));
        assert!(agrees(&narrower(&[2.7, 0.5, 0.5]), &wide, STRAY_WINDOWS), "the narrowest");
        assert!(agrees(&narrower(&[0.5, -2.7, 0.5]), &wide, STRAY_WINDOWS), "the next");
        assert!(!agrees(&narrower(&[0.5, 0.5, 2.7]), &wide, STRAY_WINDOWS), "a wider one");
        assert!(!agrees(&narrower(&[3.5, 0.5, 0.5]), &wide, STRAY_WINDOWS), "too far");
        assert!(!agrees(&narrower(&[2.5, 2.5, 0.5]), &wide, STRAY_WINDOWS), "two");
    }
}
