//! First place, thinning and clusters: from all observations to one kept node per footprint.

use super::fit::{Sample, line};
use super::observations::{NONE, Observation, Observations};
use super::window::Window;
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
    let mut neighbours = Neighbours::new(observations);
    let all = observations.all.iter().enumerate();
    all.map(|(k, here)| {
        let window = Window {
            centre: here.position,
            tangent: here.tangent,
            reach: (ROUGH_FOOTPRINTS * here.footprint).max(ROUGH_SIGMAS * here.sigma),
            across: scale.across(here.sigma),
            same_way: scale.same_way,
        };
        let views = neighbours.gather(k, &window, grid);
        let fit = line(&neighbours.samples, window.reach, window.across).unwrap_or_default();
        let normal = window.normal();
        let tangent = (here.tangent + normal * fit.slope).normalize();
        Projected { position: here.position + normal * fit.place, tangent, views }
    })
    .collect()
}

/// Work space for gathering one observation's neighbours after another's.
struct Neighbours<'a> {
    observations: &'a Observations,
    samples: Vec<Sample>,
    /// For each view, the last observation for which it was seen among the neighbours.
    seen_for: Vec<u32>,
}

impl<'a> Neighbours<'a> {
    fn new(observations: &'a Observations) -> Self {
        let seen_for = vec![NONE; observations.sources.len()];
        Self { observations, samples: Vec::new(), seen_for }
    }

    /// Gathers the neighbours of observation `k`; returns how many views they come from.
    fn gather(&mut self, k: usize, window: &Window, grid: &PointGrid) -> u32 {
        let all = &self.observations.all;
        let (samples, seen_for) = (&mut self.samples, &mut self.seen_for);
        let mut views = 0;
        samples.clear();
        window.visit(
            grid,
            |j| all[j].tangent,
            |j, x, y| {
                let Observation { weight, sigma, view, .. } = all[j];
                samples.push(Sample { x, y, weight, sigma, along_variance: 0.0 });
                if seen_for[view as usize] != k as u32 {
                    seen_for[view as usize] = k as u32;
                    views += 1;
                }
            },
        );
        views
    }
}

/// Chooses observations in order of support, each absorbing what lies beside it.
fn choose(
    observations: &Observations,
    projected: &[Projected],
    scale: &Scale,
) -> (Vec<u32>, Vec<u32>) {
    let positions: Vec<Point2> = projected.iter().map(|p| p.position).collect();
    let grid = PointGrid::new(&positions, scale.spacing);
    let mut absorbed_by = vec![NONE; projected.len()];
    let mut chosen = Vec::new();
    for k in by_support(observations, projected) {
        if absorbed_by[k as usize] != NONE {
            continue;
        }
        let number = chosen.len() as u32;
        chosen.push(k);
        let (here, seen) = (&projected[k as usize], &observations.all[k as usize]);
        let window = Window {
            centre: here.position,
            tangent: here.tangent,
            reach: ABSORB_FOOTPRINTS * seen.footprint,
            across: ABSORB_SHARE * scale.across(seen.sigma),
            same_way: scale.same_way,
        };
        window.visit(
            &grid,
            |j| projected[j].tangent,
            |j, _, _| {
                if absorbed_by[j] == NONE {
                    absorbed_by[j] = number;
                }
            },
        );
        absorbed_by[k as usize] = number;
    }
    (chosen, absorbed_by)
}

/// Observations with more views around them first, then the better seen, then canonical order.
fn by_support(observations: &Observations, projected: &[Projected]) -> Vec<u32> {
    let quality = |k: u32| {
        let o = &observations.all[k as usize];
        o.weight / o.footprint
    };
    let views = |k: u32| projected[k as usize].views;
    let mut order: Vec<u32> = (0..projected.len() as u32).collect();
    order.sort_by(|&a, &b| {
        views(b).cmp(&views(a)).then(quality(b).total_cmp(&quality(a))).then(a.cmp(&b))
    });
    order
}

/// Gathers the original places of what each kept node absorbed.
fn cluster(observations: &Observations, absorbed_by: &[u32], kept: &mut [Kept]) {
    // Members come view by view, so a view is new to a cluster if it was not the last one seen.
    let mut last_view = vec![NONE; kept.len()];
    let mut sums = vec![Sums::default(); kept.len()];
    for (o, &by) in observations.all.iter().zip(absorbed_by) {
        let s = &mut sums[by as usize];
        s.weight += o.weight;
        s.credit += o.credit;
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
        if s.weight <= 0.0 {
            // Nodes of no weight stand for themselves.
            continue;
        }
        k.cluster = Point2::from(s.position / s.weight);
        k.cluster_sigma = s.variance.sqrt() / s.weight;
        let along = s.along / s.weight;
        k.along_variance = (s.along_squared / s.weight - along * along).max(0.0);
        k.sigma = k.cluster_sigma;
        k.weight = s.weight;
        k.credit = s.credit;
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    weight: f64,
    credit: f64,
    position: Vector2,
    variance: f64,
    along: f64,
    along_squared: f64,
}
