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
//! smooth. Gaps and noise are not part of it: they make the areas, and so the volume, a bracket.
//!
//! The volume of clear space, such as a room or a tunnel, is summed in the same way.
//!
//! Along a curved guide a slice between two planes is thinner on the inside of the bend. Each area
//! counts with the spacing at its centre of mass, which is exact along a circular arc (Pappus).
//!
//! Selected planes without curves end a run, because free space there cannot be told from unseen
//! space.

use crate::measure::Bracket;
use crate::{Model, PlaneSelection, Section};
use std::ops::RangeInclusive;
use transect_geometry::{PlaneFamily, PlaneIndex, Point2};

/// A volume in the cube of the model's length unit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Volume {
    /// Bounds from the areas of the planes; its estimate has gaps closed by chords.
    pub bracket: Bracket,
    /// Largest error of the estimate from the interval alone, if the area only grows or only
    /// shrinks between neighbouring planes.
    pub interval_error: f64,
}

impl Volume {
    const NONE: Self = Self { bracket: Bracket::ZERO, interval_error: 0.0 };

    /// Adds the slice between two areas, half a step beside each.
    fn add(&mut self, half_step: f64, before: Bracket, after: Bracket) {
        self.bracket += before.times(half_step);
        self.bracket += after.times(half_step);
        self.interval_error += half_step * (after.estimate - before.estimate).abs();
    }
}

/// The volume of a model.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ModelVolume {
    /// Runs of neighbouring planes with curves, in order of station.
    pub runs: Vec<RangeInclusive<PlaneIndex>>,
    /// Volume of the solid.
    pub solid: Volume,
    /// Volume of the free space that solid surrounds across the guide.
    pub clear: Volume,
    /// Width of the widest gap on any plane; 0 without gaps.
    pub widest_gap: f64,
}

/// Solid and clear area of a plane, each scaled by the spacing of the planes there.
type Areas = [Bracket; 2];

/// Adds up the volume of planes in order of station, without keeping the planes.
#[derive(Debug)]
pub struct VolumeSum {
    planes: PlaneFamily,
    selection: PlaneSelection,
    volume: ModelVolume,
    /// The plane that was added last, and its areas.
    last: Option<(PlaneIndex, Areas)>,
}

impl VolumeSum {
    /// An empty sum for a family of planes and the selected ones among them.
    pub fn new(planes: &PlaneFamily, selection: &PlaneSelection) -> Self {
        let (solid, clear) = (Volume::NONE, Volume::NONE);
        let volume = ModelVolume { runs: Vec::new(), solid, clear, widest_gap: 0.0 };
        Self { planes: planes.clone(), selection: selection.clone(), volume, last: None }
    }

    /// Adds the next plane along the guide.
    pub fn add(&mut self, plane: PlaneIndex, section: &Section) {
        let measures = section.measures_within(self.planes.guide().usable_distance());
        let scaled = |area: Bracket, centroid| area.times(self.stretch(plane, centroid));
        let areas = [
            scaled(measures.solid, measures.solid_centroid),
            scaled(measures.clear, measures.clear_centroid),
        ];
        self.volume.widest_gap = self.volume.widest_gap.max(measures.widest_gap);
        let previous = self.selection.previous_before(plane);
        let before = match self.last.filter(|(last, _)| Some(*last) == previous) {
            Some((_, before)) => before,
            None => {
                self.end_run();
                self.volume.runs.push(plane..=plane);
                [Bracket::ZERO; 2]
            }
        };
        if let Some(run) = self.volume.runs.last_mut() {
            *run = *run.start()..=plane;
        }
        self.add_slice(self.selection.steps(plane).before, before, areas);
        self.last = Some((plane, areas));
    }

    /// Spacing of the planes at a point of a plane, over their spacing on the guide.
    fn stretch(&self, plane: PlaneIndex, centroid: Option<Point2>) -> f64 {
        let on_curve = self.planes.guide().curved().zip(centroid);
        on_curve.map_or(1.0, |(guide, centroid)| {
            let in_world = self.planes.frame(plane).world_from_plane(&centroid);
            guide.stretch(self.planes.station(plane), &in_world)
        })
    }

    fn add_slice(&mut self, steps: f64, before: Areas, after: Areas) {
        let half_step = 0.5 * steps * self.planes.interval();
        self.volume.solid.add(half_step, before[0], after[0]);
        self.volume.clear.add(half_step, before[1], after[1]);
    }

    /// The volume of all planes that were added.
    pub fn finish(mut self) -> ModelVolume {
        self.end_run();
        self.volume
    }

    /// After its last plane the run ends before the next selected one.
    fn end_run(&mut self) {
        if let Some((plane, areas)) = self.last {
            self.add_slice(self.selection.steps(plane).after, areas, [Bracket::ZERO; 2]);
        }
    }
}

impl Model {
    /// The volume of the solid and of the free space that it surrounds.
    pub fn volume(&self) -> ModelVolume {
        let mut sum = VolumeSum::new(self.planes(), self.selection());
        self.sections().for_each(|(plane, section)| sum.add(plane, section));
        sum.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{circle, polyline, rectangle, strip};
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
                let error = (found.solid.bracket.estimate - volume).abs();
                let bound = found.solid.interval_error;
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
        assert!(
            (found.solid.bracket.estimate - exact).abs() < 0.005 * exact,
            "{} {exact}",
            found.solid.bracket.estimate
        );
        assert!((found.solid.bracket.estimate - exact).abs() <= found.solid.interval_error);
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
        let error = |found: &ModelVolume| (found.solid.bracket.estimate - exact).abs();
        let (coarse, refined) =
            (some(|k| k % 8 == 0), some(|k| k % 8 == 0 || (k % 4 == 0) || k.abs() > 12));
        assert_eq!((coarse.runs.len(), refined.runs.len()), (1, 1));
        assert!(error(&refined) < 0.4 * error(&coarse), "{refined:?} {coarse:?}");
        assert!(error(&refined) <= refined.solid.interval_error);
        assert!(refined.solid.interval_error < coarse.solid.interval_error);
        // The trapezoids by hand: planes at -1.5, -1, -0.5, ... 1.5.
        let by_hand: f64 = [-0.5_f64, 0.0, 0.5].iter().map(|z| 0.5 * PI * (1.0 - z * z)).sum();
        assert!(
            (coarse.solid.bracket.estimate - by_hand).abs() < 1e-4,
            "{} {by_hand}",
            coarse.solid.bracket.estimate
        );
        assert_eq!(some(|_| true), all.volume());
    }

    #[test]
    fn planes_without_curves_end_a_run_and_gaps_widen_the_bracket() {
        let mut model = model(0.5, 0.0, |_| Vec::new());
        for k in [-3, 1, 2, 7] {
            model.set_curves(PlaneIndex(k), vec![rectangle(0.0, 0.0, 2.0, 1.0)]);
        }
        let volume = model.volume();
        let runs: Vec<_> = volume.runs.iter().map(|r| (r.start().0, r.end().0)).collect();
        assert_eq!(runs, [(-3, -3), (1, 2), (7, 7)]);
        let Volume { bracket, interval_error } = volume.solid;
        assert_eq!((bracket.least, bracket.most, interval_error), (4.0, Some(4.0), 3.0));
        let open = polyline(&[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)], false);
        model.set_curves(PlaneIndex(2), vec![open]);
        let bracket = model.volume().solid.bracket;
        let doubt = 0.5 * 0.5 * 5.0_f64.sqrt();
        assert_eq!(bracket.estimate, 4.0);
        assert!((bracket.least - (4.0 - doubt)).abs() < 1e-12, "{bracket:?}");
        assert!((bracket.most.unwrap() - (4.0 + doubt)).abs() < 1e-12, "{bracket:?}");
        model.set_curves(PlaneIndex(i64::MAX), vec![strip()]);
        assert_eq!(model.volume().runs.len(), 4);
    }

    #[test]
    fn a_room_has_a_positive_clear_volume() {
        let room = model(0.05, 0.025, |z| {
            let inside = (0.0..=2.5).contains(&z);
            inside.then(|| rectangle(0.0, 0.0, 5.0, 4.0).reversed()).into_iter().collect()
        });
        let found = room.volume();
        assert!((found.clear.bracket.estimate - 50.0).abs() < 1e-9, "{found:?}");
        assert_eq!((found.solid.bracket.least, found.solid.bracket.most), (0.0, None));
    }
}
