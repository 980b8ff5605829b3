//! First place, thinning and clusters: from all observations to one kept node per footprint.

use super::fit::{self, LineSample, line};
use super::groups::{self, Group, Groups};
use super::observations::{NONE, Observation, Observations};
use super::window::Window;
use super::{Kept, Scale};
use crate::grid::PointGrid;
use nalgebra::Vector3;
use transect_geometry::{Point2, Vector2};

/// Reach of the first, rough fit along the curve, in footprints and standard deviations.
const ROUGH_FOOTPRINTS: f64 = 2.0;
const ROUGH_SIGMAS: f64 = 3.0;

/// A node absorbs what lies within this many of its footprints along the curve, and within this
/// share of the overlap threshold across it.
const ABSORB_FOOTPRINTS: f64 = 0.7;
const ABSORB_SHARE: f64 = 0.6;

/// A group moved onto the robust line through its neighbours of all views.
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

/// Keeps the best-supported groups and clusters the observations of the others around them.
pub(super) fn thin(observations: &Observations, grid: &PointGrid, scale: &Scale) -> Thinned {
    let groups = groups::group(observations, grid, scale);
    let projected = project(&groups, scale);
    let (chosen, group_absorbed_by) = choose(&groups, &projected, scale);
    let mut kept: Vec<Kept> = chosen
        .iter()
        .map(|&k| {
            let (p, g) = (&projected[k as usize], &groups.all[k as usize]);
            Kept::new(p.position, p.tangent, g.footprint)
        })
        .collect();
    let absorbed_by: Vec<u32> = groups.of.iter().map(|&g| group_absorbed_by[g as usize]).collect();
    cluster(observations, &absorbed_by, &mut kept, scale.common);
    Thinned { kept, absorbed_by }
}

fn project(groups: &Groups, scale: &Scale) -> Vec<Projected> {
    let positions: Vec<Point2> = groups.all.iter().map(|g| g.position).collect();
    let grid = PointGrid::new(&positions, 2.0 * scale.spacing);
    let (mut samples, mut views) = (Vec::new(), vec![0_u64; groups.words]);
    let project = |here: &Group| {
        let window = Window {
            centre: here.position,
            tangent: here.tangent,
            reach: (ROUGH_FOOTPRINTS * here.footprint).max(ROUGH_SIGMAS * here.sigma),
            across: scale.across(here.sigma),
            same_way: scale.same_way,
        };
        views.fill(0);
        samples.clear();
        window.visit(
            &grid,
            |j| groups.all[j].tangent,
            |j, x, y| {
                let g = &groups.all[j];
                samples.push(LineSample::new((x, y), g.weight, window.reach));
                views.iter_mut().zip(groups.views(j)).for_each(|(all, v)| *all |= v);
            },
        );
        let fit = line(&samples, window.across).unwrap_or_default();
        let normal = window.normal();
        let tangent = (here.tangent + normal * fit.slope).normalize();
        let position = here.position + normal * fit.place;
        Projected { position, tangent, views: views.iter().map(|w| w.count_ones()).sum() }
    };
    groups.all.iter().map(project).collect()
}

/// Chooses groups in order of support, each absorbing what lies beside it.
fn choose(groups: &Groups, projected: &[Projected], scale: &Scale) -> (Vec<u32>, Vec<u32>) {
    let positions: Vec<Point2> = projected.iter().map(|p| p.position).collect();
    let grid = PointGrid::new(&positions, scale.spacing);
    let mut absorbed_by = vec![NONE; projected.len()];
    let mut chosen = Vec::new();
    for k in by_support(groups, projected) {
        if absorbed_by[k as usize] != NONE {
            continue;
        }
        let number = chosen.len() as u32;
        chosen.push(k);
        let (here, group) = (&projected[k as usize], &groups.all[k as usize]);
        let window = Window {
            centre: here.position,
            tangent: here.tangent,
            reach: ABSORB_FOOTPRINTS * group.footprint,
            across: ABSORB_SHARE * scale.across(group.sigma),
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

/// Groups with more views around them first, then the better seen, then canonical order.
fn by_support(groups: &Groups, projected: &[Projected]) -> Vec<u32> {
    // Numbers that have the order wanted are faster sorted than what they come from.
    let key = |(k, (p, g)): (usize, (&Projected, &Group))| {
        let quality = g.quality.max(0.0).to_bits();
        (u32::MAX - p.views, u64::MAX - quality, k as u32)
    };
    let mut order: Vec<_> = projected.iter().zip(&groups.all).enumerate().map(key).collect();
    order.sort_unstable();
    order.into_iter().map(|(_, _, k)| k).collect()
}

/// Gathers the original places of what each kept node absorbed.
fn cluster(observations: &Observations, absorbed_by: &[u32], kept: &mut [Kept], common: f64) {
    let mut sums = vec![Sums::default(); kept.len()];
    for (o, &by) in observations.all.iter().zip(absorbed_by) {
        let k = &kept[by as usize];
        sums[by as usize].add(o, (o.position - k.position).dot(&k.tangent));
    }
    for (k, s) in kept.iter_mut().zip(&sums) {
        k.views = s.views;
        if s.weight > 0.0 {
            // Nodes of no weight stand for themselves.
            s.give(k, common);
        }
    }
}

/// Sums over what a kept node absorbed. Members come view by view, and along the view's curves.
#[derive(Debug, Clone, Copy)]
struct Sums {
    weight: f64,
    credit: f64,
    position: Vector2,
    along: f64,
    along_squared: f64,
    normal: Vector3<f32>,
    correlation: f64,
    views: u32,
    last_view: u32,
    last_along: f64,
    variance: f64,
    /// Weighted error of earlier members of the same view that the next one shares.
    shared: f64,
    /// Weight of the members of the last view, and sum of the squares of that of earlier ones.
    of_view: f64,
    of_views: f64,
}

impl Default for Sums {
    fn default() -> Self {
        Self {
            weight: 0.0,
            credit: 0.0,
            position: Vector2::zeros(),
            along: 0.0,
            along_squared: 0.0,
            normal: Vector3::zeros(),
            correlation: 0.0,
            views: 0,
            last_view: NONE,
            last_along: 0.0,
            variance: 0.0,
            shared: 0.0,
            of_view: 0.0,
            of_views: 0.0,
        }
    }
}

impl Sums {
    fn add(&mut self, o: &Observation, along: f64) {
        if self.last_view != o.view {
            // Views err independently.
            (self.last_view, self.shared) = (o.view, 0.0);
            self.of_views += self.of_view * self.of_view;
            self.of_view = 0.0;
            self.views += 1;
        }
        let error = o.weight * o.sigma;
        self.shared *= fit::shared(along - self.last_along, o.correlation);
        self.variance += error * (error + 2.0 * self.shared);
        self.shared += error;
        self.last_along = along;
        self.weight += o.weight;
        self.of_view += o.weight;
        self.credit += o.credit;
        self.position += o.position.coords * o.weight;
        self.along += o.weight * along;
        self.along_squared += o.weight * along * along;
        self.normal += o.normal * o.weight as f32;
        self.correlation += o.weight * o.correlation;
    }

    fn give(&self, k: &mut Kept, common: f64) {
        k.cluster = Point2::from(self.position / self.weight);
        k.cluster_sigma = self.variance.sqrt() / self.weight;
        let along = self.along / self.weight;
        k.along_variance = (self.along_squared / self.weight - along * along).max(0.0);
        let squares = self.of_views + self.of_view * self.of_view;
        k.common_variance = squares * (common / self.weight).powi(2);
        k.sigma = k.cluster_sigma.hypot(k.common_variance.sqrt());
        k.weight = self.weight;
        k.credit = self.credit;
        k.correlation = self.correlation / self.weight;
        k.normal = self.normal.try_normalize(0.0).unwrap_or_default();
    }
}
