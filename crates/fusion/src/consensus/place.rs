//! Final place of the kept nodes: a robust parabola through the clusters around each.
//!
//! The window is the widest whose estimate still agrees with those of all narrower windows
//! (intersection of confidence intervals): wide along smooth curves, narrow at detail.

use super::fit::{Fit, Sample, parabola};
use super::window::{Window, left_of};
use super::{Kept, Scale};
use crate::grid::PointGrid;
use transect_geometry::Point2;

/// Half-width of the narrowest window, in footprints.
const NARROWEST_FOOTPRINTS: f64 = 2.5;

/// Each window is this much wider than the one before.
const WINDOW_GROWTH: f64 = 1.5;

/// Windows tried.
const WINDOWS: i32 = 6;

/// A node whose first windows determine no parabola, such as one at an open end, stays on its line.
const LAST_FIRST_WINDOW: i32 = 1;

/// Half-width of a confidence interval in standard deviations of random error. Smaller follows
/// detail and noise alike; larger smooths over both.
const CONFIDENCE: f64 = 1.0;

/// Largest curvature times half-width for which a parabola stands for the curve.
const LARGEST_TURN: f64 = 0.13;

/// Moves every kept node to its final place and direction.
pub(super) fn place(kept: &mut [Kept], scale: &Scale) {
    let clusters: Vec<Point2> = kept.iter().map(|k| k.cluster).collect();
    let grid = PointGrid::new(&clusters, 2.0 * NARROWEST_FOOTPRINTS * scale.spacing);
    let mut samples = Vec::new();
    let placed: Vec<Option<Fit>> =
        kept.iter().map(|here| widest_fit(kept, here, &grid, scale, &mut samples)).collect();
    for (k, fit) in kept.iter_mut().zip(placed) {
        let Some(fit) = fit else { continue };
        let normal = left_of(&k.tangent);
        k.position += normal * fit.place;
        k.tangent = (k.tangent + normal * fit.slope).normalize();
        k.sigma = fit.place_sigma;
    }
}

/// The fit in the widest window that agrees with all narrower ones.
fn widest_fit(
    kept: &[Kept],
    here: &Kept,
    grid: &PointGrid,
    scale: &Scale,
    samples: &mut Vec<Sample>,
) -> Option<Fit> {
    let threshold = scale.across(here.cluster_sigma);
    let mut best: Option<Fit> = None;
    let mut interval = (f64::NEG_INFINITY, f64::INFINITY);
    for step in 0..WINDOWS {
        let reach = NARROWEST_FOOTPRINTS * here.footprint * WINDOW_GROWTH.powi(step);
        gather(kept, here, grid, (reach, threshold, scale.same_way), samples);
        let Some(fit) = parabola(samples, reach, threshold) else {
            // A first fit across a gap would rest on far ground alone.
            if step < LAST_FIRST_WINDOW {
                continue;
            }
            break;
        };
        let half = CONFIDENCE * fit.place_sigma;
        interval = (interval.0.max(fit.place - half), interval.1.min(fit.place + half));
        let turns = 2.0 * (fit.bend.abs() - 2.0 * fit.bend_sigma) * reach > LARGEST_TURN;
        if best.is_some() && (interval.0 > interval.1 || turns) {
            break;
        }
        best = Some(fit);
    }
    best.filter(|f| f.place.abs() <= threshold)
}

fn gather(
    kept: &[Kept],
    here: &Kept,
    grid: &PointGrid,
    (reach, threshold, same_way): (f64, f64, f64),
    samples: &mut Vec<Sample>,
) {
    // A bend leaves the tangent by up to half the reach where directions still count as the same.
    let across = threshold.max(0.5 * reach);
    let window = Window { centre: here.position, tangent: here.tangent, reach, across, same_way };
    samples.clear();
    window.visit(
        grid,
        |j| kept[j].tangent,
        |j, x, y| {
            let Kept { weight, cluster_sigma: sigma, along_variance, .. } = kept[j];
            samples.push(Sample { x, y, weight, sigma, along_variance });
        },
    );
}
