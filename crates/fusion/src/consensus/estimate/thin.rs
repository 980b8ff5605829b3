//! Thinning: from all groups to one stand per footprint.
//!
//! Groups take their turns from the best supported on. A group that is not absorbed by then moves
//! onto a robust line through its neighbours. It absorbs those in a window around its new place;
//! they stay where they are. The window is some spreads wide, so that it misses few. A group that
//! it misses moves onto its own line when its turn comes, and goes to the stand in whose window it
//! then lies.

use super::super::measure::{NONE, Scale};
use super::super::tuning::thin::*;
use super::super::window::{Window, left_of};
use super::fit::{Fit, LineSample, line};
use super::groups::{Group, Groups};
use crate::grid::PointGrid;
use transect_geometry::Point2;

/// A place that was kept, and the window around it in which it absorbs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stand {
    pub window: Window,
    pub footprint: f64,
}

/// The stands, and for every group the stand that absorbed it.
pub(super) struct Thinned {
    pub stands: Vec<Stand>,
    pub absorbed_by: Vec<u32>,
}

/// Keeps the best-supported groups.
pub(super) fn thin(groups: &Groups, scale: &Scale) -> Thinned {
    let mut choice = Choice::new(groups, scale);
    by_support(groups).into_iter().for_each(|k| choice.take(k as usize));
    Thinned { stands: choice.stands, absorbed_by: choice.absorbed_by }
}

/// Groups in order of weight times footprint, then canonical order.
///
/// A group with many good observations lies in the middle of them all. Of equal weight, the coarser
/// group covers more ground; where the surface bends, its sampling error makes it the lighter one.
fn by_support(groups: &Groups) -> Vec<u32> {
    let support: Vec<f32> =
        groups.all.iter().map(|g| ((g.weight * g.footprint) as f32).max(0.0)).collect();
    let mut order: Vec<u32> = (0..support.len() as u32).collect();
    order.sort_by(|a, b| support[*b as usize].total_cmp(&support[*a as usize]));
    order
}

/// The stands so far, and what they absorbed.
struct Choice<'a> {
    groups: &'a Groups,
    scale: &'a Scale,
    grid: PointGrid,
    stands: Vec<Stand>,
    /// For each group the stand that absorbed it.
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
            stands: Vec::new(),
            absorbed_by: vec![NONE; positions.len()],
            near: Vec::new(),
            samples: Vec::new(),
        }
    }

    /// Makes a group a stand, unless a stand has absorbed it or holds its place.
    fn take(&mut self, k: usize) {
        if self.absorbed_by[k] != NONE {
            return;
        }
        let group = &self.groups.all[k];
        let line = self.line(group);
        let normal = left_of(&group.tangent);
        let across = ABSORB_SHARE * self.scale.across(group.sigma);
        let window = Window {
            centre: group.position + normal * line.place,
            tangent: (group.tangent + normal * line.slope).normalize(),
            reach: self.reach(group, &line, across),
            across,
            same_way: self.scale.same_way,
        };
        self.absorbed_by[k] = self.stand_around(&window).unwrap_or_else(|| {
            self.absorb(&window, &line);
            self.stands.push(Stand { window, footprint: group.footprint });
            self.stands.len() as u32 - 1
        });
    }

    /// A robust line through a group's neighbours, in the group's own direction.
    fn line(&mut self, here: &Group) -> Fit {
        let across = self.scale.across(here.sigma);
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
        window.visit(&self.grid, |j, x, y| {
            if window.goes_along(&groups[j].tangent) {
                near.push(j as u32);
                samples.push(LineSample::new(x, y, groups[j].weight, window.reach));
            }
        });
        line(samples, across).unwrap_or_default()
    }

    /// How far a stand absorbs along its line: no farther than to the first neighbour off it, but
    /// for the nearest ones. A wall that a view sees at a grazing angle would absorb what nearer
    /// views saw of the bends in it.
    fn reach(&self, group: &Group, line: &Fit, across: f64) -> f64 {
        let off = self.samples.iter().filter(|s| (s.y - line.at(s.x)).abs() > across);
        let beside = self.near.iter().map(|j| self.groups.all[*j as usize].footprint);
        let finest = beside.fold(group.footprint, f64::min);
        let [most, least] =
            [group.footprint, FINEST_FOOTPRINTS * finest].map(|size| ABSORB_FOOTPRINTS * size);
        off.map(|s| s.x.abs()).fold(most, f64::min).max(least.min(most))
    }

    /// The first stand that absorbed a neighbour and in whose window the centre of this one lies.
    fn stand_around(&self, window: &Window) -> Option<u32> {
        if !self.scale.steps().late_absorption {
            return None;
        }
        let mut found = NONE;
        for &j in &self.near {
            let by = self.absorbed_by[j as usize];
            if by < found && self.stands[by as usize].window.holds(window) {
                found = by;
            }
        }
        (found != NONE).then_some(found)
    }

    /// Gives the neighbours along a line to the next stand.
    fn absorb(&mut self, window: &Window, line: &Fit) {
        let number = self.stands.len() as u32;
        for (&j, s) in self.near.iter().zip(&self.samples) {
            let off = s.y - line.at(s.x);
            let by = &mut self.absorbed_by[j as usize];
            if *by == NONE && s.x.abs() <= window.reach && off.abs() <= window.across {
                *by = number;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::consensus::options::ConsensusOptions;
    use transect_geometry::Vector2;

    fn scale() -> Scale {
        let options = ConsensusOptions::default();
        Scale { spacing: 0.003, threshold: 0.004, same_way: 0.6, settled: false, options }
    }

    /// A wall between two recesses, which a near view sees finely and a far one coarsely.
    fn wall_with_recesses(depth: f64) -> Groups {
        let group = |x: f64, footprint: f64| {
            let y = if (x - 0.0015).abs() > 0.037 { depth } else { 0.0 };
            let (position, tangent) = (Point2::new(x, y), Vector2::x());
            Group { position, tangent, weight: 1.0, sigma: 1e-4, footprint }
        };
        let fine = (0..40).map(|k| group(0.003 * f64::from(k) - 0.06, 0.003));
        let all: Vec<Group> = fine.chain([group(0.0015, 0.1)]).collect();
        Groups { of: (0..all.len() as u32).collect(), all }
    }

    #[test]
    fn a_coarse_group_absorbs_no_farther_than_its_line_goes() {
        let absorbed = |groups: &Groups| {
            let thinned = thin(groups, &scale());
            let coarse = thinned.absorbed_by.last().copied();
            thinned.absorbed_by.iter().filter(|by| Some(**by) == coarse).count()
        };
        assert_eq!(absorbed(&wall_with_recesses(0.0)), 41, "a plain wall");
        let recessed = wall_with_recesses(0.0035);
        let before = recessed.all.iter().filter(|k| k.position.y == 0.0).count();
        assert!((2..41).contains(&before));
        // One more on either side moves onto a line that leads into its window.
        assert_eq!(absorbed(&recessed), before + 2);
    }
}
