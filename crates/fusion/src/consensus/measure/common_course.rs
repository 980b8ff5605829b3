//! Common courses: moving least squares parabolas through the curves of all views.
//!
//! Courses go through beads, short pieces of each view's curves; they cost less than courses
//! through nodes. A view counts by the variance of its error, however densely it sampled (Alexa et
//! al., 2003, with one share per view). Direction tells surfaces apart, so both sides of a thin
//! wall stay.
//!
//! A straight course would cut bends. All views are cut alike, so more of them would not help. A
//! parabola keeps bends, but doubles the variance where nothing bends. What chance explains of a
//! bend is therefore taken out (Efron and Morris, 1973).

use super::super::tuning::settle::*;
use super::super::tuning::spread::MEDIAN_OF_NORMAL;
use super::super::window::{Window, left_of};
use super::course_fit::{Parabola, Sums};
use super::observations::{Observation, Observations, median};
use super::scale::Scale;
use super::view_error::ViewError;
use crate::grid::PointGrid;
use std::iter::repeat_n;
use transect_geometry::{Point2, Vector2};

/// The sizes of a common course and its windows. Lengths are those of a typical view; they go with
/// the error of the view whose course is sought.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    /// Half-length of a course.
    pub along: f64,
    /// Largest distance of a bead from the bead whose course is sought.
    pub across: f64,
    /// Errors of views, and the standard deviation of that of a typical view.
    pub of_view: ViewError,
    pub typical: f64,
    /// Half-lengths of all windows, in that of the narrowest.
    pub windows: &'static [f64],
    /// Cosine of the largest angle between beads of one surface.
    pub same_way: f64,
}

impl Reach {
    /// The reach that views with these errors need.
    pub fn new(of_view: ViewError, typical: f64, scale: &Scale) -> Self {
        Self {
            along: ALONG_ERRORS * typical,
            across: ACROSS_ERRORS * typical,
            of_view,
            typical,
            windows: if scale.steps().wider_courses { &WINDOWS } else { &WINDOWS[..1] },
            same_way: scale.same_way,
        }
    }

    /// A window this many times as long.
    fn times(&self, factor: f64) -> Self {
        Self { along: factor * self.along, ..*self }
    }

    /// The reach for a bead of this variance.
    fn at(&self, variance: f64) -> Self {
        let factor = variance.sqrt().clamp(LARGEST_REACH.recip(), LARGEST_REACH);
        Self { along: factor * self.along, across: factor * self.across, ..*self }
    }

    /// Variance of the error of an observation, its own included, in that of a typical view.
    fn variance(&self, of: &Observation) -> f64 {
        (of.view_variance(&self.of_view) + of.sigma * of.sigma) / (self.typical * self.typical)
    }
}

/// Length of the common course of a view whose error has this standard deviation.
pub(crate) fn course_length(error: f64) -> f64 {
    2.0 * ALONG_ERRORS * error
}

/// A short piece of a view's curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bead {
    /// Weighted mean of its observations.
    pub position: Point2,
    /// Unit vector: their weighted mean direction.
    pub tangent: Vector2,
    /// Length that its observations stand for.
    pub length: f64,
    /// Variance of its view's error, in that of a typical view.
    pub variance: f64,
    pub view: u32,
    /// Whether it goes on where the bead before it ends.
    pub follows: bool,
    /// How far its view is off the common course, averaged over the window, and the variance of
    /// this in that of a typical view. A view takes part in the course that it is compared with.
    pub off: f64,
    pub off_variance: f64,
    bend: Bend,
    /// Number of typical views that would know the common course as well. A view that measured a
    /// part of the window counts in part.
    pub views: f64,
}

/// The bend of a common course at a bead.
#[derive(Debug, Clone, Copy, Default)]
struct Bend {
    /// The course's second derivative.
    curvature: f64,
    /// By how much the bend moves the course across the bead, and turns it there.
    offset: f64,
    slope: f64,
    /// How far the bead's view is off, as its own bend shows it: a length.
    off: f64,
    /// Standard deviation of the curvature if views were off by 1.
    chance: f64,
}

impl Bend {
    /// The bend of a course of so many views, beside that of one view alone, in a window of this
    /// half-length. Courses move beads by `most` at most.
    fn new(course: &Parabola, alone: &Parabola, views: f64, half: f64, most: f64) -> Self {
        let in_space = 2.0 / (half * half);
        let known = views * course.bent;
        Self {
            curvature: in_space * course.bend,
            offset: course.offset.clamp(-most, most) - course.straight_offset.clamp(-most, most),
            slope: (course.slope - course.straight_slope) / half,
            off: (alone.bend - course.bend) * alone.bent.sqrt(),
            chance: if known > 0.0 { in_space / known.sqrt() } else { 0.0 },
        }
    }
}

impl Bead {
    /// The bead, moved onto the course through the beads of all views in its window.
    fn on_course_of(&self, views: impl Iterator<Item = Sums>, own: &Sums, window: &Window) -> Self {
        let (mut common, mut variance) = (Sums::default(), 0.0);
        for view in views {
            variance += view.added_variance();
            common.add_view(&view);
        }
        let has_length = common.length > 0.0;
        let views = if has_length { common.length.powi(2) / variance } else { 1.0 };
        let (course, alone) = (common.parabola(), own.parabola());
        let (normal, across) = (window.normal(), window.across);
        let turned = self.tangent + normal * (course.slope * window.reach.recip());
        Self {
            position: self.position + normal * course.offset.clamp(-across, across),
            tangent: turned.normalize(),
            off: own.mean_off(&course),
            off_variance: own.mean_variance() * (1.0 - 2.0 * own.share() / common.length)
                + 1.0 / views,
            bend: Bend::new(&course, &alone, views, window.reach, across),
            views,
            ..*self
        }
    }

    /// Whether the distance from the course tells something of its view's error.
    pub fn tells_error(&self) -> bool {
        self.length > 0.0 && self.off_variance > LEAST_OFF_VARIANCE
    }

    /// Takes in the bead that follows.
    fn join(&mut self, next: &Self) {
        let length = self.length + next.length;
        let share = if length > 0.0 { next.length / length } else { 0.5 };
        self.position += (next.position - self.position) * share;
        let tangent = self.tangent + (next.tangent - self.tangent) * share;
        self.tangent = tangent.try_normalize(0.0).unwrap_or(self.tangent);
        self.variance += (next.variance - self.variance) * share;
        self.length = length;
    }

    /// The bead, moved across its direction onto the course of a bead that it is part of.
    fn onto(&self, course: &Self) -> Self {
        let (normal, across) = (left_of(&self.tangent), left_of(&course.tangent));
        let offset = self.position - course.position;
        let x = course.tangent.dot(&offset);
        let off = 0.5 * course.bend.curvature * x * x - across.dot(&offset);
        let tangent = (course.tangent + across * (course.bend.curvature * x)).normalize();
        // The course may have turned away from the bead by its slope.
        let cosine = tangent.dot(&self.tangent).max(JOINED_COSINE);
        Self { position: self.position + normal * (off / cosine), tangent, ..*course }
    }

    /// Takes out as much of the bend as chance explains, where `bead` moved onto this course: the
    /// square of what is seen holds that of the bend and that of its error. `error` is how far a
    /// view is off, as bends show it.
    fn straighten(&mut self, bead: &Self, error: f64) {
        let chance = error * self.bend.chance / self.bend.curvature.abs().max(f64::MIN_POSITIVE);
        let out = (chance * chance).min(1.0);
        let normal = left_of(&bead.tangent);
        self.position -= normal * (out * self.bend.offset);
        self.tangent = (self.tangent - normal * (out * self.bend.slope)).normalize();
        self.bend.curvature *= 1.0 - out;
    }

    /// Moves the bead from its course towards that of a wider window, the less the farther apart
    /// both are. `largest_step` is the largest distance by chance for a course of one view.
    fn move_towards(&mut self, wider: &Self, largest_step: f64) {
        let step = wider.position - self.position;
        let steps = step.norm() * self.views.sqrt() / largest_step.max(f64::MIN_POSITIVE);
        // Tukey's biweight.
        let trust = (1.0 - steps * steps).max(0.0).powi(2);
        self.position += step * trust;
        let turned = self.tangent + (wider.tangent - self.tangent) * trust;
        self.tangent = turned.try_normalize(0.0).unwrap_or(self.tangent);
    }
}

/// Cuts the views' curves into beads, and says which bead each observation is in.
pub(super) fn beads(observations: &Observations, reach: &Reach) -> (Vec<Bead>, Vec<u32>) {
    let all = &observations.all;
    let length_at =
        |k: usize| all.get(k).map_or(0.0, |o| reach.at(reach.variance(o)).along / BEADS_PER_REACH);
    let (mut beads, mut bead_of) = (Vec::new(), Vec::with_capacity(all.len()));
    let (mut start, mut begun, mut length) = (0, false, length_at(0));
    for k in 0..all.len() {
        bead_of.push(beads.len() as u32);
        let follows = all[k].next as usize == k + 1 && !all[k].bridged;
        let fits = |next: &Point2| (next - all[start].position).norm() <= length;
        if !(follows && fits(&all[k + 1].position)) {
            beads.push(Bead { follows: begun, ..bead(&all[start..=k], reach) });
            (start, begun, length) = (k + 1, follows, length_at(k + 1));
        }
    }
    (beads, bead_of)
}

/// Joins up to `most` beads that follow each other in one direction. Each longer bead comes with
/// the number of beads it is made of.
pub(super) fn joined(beads: &[Bead], most: usize) -> Vec<(usize, Bead)> {
    let mut joined: Vec<(usize, Bead)> = Vec::with_capacity(beads.len() / most + 1);
    for bead in beads {
        match joined.last_mut() {
            Some((count, last))
                if *count < most
                    && bead.follows
                    && bead.tangent.dot(&last.tangent) >= JOINED_COSINE =>
            {
                last.join(bead);
                *count += 1;
            }
            _ => joined.push((1, *bead)),
        }
    }
    joined
}

fn bead(members: &[Observation], reach: &Reach) -> Bead {
    let first = &members[0];
    let (mut length, mut place, mut tangent) = (0.0, Vector2::zeros(), Vector2::zeros());
    let mut variance = 0.0;
    for o in members {
        let weight = o.support * o.footprint;
        length += weight;
        variance += weight * reach.variance(o);
        place += (o.position - first.position) * weight;
        tangent += o.tangent * weight;
    }
    Bead {
        position: first.position + place / length.max(f64::MIN_POSITIVE),
        tangent: tangent.try_normalize(0.0).unwrap_or(first.tangent),
        length,
        variance: if length > 0.0 { variance / length } else { reach.variance(first) },
        view: first.view,
        follows: false,
        off: 0.0,
        off_variance: 0.0,
        bend: Bend::default(),
        views: 1.0,
    }
}

/// Standard deviation of a view's error, averaged over a window, from what the first courses left.
/// Unlike the spread between nodes beside each other, it is not cut at the search distance.
pub(super) fn averaged_view_error(beads: &[Bead]) -> f64 {
    let known = beads.iter().filter(|bead| bead.tells_error());
    median(known.map(|bead| bead.off.abs() / bead.off_variance.sqrt())) / MEDIAN_OF_NORMAL
}

/// How far views are off, apart from shifts, in each window. The first round measures it, since
/// beads that have moved no longer show it.
#[derive(Debug, Default)]
pub(super) struct ViewErrors {
    /// As the bends of each window show it.
    bends: Vec<f64>,
    /// As the distances from the courses of each wider window and of the narrower one show it.
    waves: Vec<f64>,
}

/// The beads, each moved onto the course of the widest window whose course agrees with that of the
/// narrower ones. Errors that change along a surface average out over several of their lengths,
/// while a wide window flattens what bends more than a parabola.
pub(super) fn on_widest_courses(
    beads: &[Bead],
    views: usize,
    reach: &Reach,
    errors: &mut ViewErrors,
) -> Vec<Bead> {
    let mut moved: Option<Vec<Bead>> = None;
    for (number, factor) in reach.windows.iter().enumerate() {
        let (window, most) = (reach.times(*factor), *factor as usize);
        let courses = on_courses_of_joined(beads, views, &window, most, |courses| {
            known(&mut errors.bends, number, || bend_error(courses))
        });
        let Some(narrower) = &mut moved else {
            moved = Some(courses);
            continue;
        };
        let wave = known(&mut errors.waves, number - 1, || wave_error(narrower, &courses));
        for (bead, course) in narrower.iter_mut().zip(&courses) {
            bead.move_towards(course, WAVE_CUT * wave);
        }
    }
    moved.unwrap_or_else(|| beads.to_vec())
}

/// A value that is measured once.
fn known(values: &mut Vec<f64>, number: usize, measure: impl FnOnce() -> f64) -> f64 {
    if number == values.len() {
        values.push(measure());
    }
    values[number]
}

/// The beads, each moved onto the course of the longer bead that it is part of. Wide windows
/// through long beads cost less than narrow ones through short beads.
fn on_courses_of_joined(
    beads: &[Bead],
    views: usize,
    reach: &Reach,
    most: usize,
    bend_error: impl FnOnce(&[Bead]) -> f64,
) -> Vec<Bead> {
    let (counts, joined): (Vec<_>, Vec<_>) = joined(beads, most).into_iter().unzip();
    let mut courses = on_common_courses(&joined, views, reach);
    let error = bend_error(&courses);
    for (course, bead) in courses.iter_mut().zip(&joined) {
        course.straighten(bead, error);
    }
    let courses =
        counts.into_iter().zip(&courses).flat_map(|(count, course)| repeat_n(course, count));
    beads.iter().zip(courses).map(|(bead, course)| bead.onto(course)).collect()
}

/// Standard deviation of a view's error, as bends show it.
fn bend_error(courses: &[Bead]) -> f64 {
    let known = courses.iter().filter(|bead| bead.tells_error());
    median(known.map(|bead| bead.bend.off.abs() / bead.off_variance.sqrt())) / MEDIAN_OF_NORMAL
}

/// Standard deviation by which a view's distance from the common course differs between a window
/// and a wider one. A bend moves the view and the common course alike, and a wrong pose shifts the
/// view in both windows alike, so neither has a part in it.
fn wave_error(narrow: &[Bead], wide: &[Bead]) -> f64 {
    let known = narrow.iter().zip(wide).filter(|(n, w)| n.tells_error() && w.tells_error());
    median(known.map(|(n, w)| (n.off - w.off).abs() / n.off_variance.sqrt())) / MEDIAN_OF_NORMAL
}

/// The beads, each moved onto the course through those around it.
pub(super) fn on_common_courses(beads: &[Bead], views: usize, reach: &Reach) -> Vec<Bead> {
    let grid = |beads: &[Bead]| {
        let places: Vec<Point2> = beads.iter().map(|bead| bead.position).collect();
        PointGrid::new(&places, 0.5 * reach.along)
    };
    // Beads in the order of the grid's cells lie in memory as they are gathered.
    let order: Vec<usize> = grid(beads).order().collect();
    let sorted: Vec<Bead> = order.iter().map(|&k| beads[k]).collect();
    let mut result = beads.to_vec();
    let (beads, grid) = (&sorted, grid(&sorted));
    let (mut of_view, mut met) = (vec![Sums::default(); views], Vec::new());
    for (k, bead) in order.into_iter().zip(beads) {
        let Reach { along: half, across, same_way, .. } = reach.at(bead.variance);
        let per_half = half.recip();
        let (centre, tangent) = (bead.position, bead.tangent);
        let window = Window { centre, tangent, reach: half, across, same_way };
        grid.runs_around(&centre, &window.half(), |points| {
            let Some(first) = points.first() else { return };
            let run = &beads[first.number as usize..][..points.len()];
            let goes_along = |there: &Bead| window.goes_along(&there.tangent);
            window.visit_run(
                run,
                |there| there.position,
                goes_along,
                |there, x, y| {
                    let sums = &mut of_view[there.view as usize];
                    if sums.length == 0.0 {
                        met.push(there.view);
                    }
                    let x = x * per_half;
                    sums.add((1.0 - x.abs()) * there.length * per_half, x, y, there.variance);
                },
            );
        });
        let own = of_view[bead.view as usize];
        let all = met.drain(..).map(|view| std::mem::take(&mut of_view[view as usize]));
        result[k] = bead.on_course_of(all, &own, &window);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn reach(along: f64, across: f64, same_way: f64) -> Reach {
        let of_view = ViewError::default();
        Reach { along, across, of_view, typical: 1.0, windows: &[1.0], same_way }
    }

    /// Beads along an arc of a view: angles in parts of a circle of radius 1.
    fn arc(view: u32, parts: u32, count: u32, radius: f64) -> Vec<Bead> {
        let bead = |k: u32| {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(parts)).sin_cos();
            Bead {
                position: Point2::new(radius * cos, radius * sin),
                tangent: Vector2::new(-sin, cos),
                length: radius * TAU / f64::from(parts),
                variance: 1.0,
                view,
                follows: k > 0,
                off: 0.0,
                off_variance: 0.0,
                bend: Bend::default(),
                views: 1.0,
            }
        };
        (0..count).map(bead).collect()
    }

    #[test]
    fn beads_are_joined_along_one_direction_of_one_curve() {
        let counts = |beads: &[Bead], most| -> Vec<usize> {
            joined(beads, most).iter().map(|(count, _)| *count).collect()
        };
        let straight = arc(0, 3600, 9, 1.0);
        assert_eq!(counts(&straight, 4), [4, 4, 1]);
        let two_curves = [&straight[..3], &straight[..3]].concat();
        assert_eq!(counts(&two_curves, 4), [3, 3], "a curve ends");
        assert_eq!(counts(&arc(0, 8, 4, 1.0), 4), [1; 4], "the direction turns");
        let length = |beads: Vec<(usize, Bead)>| beads.iter().map(|(_, b)| b.length).sum::<f64>();
        let short: f64 = straight.iter().map(|bead| bead.length).sum();
        assert!((length(joined(&straight, 4)) - short).abs() < 1e-12);
    }

    #[test]
    fn courses_through_joined_beads_are_those_through_all_beads() {
        // Five views of a gentle bend, which err by different lengths.
        let views = 5;
        let of_view = |view: u32| arc(view, 3000, 300, 1.0 + 0.002 * f64::from(view * view % 5));
        let beads: Vec<Bead> = (0..views).flat_map(of_view).collect();
        let reach = reach(0.05, 0.03, 0.8);
        let slow = on_common_courses(&beads, views as usize, &reach);
        let fast = on_courses_of_joined(&beads, views as usize, &reach, 4, |_| 0.0);
        for (k, (slow, fast)) in slow.iter().zip(&fast).enumerate() {
            // At the ends of the curves both windows hold other beads.
            let inside = (30..270).contains(&(k % 300));
            let apart = left_of(&slow.tangent).dot(&(slow.position - fast.position));
            assert!(!inside || apart.abs() < 1e-4, "bead {k}: {apart}");
            assert!(!inside || (slow.off - fast.off).abs() < 2e-4, "bead {k}");
            assert!(!inside || slow.tangent.dot(&fast.tangent) > 0.99999, "bead {k}");
        }
    }

    #[test]
    fn courses_follow_a_bend() {
        // Seven views of a circle of radius 1, which err by 0.03 in the mean of squares.
        let errors = [-0.045, -0.03, -0.015, 0.0, 0.015, 0.03, 0.045];
        let of_view = |(view, error): (u32, &f64)| arc(view, 600, 600, 1.0 + error);
        let beads: Vec<Bead> = (0..).zip(&errors).flat_map(of_view).collect();
        let narrow = reach(0.24, 0.19, 0.64);
        for (reach, limit) in [(narrow, 0.0005), (narrow.times(2.0), 0.0015)] {
            let courses = on_common_courses(&beads, errors.len(), &reach);
            let radii = courses.iter().map(|bead| bead.position.coords.norm());
            let (least, most) = radii.fold((f64::MAX, 0.0_f64), |(a, b), r| (a.min(r), b.max(r)));
            // A straight course would lie inside by half² / 12: 0.005 and 0.019.
            assert!(1.0 - limit < least && most < 1.0 + limit, "{least} {most}");
            assert!(courses.iter().all(|bead| (bead.bend.curvature - 1.0).abs() < 0.05));
        }
    }

    #[test]
    fn what_chance_explains_of_a_bend_is_taken_out() {
        let bead = arc(0, 60, 2, 1.0)[0];
        let bend = Bend { curvature: 2.0, offset: 0.01, slope: 0.1, off: 0.0, chance: 1.0 };
        let bent = Bead { position: bead.position + left_of(&bead.tangent) * 0.01, bend, ..bead };
        // Errors of nothing, half, all and twice of the bend, and the share of it that stays.
        for (error, stays) in [(0.0, 1.0), (1.0, 0.75), (2.0, 0.0), (4.0, 0.0)] {
            let mut straight = bent;
            straight.straighten(&bead, error);
            let off = left_of(&bead.tangent).dot(&(straight.position - bead.position));
            assert!((off - 0.01 * stays).abs() < 1e-12 && off.is_finite());
            assert!((straight.bend.curvature - 2.0 * stays).abs() < 1e-12);
        }
    }
}
