//! The ground between two places, as the views know it: one view measured it, or one view saw
//! the surface end on both sides of it.

use crate::consensus::measure::{Observation, Observations};
use crate::grid::PointGrid;
use transect_geometry::{CurveUnit, EndReason, Point2, Vector2};

/// How far from a range jump a gap may begin or end that the jump forbids, in footprints of the
/// view. By hand: other views may see a little farther round the rim. Doubled: neighbouring
/// surfaces of small parts are kept apart.
const JUMP_FOOTPRINTS: f64 = 3.0;

/// How far beyond its ends a view's unit shows the ground, in lengths of the unit. By hand: outside
/// a bend a place lies beyond both units. Doubled: a missing pixel passes as measured.
const BEYOND: f64 = 0.25;

/// A range jump at one end of a view's curve.
struct Jump<'a> {
    at: &'a Observation,
    curve: u32,
}

/// The ground of a plane, as its views saw it.
pub(crate) struct Ground<'a> {
    observations: &'a Observations,
    grid: &'a PointGrid,
    /// Jumps at which curves end.
    leaving: Vec<Jump<'a>>,
    /// Jumps at which curves begin.
    arriving: Vec<Jump<'a>>,
}

impl Jump<'_> {
    fn is_near(&self, place: &Point2) -> bool {
        (self.at.position - place).norm() <= JUMP_FOOTPRINTS * self.at.footprint
    }
}

impl<'a> Ground<'a> {
    /// The ground of observations, whose places are in the grid.
    pub fn new(observations: &'a Observations, grid: &'a PointGrid) -> Self {
        let jumps = |is_last: bool| {
            let ends = observations.ends.iter();
            let jumps = ends.filter(|e| e.is_last == is_last && e.reason == EndReason::RangeJump);
            let at = |k: u32| &observations.all[k as usize];
            jumps.map(|e| Jump { at: at(e.observation), curve: e.curve }).collect()
        };
        Self { observations, grid, leaving: jumps(true), arriving: jumps(false) }
    }

    /// Whether a unit leads over ground in the shadow of a view. One curve of that view ends by a
    /// range jump where the unit begins. Another one begins by a range jump where the unit ends.
    pub fn is_in_shadow(&self, unit: &CurveUnit) -> bool {
        let mut leaving = self.leaving.iter().filter(|jump| jump.is_near(&unit.start));
        leaving.any(|out| {
            let same = |jump: &&Jump<'_>| jump.at.view == out.at.view && jump.curve != out.curve;
            self.arriving.iter().filter(same).any(|jump| jump.is_near(&unit.end))
        })
    }

    /// Whether a unit begins and ends at range jumps, of any views.
    pub fn is_between_jumps(&self, unit: &CurveUnit) -> bool {
        self.leaving.iter().any(|jump| jump.is_near(&unit.start))
            && self.arriving.iter().any(|jump| jump.is_near(&unit.end))
    }

    /// Whether a view measured the ground within a distance of the middle of a unit.
    pub fn is_measured(&self, unit: &CurveUnit, footprint: f64, distance: f64) -> bool {
        let way = unit.vector();
        let reach = 2.0 * way.norm().max(footprint);
        !self.views_at(&unit.at(0.5), &way, [reach, distance]).is_empty()
    }

    /// The views that measured ground along a way, near a place: within a reach along the way, and
    /// within a distance.
    pub fn views_at(&self, place: &Point2, way: &Vector2, [reach, distance]: [f64; 2]) -> Vec<u32> {
        let mut views = Vec::new();
        self.grid.within(place, reach + distance, |k, _| {
            let here = &self.observations.all[k];
            let next = self.observations.all.get(here.next as usize).filter(|_| !here.bridged);
            let measured = next.is_some_and(|next| {
                let seen = CurveUnit { start: here.position, end: next.position };
                let along = -BEYOND..=1.0 + BEYOND;
                along.contains(&seen.parameter(place))
                    && seen.vector().dot(way) > 0.0
                    && seen.distance(place) <= distance
            });
            if measured && !views.contains(&here.view) {
                views.push(here.view);
            }
        });
        views
    }
}
