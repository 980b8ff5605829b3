//! First place, thinning and clusters: from all observations to one kept node per footprint.

use super::fit::{Sample, line};
use super::observations::{NONE, Observations};
use super::{Kept, Scale};
use crate::grid::PointGrid;
use transect_geometry::{Point2, Vector2};

/// Reach of the first, rough fit along the curve, in footprints and standard deviations.
const ROUGH_FOOTPRINTS: f64 = 2.0;
const ROUGH_SIGMAS: f64 = 3.0;

/// A node absorbs what lies within this many of its footprints along the curve, and within this
/// share of the overlap threshold across it.
const ABSORB_FOOTPRINTS: f64 = 0.7;
const ABSORB_SHARE: f64 = 0.6;

/// An observation moved onto the robust line through its neighbours of all views.
#[derive(Debug, Clone, Copy)]
struct Projected {
    position: Point2,
    tangent: Vector2,
    /// How many views are among the neighbours.
    views: u32,
}

/// The kept nodes, and for every observation the kept node that absorbed it.
pub(super) struct Thinned {
    pub kept: Vec<Kept>,
    pub absorbed_by: Vec<u32>,
}

/// Keeps the best-supported observations and clusters the others around them.
pub(super) fn thin(observations: &Observations, grid: &PointGrid, scale: &Scale) -> Thinned {
    let projected = project(observations, grid, scale);
    let (chosen, absorbed_by) = choose(observations, &projected, scale);
    let mut kept: Vec<Kept> = chosen
        .iter()
        .map(|&k| {
            let (p, o) = (&projected[k as usize], &observations.all[k as usize]);
            Kept::new(p.position, p.tangent, o.footprint)
        })
        .collect();
    cluster(observations, &absorbed_by, &mut kept);
    Thinned { kept, absorbed_by }
}

fn project(observations: &Observations, grid: &PointGrid, scale: &Scale) -> Vec<Projected> {
    let mut samples = Vec::new();
    let mut seen_for = vec![NONE; observations.sources.len()];
    let all = &observations.all;
    all.iter()
        .enumerate()
        .map(|(k, here)| {
            let reach = (ROUGH_FOOTPRINTS * here.footprint).max(ROUGH_SIGMAS * here.sigma);
            let across = scale.across(here.sigma);
            let normal = Vector2::new(-here.tangent.y, here.tangent.x);
            let mut views = 0;
            samples.clear();
            grid.within(&here.position, reach.hypot(across), |j, d| {
                let there = &all[j];
                let (x, y) = (d.dot(&here.tangent), d.dot(&normal));
                let same = there.tangent.dot(&here.tangent) >= scale.same_way;
                if same && x.abs() <= reach && y.abs() <= across {
                    samples.push(Sample {
                        x,
                        y,
                        weight: there.weight,
                        sigma: there.sigma,
                        along_variance: 0.0,
                    });
                    if seen_for[there.view as usize] != k as u32 {
                        seen_for[there.view as usize] = k as u32;
                        views += 1;
                    }
                }
            });
            let fit = line(&samples, reach, across).unwrap_or_default();
            let tangent = (here.tangent + normal * fit.slope).normalize();
            Projected { position: here.position + normal * fit.place, tangent, views }
        })
        .collect()
}

/// Chooses observations in order of support, each absorbing what lies beside it.
fn choose(
    observations: &Observations,
    projected: &[Projected],
    scale: &Scale,
) -> (Vec<u32>, Vec<u32>) {
    let positions: Vec<Point2> = projected.iter().map(|p| p.position).collect();
    let grid = PointGrid::new(&positions, scale.spacing);
    let mut order: Vec<u32> = (0..projected.len() as u32).collect();
    // More views first, then the better seen, then canonical order.
    order.sort_by(|&a, &b| {
        let (p, q) = (a as usize, b as usize);
        let (o, r) = (&observations.all[p], &observations.all[q]);
        let quality = |o: &super::observations::Observation| o.weight / o.footprint;
        (projected[q].views.cmp(&projected[p].views))
            .then(quality(r).total_cmp(&quality(o)))
            .then(a.cmp(&b))
    });
    let mut absorbed_by = vec![NONE; projected.len()];
    let mut chosen = Vec::new();
    for k in order {
        if absorbed_by[k as usize] != NONE {
            continue;
        }
        let number = chosen.len() as u32;
        chosen.push(k);
        let here = &projected[k as usize];
        let along_limit = ABSORB_FOOTPRINTS * observations.all[k as usize].footprint;
        let across_limit = ABSORB_SHARE * scale.across(observations.all[k as usize].sigma);
        grid.within(&here.position, along_limit.hypot(across_limit), |j, d| {
            let (along, across) = (d.dot(&here.tangent), d.perp(&here.tangent));
            let beside = along.abs() <= along_limit && across.abs() <= across_limit;
            let same = projected[j].tangent.dot(&here.tangent) >= scale.same_way;
            if absorbed_by[j] == NONE && beside && same {
                absorbed_by[j] = number;
            }
        });
        absorbed_by[k as usize] = number;
    }
    (chosen, absorbed_by)
}

/// Gathers the original places of what each kept node absorbed.
fn cluster(observations: &Observations, absorbed_by: &[u32], kept: &mut [Kept]) {
    // Members come view by view, so a view is new to a cluster if it was not the last one seen.
    let mut last_view = vec![NONE; kept.len()];
    let mut sums = vec![Sums::default(); kept.len()];
    for (o, &by) in observations.all.iter().zip(absorbed_by) {
        let s = &mut sums[by as usize];
        s.weight += o.weight;
        s.position += o.position.coords * o.weight;
        s.variance += (o.weight * o.sigma).powi(2);
        let along = (o.position - kept[by as usize].position).dot(&kept[by as usize].tangent);
        s.along += o.weight * along;
        s.along_squared += o.weight * along * along;
        if last_view[by as usize] != o.view {
            last_view[by as usize] = o.view;
            kept[by as usize].views += 1;
        }
    }
    for (k, s) in kept.iter_mut().zip(&sums) {
        k.cluster = Point2::from(s.position / s.weight);
        k.cluster_sigma = s.variance.sqrt() / s.weight;
        let along = s.along / s.weight;
        k.along_variance = (s.along_squared / s.weight - along * along).max(0.0);
        k.weight = s.weight;
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    weight: f64,
    position: Vector2,
    variance: f64,
    along: f64,
    along_squared: f64,
}
