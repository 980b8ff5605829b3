//! First place, thinning and clusters: from all observations to one kept node per footprint.
//!
//! Groups take their turns from the best supported on. One that is not absorbed by then moves onto a
//! robust line through its neighbours and absorbs those in a window around its new place, as they lie.
//! The window is some spreads wide, so that few are missed; one that is moves onto its own line when
//! its turn comes, and goes to the kept node in whose window it then lies.

use super::fit::{self, Fit, LineSample, line};
use super::groups::{self, Group, Groups};
use super::observations::{NONE, Observation, Observations};
use super::window::{Window, left_of};
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

/// The kept nodes, and for every observation the kept node that absorbed it.
pub(super) struct Thinned {
    pub kept: Vec<Kept>,
    pub absorbed_by: Vec<u32>,
}

/// Keeps the best-supported groups and clusters the observations of the others around them.
pub(super) fn thin(observations: &Observations, grid: &PointGrid, scale: &Scale) -> Thinned {
    let groups = groups::group(observations, grid, scale);
    let mut choice = Choice::new(&groups, scale);
    by_support(&groups).into_iter().for_each(|k| choice.take(k as usize));
    let Choice { mut kept, absorbed_by, .. } = choice;
    let absorbed_by: Vec<u32> = groups.of.iter().map(|&g| absorbed_by[g as usize]).collect();
    cluster(observations, &absorbed_by, &mut kept, scale.steps.along_variance);
    Thinned { kept, absorbed_by }
}

/// Groups in order of weight times footprint, then canonical order.
///
/// What many views saw well is in the middle of what all saw. Of equal weight the coarser one covers more
/// ground; where the surface bends, its sampling error makes it the lighter one.
fn by_support(groups: &Groups) -> Vec<u32> {
    // Numbers that have the order wanted are faster sorted than what they come from.
    let key = |(k, g): (usize, &Group)| {
        let support = ((g.weight * g.footprint) as f32).max(0.0).to_bits();
        u64::from(u32::MAX - support) << 32 | k as u64
    };
    let mut order: Vec<u64> = groups.all.iter().enumerate().map(key).collect();
    order.sort_unstable();
    order.into_iter().map(|key| key as u32).collect()
}

/// The groups kept so far, each moved to its place, and what they absorbed.
struct Choice<'a> {
    groups: &'a Groups,
    scale: &'a Scale,
    grid: PointGrid,
    kept: Vec<Kept>,
    /// For each kept node the window in which it absorbs.
    windows: Vec<Window>,
    /// For each group the kept node that absorbed it.
    absorbed_by: Vec<u32>,
    /// The neighbours of the group whose turn it is: numbers, and places along and across.
    near: Vec<u32>,
    samples: Vec<LineSample>,
}

impl<'a> Choice<'a> {
    fn new(groups: &'a Groups, scale: &'a Scale) -> Self {
        let positions: Vec<Point2> = groups.all.iter().map(|g| g.position).collect();
        Self {
            groups,
            scale,
            grid: PointGrid::new(&positions, 2.0 * scale.spacing),
            kept: Vec::new(),
            windows: Vec::new(),
            absorbed_by: vec![NONE; positions.len()],
            near: Vec::new(),
            samples: Vec::new(),
        }
    }

    /// Keeps a group, if nothing kept has absorbed it or lies where it belongs.
    fn take(&mut self, k: usize) {
        if self.absorbed_by[k] != NONE {
            return;
        }
        let group = &self.groups.all[k];
        let across = self.scale.across(group.sigma, group.room);
        let line = self.line(group, across);
        let normal = left_of(&group.tangent);
        let window = Window {
            centre: group.position + normal * line.place,
            tangent: (group.tangent + normal * line.slope).normalize(),
            reach: ABSORB_FOOTPRINTS * group.footprint,
            // Half the way to the next layer is all of it.
            across: (ABSORB_SHARE * self.scale.across(group.sigma, f64::INFINITY)).min(group.room),
            same_way: self.scale.same_way,
        };
        self.absorbed_by[k] = self
            .kept_around(&window)
            .filter(|_| self.scale.steps.late_absorption)
            .unwrap_or_else(|| {
                self.absorb(&window, &line);
                self.windows.push(window);
                let kept = Kept::new(window.centre, window.tangent, group.footprint);
                self.kept.push(Kept { room: group.room, ..kept });
                self.kept.len() as u32 - 1
            });
    }

    /// A robust line through a group's neighbours, in the group's own direction.
    fn line(&mut self, here: &Group, across: f64) -> Fit {
        let window = Window {
            centre: here.position,
            tangent: here.tangent,
            reach: (ROUGH_FOOTPRINTS * here.footprint).max(ROUGH_SIGMAS * here.sigma),
            across,
            same_way: self.scale.same_way,
        };
        let (groups, near, samples) = (&self.groups.all, &mut self.near, &mut self.samples);
        near.clear();
        samples.clear();
        window.visit(
            &self.grid,
            |j| groups[j].tangent,
            |j, x, y| {
                near.push(j as u32);
                samples.push(LineSample::new((x, y), groups[j].weight, window.reach));
            },
        );
        line(samples, across).unwrap_or_default()
    }

    /// The first kept node that absorbed a neighbour, and in whose window the middle of this one lies.
    fn kept_around(&self, window: &Window) -> Option<u32> {
        let mut found = NONE;
        for &j in &self.near {
            let by = self.absorbed_by[j as usize];
            if by < found && self.windows[by as usize].holds(window) {
                found = by;
            }
        }
        (found != NONE).then_some(found)
    }

    /// Gives the neighbours along a line to the node that is kept next.
    fn absorb(&mut self, window: &Window, line: &Fit) {
        let number = self.kept.len() as u32;
        for (&j, s) in self.near.iter().zip(&self.samples) {
            let off = s.y - (line.place + line.slope * s.x);
            let by = &mut self.absorbed_by[j as usize];
            if *by == NONE && s.x.abs() <= window.reach && off.abs() <= window.across {
                *by = number;
            }
        }
    }
}

/// Gathers the original places of what each kept node absorbed.
fn cluster(observations: &Observations, absorbed_by: &[u32], kept: &mut [Kept], av: bool) {
    let mut sums = vec![Sums::default(); kept.len()];
    for (o, &by) in observations.all.iter().zip(absorbed_by) {
        let k = &kept[by as usize];
        sums[by as usize].add(o, (o.position - k.position).dot(&k.tangent));
    }
    for (k, s) in kept.iter_mut().zip(&sums) {
        k.views = s.views;
        if s.weight > 0.0 {
            // Nodes of no weight stand for themselves.
            s.give(k, av);
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
    /// Weighted common error of the members of the last view, and sum of the squares of that of earlier ones.
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
        self.of_view += o.weight * o.common;
        self.credit += o.credit;
        self.position += o.position.coords * o.weight;
        self.along += o.weight * along;
        self.along_squared += o.weight * along * along;
        self.normal += o.normal * o.weight as f32;
        self.correlation += o.weight * o.correlation;
    }

    fn give(&self, k: &mut Kept, av: bool) {
        k.cluster = Point2::from(self.position / self.weight);
        k.cluster_sigma = self.variance.sqrt() / self.weight;
        let along = self.along / self.weight;
        k.along_variance =
            if !av { 0.0 } else { (self.along_squared / self.weight - along * along).max(0.0) };
        let squares = self.of_views + self.of_view * self.of_view;
        k.common_variance = squares / (self.weight * self.weight);
        k.sigma = (k.cluster_sigma.powi(2) + k.common_variance).sqrt();
        k.weight = self.weight;
        k.credit = self.credit;
        k.correlation = self.correlation / self.weight;
        k.normal = self.normal.try_normalize(0.0).unwrap_or_default();
    }
}
