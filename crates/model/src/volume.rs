//! Volume between section planes, with a bound of the error that the interval causes (dissertation,
//! 3.7).
//!
//! Problem: the area of a solid is known on planes an interval `h` apart; what is its volume?
//!
//! Idea: between two selected planes the area is taken to change linearly (trapezoids). The solid
//! begins and ends within the interval before and after a run of planes, where its area is taken to
//! be 0. With one interval everywhere that is `V = h · Σ A_k`; where refinement inserted planes
//! every gap has its own interval.
//!
//! **Bound.** Assume that between neighbouring planes, and from the last one to the end of the
//! solid, the area only grows or only shrinks. Then the volume of each gap lies between `h` times
//! its smaller and `h` times its larger area, and `V` takes the middle. The error is then at most
//! `Σ h / 2 · |A_k+1 − A_k|`, ends included. Area that grows and shrinks again within one gap
//! breaks the assumption; a smaller interval restores it.
//!
//! The bound falls in proportion to the interval. The error itself falls faster where the solid is
//! smooth. Not included: the sampling along curves ([`Section::measures`]) and the noise of their
//! nodes.
//!
//! Along a curved guide a slice between two planes is thinner on the inside of the bend. Each area
//! counts with the spacing at its centre of mass, which is exact along a circular arc (Pappus).
//!
//! Selected planes without curves end a run, because free space there cannot be told from unseen
//! space.

use crate::{Model, PlaneSelection, Section, SectionMeasures};
use std::ops::RangeInclusive;
use transect_geometry::{PlaneFamily, PlaneIndex};

/// The volume of one run of neighbouring planes.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct RunVolume {
    /// The planes of the run.
    pub planes: RangeInclusive<PlaneIndex>,
    /// Volume of the solid.
    /// # Units
    /// The cube of the model's length unit.
    pub volume: f64,
    /// Largest error of the volume, if the area only grows or only shrinks between neighbouring
    /// planes.
    pub error_bound: f64,
    /// Planes of the run with open curves, whose area is incomplete. If there are any, neither the
    /// volume nor its bound is reliable.
    pub planes_with_open_curves: usize,
}

/// The volume of a model.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ModelVolume {
    /// Each run of neighbouring planes, in order of station.
    pub runs: Vec<RunVolume>,
}

impl ModelVolume {
    /// The sum over all runs, in the cube of the model's length unit.
    pub fn volume(&self) -> f64 {
        self.runs.iter().map(|run| run.volume).sum()
    }

    /// The sum of the bounds of all runs; `None` if a plane has open curves.
    pub fn error_bound(&self) -> Option<f64> {
        let closed = self.runs.iter().all(|run| run.planes_with_open_curves == 0);
        closed.then(|| self.runs.iter().map(|run| run.error_bound).sum())
    }
}

/// Adds up the volume of planes in order of station, without keeping the planes.
#[derive(Debug)]
pub struct VolumeSum {
    planes: PlaneFamily,
    selection: PlaneSelection,
    runs: Vec<RunVolume>,
    /// The plane that was added last, and its area.
    last: Option<(PlaneIndex, f64)>,
}

impl VolumeSum {
    /// An empty sum for a family of planes and the selected ones among them.
    pub fn new(planes: &PlaneFamily, selection: &PlaneSelection) -> Self {
        let (planes, selection) = (planes.clone(), selection.clone());
        Self { planes, selection, runs: Vec::new(), last: None }
    }

    /// Adds the next plane along the guide.
    pub fn add(&mut self, plane: PlaneIndex, section: &Section) {
        let area = self.area(plane, section);
        let previous = self.selection.previous_before(plane);
        let next_to = self.last.filter(|(last, _)| Some(*last) == previous);
        if next_to.is_none() {
            self.end_run();
            self.runs.push(RunVolume {
                planes: plane..=plane,
                volume: 0.0,
                error_bound: 0.0,
                planes_with_open_curves: 0,
            });
        }
        let before = next_to.map_or(0.0, |(_, area)| area);
        let interval = self.planes.interval() * self.selection.steps(plane).before;
        if let Some(run) = self.runs.last_mut() {
            run.planes = *run.planes.start()..=plane;
            run.volume += 0.5 * interval * (before + area);
            run.error_bound += 0.5 * interval * (area - before).abs();
            run.planes_with_open_curves += usize::from(section.open_curve_count() > 0);
        }
        self.last = Some((plane, area));
    }

    /// The area of a section, scaled along a curved guide by the spacing of the planes at its
    /// centre.
    fn area(&self, plane: PlaneIndex, section: &Section) -> f64 {
        let Some(guide) = self.planes.guide().curved() else { return section.signed_area() };
        let SectionMeasures { area, centroid, .. } = section.measures();
        let centre = centroid.map(|c| self.planes.frame(plane).world_from_plane(&c));
        area * centre.map_or(1.0, |c| guide.stretch(self.planes.station(plane), &c))
    }

    /// The volume of all planes that were added.
    pub fn finish(mut self) -> ModelVolume {
        self.end_run();
        ModelVolume { runs: self.runs }
    }

    /// After its last plane the solid ends before the next selected one.
    fn end_run(&mut self) {
        if let (Some(run), Some((plane, area))) = (self.runs.last_mut(), self.last) {
            let interval = self.planes.interval() * self.selection.steps(plane).after;
            run.volume += 0.5 * interval * area;
            run.error_bound += 0.5 * interval * area.abs();
        }
    }
}

impl Model {
    /// The volume of the solid; negative where the solid surrounds free space, as in a room.
    pub fn volume(&self) -> ModelVolume {
        let mut sum = VolumeSum::new(self.planes(), self.selection());
        self.sections().for_each(|(plane, section)| sum.add(plane, section));
        sum.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{circle, rectangle, strip};
    use std::f64::consts::PI;
    use transect_geometry::{Curve, CurvedGuide, LengthUnit, Point2, StraightGuide, Vector3};

    /// The model of a solid whose section at height z is `curves(z)`.
    fn model(interval: f64, offset: f64, curves: impl Fn(f64) -> Vec<Curve>) -> Model {
        let guide = StraightGuide::along(Vector3::z()).unwrap();
        let planes = PlaneFamily::new(guide, offset, interval).unwrap();
        let mut model = Model::new(LengthUnit::Metre, planes.clone());
        let last = (4.0 / interval) as i64;
        for k in (-last..=last).map(PlaneIndex) {
            model.set_curves(k, curves(planes.station(k)));
        }
        model
    }

    fn disc(radius: f64) -> Vec<Curve> {
        // Fine enough that the sampling along the curve stays far below what the interval does.
        let curve = || circle(Point2::new(1.0, 2.0), radius, 4000);
        (radius > 1e-9).then(curve).into_iter().collect()
    }

    /// Checks the bound for many places of the planes; the worst error of each interval.
    fn worst_errors(volume: f64, curves: impl Fn(f64) -> Vec<Curve>) -> Vec<f64> {
        let worst = |interval: f64| {
            let errors = (0..7).map(|i| {
                let found = model(interval, interval * f64::from(i) / 7.0, &curves).volume();
                let error = (found.volume() - volume).abs();
                let bound = found.error_bound().unwrap();
                assert!(error <= bound + 1e-5 * volume, "{error} > {bound} at {interval}");
                error
            });
            errors.fold(0.0, f64::max)
        };
        [0.5, 0.25, 0.125, 0.0625].map(worst).to_vec()
    }

    #[test]
    fn a_cone_has_its_volume_and_the_error_falls_with_the_interval() {
        let errors = worst_errors(PI / 3.0 * 3.0, |z| {
            if (0.0..=3.0).contains(&z) { disc((3.0 - z) / 3.0) } else { Vec::new() }
        });
        assert!(errors.windows(2).all(|pair| pair[1] < 0.6 * pair[0]), "{errors:?}");
    }

    #[test]
    fn the_error_of_a_ball_falls_with_the_square_of_the_interval() {
        let errors = worst_errors(4.0 / 3.0 * PI, |z: f64| disc((1.0 - z * z).max(0.0).sqrt()));
        assert!(errors.windows(2).all(|pair| pair[1] < 0.35 * pair[0]), "{errors:?}");
    }

    #[test]
    fn a_box_is_off_by_less_than_the_area_of_one_interval() {
        let errors = worst_errors(2.0 * 3.0 * 1.5, |z| {
            let inside = (0.1..=1.6).contains(&z);
            inside.then(|| rectangle(0.0, 0.0, 2.0, 3.0)).into_iter().collect()
        });
        let intervals = [0.5, 0.25, 0.125, 0.0625];
        assert!(errors.iter().zip(intervals).all(|(e, h)| *e <= 6.0 * h + 1e-9), "{errors:?}");
    }

    #[test]
    fn a_bent_bar_has_the_volume_of_pappus() {
        // A quarter of a ring: its section's centre is 3.5 from the axis, the guide 3.
        let corner = [(0.0, -9.0), (3.0, -9.0), (3.0, 9.0)];
        let corner = corner.map(|(x, y)| transect_geometry::Point3::new(x, y, 0.0)).to_vec();
        let guide = CurvedGuide::polyline(corner, Some(3.0)).unwrap();
        let planes = PlaneFamily::new(guide, 0.0, 0.01).unwrap();
        let mut model = Model::new(LengthUnit::Metre, planes.clone());
        for k in (0..).map(PlaneIndex) {
            let frame = planes.frame(k);
            if planes.station(k) > 3.0 * PI / 2.0 {
                break;
            }
            // Half a unit to the outside of the bend, whose centre is (0, −6).
            let outward =
                (frame.origin() - transect_geometry::Point3::new(0.0, -6.0, 0.0)).normalize();
            let centre = frame.plane_from_world(&(frame.origin() + outward * 0.5));
            model.set_curves(k, vec![circle(centre, 0.4, 4000)]);
        }
        let found = model.volume();
        let exact = PI * 0.16 * 3.5 * PI / 2.0;
        assert!((found.volume() - exact).abs() < 0.005 * exact, "{} {exact}", found.volume());
        assert!((found.volume() - exact).abs() <= found.error_bound().unwrap());
    }

    /// Every plane of a ball, or only some of them near its poles and few in between.
    #[test]
    fn every_gap_counts_with_its_own_interval() {
        let ball = |z: f64| disc((1.0 - z * z).max(0.0).sqrt());
        let all = model(0.0625, 0.0, ball);
        let some = |keep: fn(i64) -> bool| {
            let kept: Vec<PlaneIndex> = (-24..=24).filter(|k| keep(*k)).map(PlaneIndex).collect();
            let mut few = Model::new(LengthUnit::Metre, all.planes().clone()).with_selection(kept);
            for (k, section) in all.sections().filter(|(k, _)| keep(k.0)) {
                few.set_curves(k, section.curves().cloned().collect());
            }
            few.volume()
        };
        let exact = 4.0 / 3.0 * PI;
        let error = |found: &ModelVolume| (found.volume() - exact).abs();
        let (coarse, refined) =
            (some(|k| k % 8 == 0), some(|k| k % 8 == 0 || (k % 4 == 0) || k.abs() > 12));
        assert_eq!((coarse.runs.len(), refined.runs.len()), (1, 1));
        assert!(error(&refined) < 0.4 * error(&coarse), "{refined:?} {coarse:?}");
        assert!(error(&refined) <= refined.error_bound().unwrap());
        assert!(refined.error_bound() < coarse.error_bound());
        // The trapezoids by hand: planes at -1.5, -1, -0.5, ... 1.5.
        let by_hand: f64 = [-0.5_f64, 0.0, 0.5].iter().map(|z| 0.5 * PI * (1.0 - z * z)).sum();
        assert!((coarse.volume() - by_hand).abs() < 1e-4, "{} {by_hand}", coarse.volume());
        assert_eq!(some(|_| true), all.volume());
    }

    #[test]
    fn gaps_end_a_run_and_open_curves_take_the_bound_away() {
        let mut model = model(0.5, 0.0, |_| Vec::new());
        for k in [-3, 1, 2, 7] {
            model.set_curves(PlaneIndex(k), vec![rectangle(0.0, 0.0, 2.0, 1.0)]);
        }
        let volume = model.volume();
        let runs: Vec<_> =
            volume.runs.iter().map(|r| (r.planes.start().0, r.planes.end().0)).collect();
        assert_eq!(runs, [(-3, -3), (1, 2), (7, 7)]);
        assert_eq!((volume.volume(), volume.error_bound()), (4.0, Some(3.0)));
        model.insert_curve(PlaneIndex(2), strip());
        let volume = model.volume();
        assert_eq!((volume.volume(), volume.error_bound()), (4.0, None));
        assert_eq!(volume.runs[1].planes_with_open_curves, 1);
        model.set_curves(PlaneIndex(i64::MAX), vec![strip()]);
        assert_eq!(model.volume().runs.len(), 4);
    }
}
