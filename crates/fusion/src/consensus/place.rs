//! Final place of the kept nodes: a robust parabola, or arc, through the clusters around each.
//!
//! The window is the widest whose estimate differs from those of all narrower windows by no more
//! than random errors make it (Lepski's rule): wide along smooth curves, narrow at detail. Errors
//! that neighbours share leave narrow windows in agreement whatever their width; so it is the
//! *difference* that is judged, by its own standard deviation, and not each estimate by its own.
//!
//! With a handful of windows one of them differs by chance at every fifth node. So a single one is
//! passed over if the next wider one agrees again, and two in a row end the search. One of the two
//! narrowest may itself be the one that is off.
//!
//! Of a bend a parabola is an arc's second order. Fits follow the third and fourth too, as its own
//! bend tells them, so that the error left is that of the bend's changes.

use super::fit::Fit;
use super::layers::{self, Step};
use super::parabola::{Sample, Windows};
use super::window::{Window, left_of};
use super::{Kept, Scale};
use crate::grid::PointGrid;
use transect_geometry::{Point2, Vector2};

/// Half-width of the narrowest window, in footprints.
const NARROWEST_FOOTPRINTS: f64 = 2.5;

/// Each window is this much wider than the one before.
const WINDOW_GROWTH: f64 = 1.5;

/// Windows tried.
const WINDOWS: i32 = 6;

/// Windows that may be a node's first whatever lies in them. A wider one, as a fine node among coarse ones
/// needs it, must hold no gap of more than so many footprints of the coarser node beside it: thinning
/// leaves less. A node whose windows determine no parabola, such as one at an open end, stays on its line.
const LAST_FIRST_WINDOW: i32 = 1;
const LONGEST_STEP: f64 = 2.0;

/// Largest difference between fits that agree, in its standard deviations. Smaller follows detail and
/// noise alike; larger smooths over both.
const CONFIDENCE: f64 = 2.0;

/// One of so many narrowest windows may differ by more, up to this, from all wider ones that agree with each
/// other: chance puts it off at every twentieth node, and none would ever agree with it.
const MAY_STRAY: usize = 2;
const STRAY_CONFIDENCE: f64 = 3.0;

/// Smallest variance of the difference of two fits, as a share of that of the narrower.
const LEAST_NEWS: f64 = 0.1;

/// Largest curvature times half-width for which a fit stands for the curve, whatever the noise, and where
/// its error is small against noise. Beyond the second, directions no longer count as the same.
const LARGEST_TURN: f64 = 0.13;
const LARGEST_NOISY_TURN: f64 = 0.9;

/// Error of a fit in the middle of a bend, over (curvature × half-width)³ × half-width: an evenly sampled
/// parabola makes 0.0107 of an arc's fourth order, which fits follow; two fifths of that are left at
/// a turn of 0.6, where an arc's sixth order tells, and less at smaller turns as the turn's square. And how
/// large it may be, in standard deviations.
const ARC_ERROR: f64 = 0.4 * 0.0107;
const SIXTH_ORDER_TURN: f64 = 0.6;
const ERROR_SHARE: f64 = 0.5;

/// Windows for which the neighbours are gathered at once, beyond the one that asks, unless most nodes
/// so far needed more.
const GATHER_AHEAD: i32 = 2;

/// Length over which neighbouring fits share their errors, as a share of their half-width: a parabola
/// through 2 h of even samples has 9/4 the variance of their mean, as if 2 h / (9/4) were averaged.
const SHARED_WINDOW: f64 = 8.0 / 9.0;

/// Moves every kept node to its final place and direction.
pub(super) fn place(kept: &mut [Kept], scale: &Scale) {
    let mut near = Near::new(kept, 2.0 * NARROWEST_FOOTPRINTS * scale.spacing);
    (near.windows.arcs, near.windows.robust) = (scale.steps.arcs, scale.steps.robust_fit);
    let placed: Vec<Option<Placed>> =
        kept.iter().map(|here| widest_fit(here, scale, &mut near)).collect();
    for (k, placed) in kept.iter_mut().zip(placed) {
        let Some(Placed { fit, reach }) = placed else { continue };
        let normal = left_of(&k.tangent);
        k.position += normal * fit.place;
        k.tangent = (k.tangent + normal * fit.slope).normalize();
        k.sigma = (fit.place_sigma.powi(2) + k.common_variance).sqrt();
        k.correlation = k.correlation.max(SHARED_WINDOW * reach);
    }
}

/// The fit in the widest window that agrees with all narrower ones, and that window's half-width.
#[derive(Debug, Clone, Copy)]
struct Placed {
    fit: Fit,
    reach: f64,
}

fn widest_fit(here: &Kept, scale: &Scale, near: &mut Near) -> Option<Placed> {
    let threshold = scale.across(here.cluster_sigma, here.room);
    let reach = |step| NARROWEST_FOOTPRINTS * here.footprint * WINDOW_GROWTH.powi(step);
    let mut best: Option<Placed> = None;
    near.narrower.clear();
    near.reach = 0.0;
    let mut tried = 0;
    let mut doubted = false;
    for step in 0..WINDOWS {
        tried = step;
        let reach_now = reach(step);
        if reach_now > near.reach {
            let ahead = if near.far > 0 && scale.steps.gather_far { WINDOWS } else { GATHER_AHEAD };
            let farthest = reach((step + ahead).min(WINDOWS - 1));
            near.gather(here, (farthest, threshold, scale.same_way), scale.steps.layer_following);
        }
        let across = across(threshold, reach_now);
        let Some(fit) = near.windows.fit(reach_now, across, threshold) else {
            if best.is_none() {
                continue;
            }
            break;
        };
        let agrees = agrees(&near.narrower, &fit, scale.steps.stray_windows);
        let (error, small) = arc_error(&fit, reach_now, scale.steps.noisy_turns);
        // A first fit across a gap would rest on far ground alone.
        let wide = best.is_none() && step > LAST_FIRST_WINDOW;
        if wide && !(scale.steps.wide_first_window && small && near.is_seen(reach_now, across)) {
            break;
        }
        if best.is_some() && (!small || (!agrees && (doubted || !scale.steps.passed_window))) {
            break;
        }
        if best.is_some() && !agrees {
            doubted = true;
            continue;
        }
        doubted = false;
        near.narrower.push(fit);
        let place_sigma = fit.place_sigma.hypot(error);
        best = Some(Placed { fit: Fit { place_sigma, ..fit }, reach: reach_now });
    }
    near.far += if tried > GATHER_AHEAD { 1 } else { -1 };
    best.filter(|b| b.fit.place.abs() <= threshold)
}

/// How far a fit may be off in the middle of a bend, and whether that is no matter: hidden by noise, or of a
/// bend that is not known to be too much.
fn arc_error(fit: &Fit, reach: f64, noisy: bool) -> (f64, bool) {
    let turn = 2.0 * fit.bend.abs() * reach;
    let sixth_order = (turn / SIXTH_ORDER_TURN).powi(2).min(1.0);
    let error = ARC_ERROR * sixth_order * turn.powi(3) * reach;
    let hidden = noisy && turn <= LARGEST_NOISY_TURN && error <= ERROR_SHARE * fit.place_sigma;
    let known = turn - 4.0 * fit.bend_sigma * reach;
    (error, hidden || known <= LARGEST_TURN)
}

/// Whether a fit agrees with those in narrower windows, of which one may be off by chance.
fn agrees(narrower: &[Fit], wide: &Fit, stray: bool) -> bool {
    let mut strays = 0;
    narrower.iter().enumerate().all(|(step, narrow)| {
        let agrees = agree(narrow, wide, CONFIDENCE);
        strays += usize::from(!agrees);
        agrees
            || (stray && strays == 1 && step < MAY_STRAY && agree(narrow, wide, STRAY_CONFIDENCE))
    })
}

/// Whether a fit differs from one in a narrower window by no more than so many standard deviations.
///
/// The wider window holds the samples of the narrower one. What both share differs in neither, so
/// the variance of the difference is that of the narrower fit less that of the wider.
fn agree(narrow: &Fit, wide: &Fit, confidence: f64) -> bool {
    let (before, after) = (narrow.place_sigma.powi(2), wide.place_sigma.powi(2));
    let variance = (before - after).max(LEAST_NEWS * before);
    (wide.place - narrow.place).powi(2) <= confidence * confidence * variance
}

/// What fits need of a kept node, side by side.
#[derive(Debug, Clone, Copy)]
struct Cluster {
    tangent: Vector2,
    weight: f64,
    sigma: f64,
    along_variance: f64,
    correlation: f64,
    footprint: f64,
}

impl Cluster {
    fn of(k: &Kept) -> Self {
        let Kept {
            tangent,
            weight,
            cluster_sigma: sigma,
            along_variance,
            correlation,
            footprint,
            ..
        } = *k;
        Self { tangent, weight, sigma, along_variance, correlation, footprint }
    }

    fn at(&self, x: f64, y: f64) -> Sample {
        let Self { weight, sigma, along_variance, correlation, .. } = *self;
        Sample { x, y, weight, sigma, along_variance, correlation }
    }
}

/// The clusters around a node, gathered for several windows at once.
#[derive(Debug)]
struct Near {
    clusters: Vec<Cluster>,
    /// How far across the curve the rough line lies from each cluster; empty where there are no layers.
    off_line: Vec<f64>,
    grid: PointGrid,
    /// How far along the curve clusters have been gathered.
    reach: f64,
    /// How many more nodes went beyond the first windows than did not.
    far: i32,
    /// Number and place of what was gathered.
    found: Vec<(u32, f64, f64)>,
    /// Its order along the curve.
    order: Vec<u64>,
    windows: Windows,
    /// Fits in the windows accepted so far.
    narrower: Vec<Fit>,
}

impl Near {
    fn new(kept: &[Kept], cell: f64) -> Self {
        let places: Vec<Point2> = kept.iter().map(|k| k.cluster).collect();
        Self {
            clusters: kept.iter().map(Cluster::of).collect(),
            off_line: layers::off_line(kept),
            grid: PointGrid::new(&places, cell),
            reach: 0.0,
            far: 0,
            found: Vec::new(),
            order: Vec::new(),
            windows: Windows::default(),
            narrower: Vec::new(),
        }
    }

    /// Whether the samples of a window follow each other without a gap.
    fn is_seen(&self, reach: f64, across: f64) -> bool {
        let sample = |key: &u64| self.found[(key & u64::from(u32::MAX)) as usize];
        let inside = |s: &(u32, f64, f64)| s.1.abs() <= reach && s.2.abs() <= across;
        let mut samples = self.order.iter().map(sample).filter(inside);
        let Some(mut last) = samples.next() else { return false };
        samples.all(|s| {
            let [a, b] = [last.0, s.0].map(|j| self.clusters[j as usize].footprint);
            let step = s.1 - last.1;
            last = s;
            step <= LONGEST_STEP * a.max(b)
        })
    }

    fn gather(&mut self, here: &Kept, (reach, threshold, same_way): (f64, f64, f64), follow: bool) {
        let (centre, tangent) = (here.position, here.tangent);
        let window = Window { centre, tangent, reach, across: across(threshold, reach), same_way };
        let Self { clusters, off_line, found, order, .. } = self;
        found.clear();
        order.clear();
        window.visit(
            &self.grid,
            |j| clusters[j].tangent,
            |j, x, y| {
                order.push(u64::from(ordered(x as f32)) << 32 | found.len() as u64);
                found.push((j as u32, x, y));
            },
        );
        // Numbers are faster sorted than what they come from.
        order.sort_unstable();
        if here.room.is_finite() && follow {
            let place = |key: &u64| {
                let (j, x, y) = found[(key & u64::from(u32::MAX)) as usize];
                let t = clusters[j as usize].tangent;
                Step { x, y: y + off_line[j as usize], slope: tangent.perp(&t) / tangent.dot(&t) }
            };
            layers::keep_own(order, place, here.room);
        }
        let sample = |key: &u64| {
            let (j, x, y) = found[(key & u64::from(u32::MAX)) as usize];
            clusters[j as usize].at(x, y)
        };
        self.windows.begin(order.iter().map(sample), NARROWEST_FOOTPRINTS * here.footprint);
        self.reach = reach;
    }
}

/// A number that has the order of a value.
fn ordered(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
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
        assert!(agrees(&narrower(&[1.5, -1.5, 1.0]), &wide, true));
        assert!(agrees(&narrower(&[2.7, 0.5, 0.5]), &wide, true), "the narrowest");
        assert!(agrees(&narrower(&[0.5, -2.7, 0.5]), &wide, true), "the next");
        assert!(!agrees(&narrower(&[0.5, 0.5, 2.7]), &wide, true), "a wider one");
        assert!(!agrees(&narrower(&[3.5, 0.5, 0.5]), &wide, true), "too far");
        assert!(!agrees(&narrower(&[2.5, 2.5, 0.5]), &wide, true), "two");
    }
}
