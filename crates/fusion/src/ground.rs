//! The ground between two places, as the views know it: one view measured it, or one view saw
//! the surface end on both sides of it.

use crate::consensus::measure::{Observation, Observations};
use crate::grid::PointGrid;
use transect_geometry::{CurveUnit, EndReason, Point2, Vector2};

/// A range jump forbids gaps that begin or end within this distance of it, in footprints of its
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
    leaving: Jumps<'a>,
    /// Jumps at which curves begin.
    arriving: Jumps<'a>,
}

/// Range jumps in a grid by their places.
struct Jumps<'a> {
    all: Vec<Jump<'a>>,
    grid: PointGrid,
    /// Largest distance from which a place is near a jump.
    reach: f64,
}

impl<'a> Jumps<'a> {
    /// The jumps at which curves end, or at which they begin.
    fn new(observations: &'a Observations, is_last: bool) -> Self {
        let ends = observations.ends.iter();
        let jumps = ends.filter(|e| e.is_last == is_last && e.reason == EndReason::RangeJump);
        let at = |k: u32| &observations.all[k as usize];
        let all: Vec<_> = jumps.map(|e| Jump { at: at(e.observation), curve: e.curve }).collect();
        let reach = all.iter().map(Jump::reach).fold(0.0, f64::max);
        let places: Vec<Point2> = all.iter().map(|jump| jump.at.position).collect();
        Self { grid: PointGrid::new(&places, reach), all, reach }
    }

    /// The jumps near a place.
    fn near(&self, place: &Point2) -> Vec<&Jump<'a>> {
        let mut near = Vec::new();
        self.grid.around(place, &Vector2::repeat(self.reach), |k, _| {
            near.extend(self.all.get(k).filter(|jump| jump.is_near(place)));
        });
        near
    }
}

impl Jump<'_> {
    fn reach(&self) -> f64 {
        JUMP_FOOTPRINTS * self.at.footprint
    }

    fn is_near(&self, place: &Point2) -> bool {
        (self.at.position - place).norm() <= self.reach()
    }
}

impl<'a> Ground<'a> {
    /// The ground of observations, whose places are in the grid.
    pub fn new(observations: &'a Observations, grid: &'a PointGrid) -> Self {
        let jumps = |is_last| Jumps::new(observations, is_last);
        Self { observations, grid, leaving: jumps(true), arriving: jumps(false) }
    }

    /// Whether a unit leads over ground in the shadow of a view. One curve of that view ends by a
    /// range jump where the unit begins. Another one begins by a range jump where the unit ends.
    pub fn is_in_shadow(&self, unit: &CurveUnit) -> bool {
        let leaving = self.leaving.near(&unit.start);
        if leaving.is_empty() {
            return false;
        }
        let arriving = self.arriving.near(&unit.end);
        leaving.iter().any(|out| {
            arriving.iter().any(|jump| jump.at.view == out.at.view && jump.curve != out.curve)
        })
    }

    /// Whether a unit begins and ends at range jumps, of any views.
    pub fn is_between_jumps(&self, unit: &CurveUnit) -> bool {
        !self.leaving.near(&unit.start).is_empty() && !self.arriving.near(&unit.end).is_empty()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::consensus::Steps;
    use transect_geometry::{Curve, Node};

    /// Short curves of a view all over a square, which begin and end at range jumps.
    fn view(seed: u64) -> Vec<Curve> {
        let mut state = seed;
        let mut number = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(seed | 1);
            (state >> 40) as f64 / (1_u64 << 24) as f64
        };
        let curve = |_| {
            let (x, y, footprint) = (number(), number(), 0.002 + 0.03 * number());
            let node =
                |k: f64| Node::at(Point2::new(x + 0.02 * k, y)).with_footprint(footprint as f32);
            let curve = Curve::new([0.0, 1.0, 2.0].map(node).to_vec(), false).unwrap();
            curve.with_ends([Some(EndReason::RangeJump); 2])
        };
        (0..60).map(curve).collect()
    }

    #[test]
    fn shadows_are_those_that_all_pairs_of_jumps_show() {
        let views: Vec<Vec<Curve>> = (1..5).map(view).collect();
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        let observations = Observations::collect(&slices, &Steps::default());
        let grid = PointGrid::new(&observations.positions(), observations.spacing());
        let ground = Ground::new(&observations, &grid);
        let is_in_shadow = |unit: &CurveUnit| {
            ground.leaving.all.iter().filter(|out| out.is_near(&unit.start)).any(|out| {
                ground.arriving.all.iter().any(|jump| {
                    jump.at.view == out.at.view
                        && jump.curve != out.curve
                        && jump.is_near(&unit.end)
                })
            })
        };
        let mut shadows = 0;
        for k in 0..2000 {
            let place = |k: i32| Point2::new(f64::from(k % 53) / 53.0, f64::from(k % 37) / 37.0);
            let unit = CurveUnit { start: place(k), end: place(7 * k + 3) };
            assert_eq!(ground.is_in_shadow(&unit), is_in_shadow(&unit), "{unit:?}");
            shadows += usize::from(is_in_shadow(&unit));
        }
        assert!((20..1980).contains(&shadows), "{shadows}");
    }
}
