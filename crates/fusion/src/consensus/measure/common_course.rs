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
//!
//! Views that saw a place have beads beside each other there, and their windows hold nearly the
//! same beads. So a course is sought for one of them and serves those beside it.

use super::super::tuning::settle::*;
use super::super::tuning::spread::MEDIAN_OF_NORMAL;
use super::super::window::{Window, left_of};
use super::bead::{Bead, joined};
use super::course_fit::{Parabola, Sums};
use super::observations::median;
use super::reach::Reach;
use crate::grid::PointGrid;
use std::iter::repeat_n;
use transect_geometry::{Point2, Vector2};

/// A bead on the common course of its window.
#[derive(Debug, Clone, Copy)]
pub(super) struct OnCourse {
    /// The bead, moved onto the course.
    pub bead: Bead,
    /// How far its view is off the common course, averaged over the window, and the variance of
    /// this over that of a typical view. A view takes part in the course that it is compared with.
    pub off: f64,
    off_variance: f64,
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
    /// By how much the bend moves the bead across its window, and turns it there. Unit vector: the
    /// direction across.
    offset: f64,
    slope: f64,
    across: Vector2,
    /// How far the bead's view is off, as its own bend shows it: a length. `None` if the view
    /// measured too short a part of the window to tell a bend.
    off: Option<f64>,
    /// Standard deviation of the curvature if views were off by 1.
    chance: f64,
}

impl OnCourse {
    /// A bead that stays where it is.
    fn unmoved(bead: &Bead) -> Self {
        Self { bead: *bead, off: 0.0, off_variance: 0.0, bend: Bend::default(), views: 1.0 }
    }

    /// Whether the distance from the course tells something of its view's error.
    pub fn tells_error(&self) -> bool {
        self.bead.length > 0.0 && self.off_variance > LEAST_OFF_VARIANCE
    }

    /// The course at a bead that is part of this one: the bead moves onto it, across its direction.
    fn at(&self, bead: &Bead) -> Self {
        let (normal, across) = (left_of(&bead.tangent), left_of(&self.bead.tangent));
        let offset = bead.position - self.bead.position;
        let x = self.bead.tangent.dot(&offset);
        let off = 0.5 * self.bend.curvature * x * x - across.dot(&offset);
        let tangent = (self.bead.tangent + across * (self.bend.curvature * x)).normalize();
        // The course may have turned away from the bead by its slope.
        let cosine = tangent.dot(&bead.tangent).max(JOINED_COSINE);
        let position = bead.position + normal * (off / cosine);
        Self { bead: Bead { position, tangent, ..*bead }, ..*self }
    }

    /// Takes out as much of the bend as chance explains: the square of what is seen holds that of
    /// the bend and that of its error. `error` is how far a view is off, as bends show it.
    fn straighten(&mut self, error: f64) {
        let Self { bead, bend, .. } = self;
        let chance = error * bend.chance / bend.curvature.abs().max(f64::MIN_POSITIVE);
        let out = (chance * chance).min(1.0);
        bead.position -= bend.across * (out * bend.offset);
        bead.tangent = (bead.tangent - bend.across * (out * bend.slope)).normalize();
        bend.curvature *= 1.0 - out;
    }

    /// Moves the bead from its course towards that of a wider window, the less the farther apart
    /// both are. `largest_step` is the largest distance by chance for a course of one view.
    fn move_towards(&mut self, wider: &Self, largest_step: f64) {
        let step = wider.bead.position - self.bead.position;
        let steps = step.norm() * self.views.sqrt() / largest_step.max(f64::MIN_POSITIVE);
        // Tukey's biweight.
        let trust = (1.0 - steps * steps).max(0.0).powi(2);
        self.bead.position += step * trust;
        let tangent = self.bead.tangent;
        let turned = tangent + (wider.bead.tangent - tangent) * trust;
        self.bead.tangent = turned.try_normalize(0.0).unwrap_or(tangent);
    }
}

/// Standard deviation of a view's error, averaged over a window, from what the first courses left.
/// Unlike the spread between nodes beside each other, it is not cut at the search distance.
pub(super) fn averaged_view_error(courses: &[OnCourse]) -> f64 {
    let known = courses.iter().filter(|course| course.tells_error());
    median(known.map(|course| course.off.abs() / course.off_variance.sqrt())) / MEDIAN_OF_NORMAL
}

/// How far views are off, apart from shifts, in each window. The first round measures it, since
/// beads that have moved no longer show it.
#[derive(Debug, Default)]
pub(super) struct ViewErrors {
    /// As the bends of each window show it.
    bends: Vec<f64>,
    /// As the distances from the courses of each wider window and of the narrowest one show it.
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
) -> Vec<OnCourse> {
    let mut moved: Option<Vec<OnCourse>> = None;
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
    moved.unwrap_or_default()
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
    bend_error: impl FnOnce(&[OnCourse]) -> f64,
) -> Vec<OnCourse> {
    let (counts, joined): (Vec<_>, Vec<_>) = joined(beads, most).into_iter().unzip();
    let mut courses = on_common_courses(&joined, views, reach);
    let error = bend_error(&courses);
    courses.iter_mut().for_each(|course| course.straighten(error));
    let courses =
        counts.into_iter().zip(&courses).flat_map(|(count, course)| repeat_n(course, count));
    beads.iter().zip(courses).map(|(bead, course)| course.at(bead)).collect()
}

/// Standard deviation of a view's error, as bends show it.
fn bend_error(courses: &[OnCourse]) -> f64 {
    let known = courses.iter().filter(|course| course.tells_error());
    let off = |c: &OnCourse| Some(c.bend.off?.abs() / c.off_variance.sqrt());
    median(known.filter_map(off)) / MEDIAN_OF_NORMAL
}

/// Standard deviation by which a view's distance from the common course differs between a window
/// and a wider one. A bend moves the view and the common course alike, and a wrong pose shifts the
/// view in both windows alike, so neither has a part in it.
fn wave_error(narrow: &[OnCourse], wide: &[OnCourse]) -> f64 {
    let known = narrow.iter().zip(wide).filter(|(n, w)| n.tells_error() && w.tells_error());
    median(known.map(|(n, w)| (n.off - w.off).abs() / n.off_variance.sqrt())) / MEDIAN_OF_NORMAL
}

/// The beads, each moved onto the course through those around it.
pub(super) fn on_common_courses(beads: &[Bead], views: usize, reach: &Reach) -> Vec<OnCourse> {
    courses_shared_by(beads, views, reach, beside)
}

/// Whether a bead's course also serves another bead, at this place (x, y) in its window.
fn beside(bead: &Bead, other: &Bead, window: &Window, x: f64, y: f64) -> bool {
    let alike = |a: &Bead, b: &Bead| a.variance <= SHARED_VARIANCE * b.variance;
    x.abs() <= SHARED_ALONG * window.reach
        && y.abs() <= SHARED_ACROSS * window.across
        && bead.tangent.dot(&other.tangent) >= JOINED_COSINE
        && alike(bead, other)
        && alike(other, bead)
}

/// The beads, each moved onto a course: that of its own window, or that of another bead if both
/// share it.
fn courses_shared_by(
    beads: &[Bead],
    views: usize,
    reach: &Reach,
    shares: impl Fn(&Bead, &Bead, &Window, f64, f64) -> bool,
) -> Vec<OnCourse> {
    let places: Vec<Point2> = beads.iter().map(|bead| bead.position).collect();
    let grid = PointGrid::new(&places, 0.5 * reach.along);
    // Beads in the order of the grid's cells lie in memory as they are gathered.
    let order: Vec<usize> = grid.order().collect();
    let sorted: Vec<Bead> = order.iter().map(|&k| beads[k]).collect();
    let grid = grid.renumbered();
    let mut courses: Vec<OnCourse> = beads.iter().map(OnCourse::unmoved).collect();
    let mut has_course = vec![false; beads.len()];
    let mut sums = SumsOfViews::new(views);
    let mut served = Vec::new();
    for (k, bead) in sorted.iter().enumerate() {
        if has_course[k] {
            continue;
        }
        let Reach { along, across, same_way, .. } = reach.at(bead.variance);
        let (centre, tangent) = (bead.position, bead.tangent);
        let window = Window { centre, tangent, reach: along, across, same_way };
        served.clear();
        served.push(k);
        sums.gather(&sorted, &grid, &window, |number, other, x, y| {
            if !has_course[number] && number != k && shares(bead, other, &window, x, y) {
                served.push(number);
            }
        });
        let course = sums.course(&window);
        for &number in &served {
            has_course[number] = true;
            let bead = &sorted[number];
            courses[order[number]] = course.moved(bead, &sums.of_view[bead.view as usize]);
        }
    }
    courses
}

/// The sums of a window, by views.
struct SumsOfViews {
    of_view: Vec<Sums>,
    /// The views whose sums are not empty.
    met: Vec<u32>,
}

impl SumsOfViews {
    fn new(views: usize) -> Self {
        Self { of_view: vec![Sums::default(); views], met: Vec::new() }
    }

    /// Takes the sums of another window. `visit` gets each bead inside: its number, the bead, and
    /// its place along (x) and across (y).
    fn gather(
        &mut self,
        beads: &[Bead],
        grid: &PointGrid,
        window: &Window,
        mut visit: impl FnMut(usize, &Bead, f64, f64),
    ) {
        self.met.drain(..).for_each(|view| self.of_view[view as usize] = Sums::default());
        let per_half = window.reach.recip();
        grid.runs_around(&window.centre, &window.half(), |points| {
            let Some(first) = points.first().map(|point| point.number as usize) else { return };
            let goes_along = |there: &Bead| window.goes_along(&there.tangent);
            let run = &beads[first..][..points.len()];
            window.visit_run(
                run,
                |there| there.position,
                goes_along,
                |number, there, x, y| {
                    visit(first + number, there, x, y);
                    let x = x * per_half;
                    let length = (1.0 - x.abs()) * there.length * per_half;
                    if length > 0.0 {
                        let sums = &mut self.of_view[there.view as usize];
                        if sums.length == 0.0 {
                            self.met.push(there.view);
                        }
                        sums.add(length, x, y, there.variance);
                    }
                },
            );
        });
    }

    /// The common course of the views.
    fn course<'a>(&self, window: &'a Window) -> Course<'a> {
        let (mut common, mut variance) = (Sums::default(), 0.0);
        for view in self.met.iter().map(|view| &self.of_view[*view as usize]) {
            variance += view.added_variance();
            common.add_view(view);
        }
        let length = common.length;
        let views = if length > 0.0 { length.powi(2) / variance } else { 1.0 };
        Course { window, parabola: common.parabola(), length, views }
    }
}

/// The common course of a window.
struct Course<'a> {
    window: &'a Window,
    parabola: Parabola,
    /// Sum of the weights of its views.
    length: f64,
    /// As in [`OnCourse`].
    views: f64,
}

impl Course<'_> {
    /// A bead of the window, moved onto the course, beside the sums of its view.
    fn moved(&self, bead: &Bead, own: &Sums) -> OnCourse {
        let Self { window: Window { reach, across, .. }, parabola, .. } = self;
        let (x, y) = self.window.place(&bead.position);
        let (x, normal) = (x / reach, self.window.normal());
        let (slope, alone) = (parabola.slope_at(x), own.parabola());
        // A course moves beads by as much at most.
        let step = |course: f64| (course - y).clamp(-across, *across);
        let offset = step(parabola.at(x));
        let in_space = 2.0 / (reach * reach);
        let known = self.views * parabola.bent;
        let tells_bend = alone.bent > 0.0 && parabola.bent > 0.0;
        OnCourse {
            bead: Bead {
                position: bead.position + normal * offset,
                tangent: (self.window.tangent + normal * (slope / reach)).normalize(),
                ..*bead
            },
            off: own.mean_off(parabola),
            off_variance: own.mean_variance() * (1.0 - 2.0 * own.share() / self.length)
                + 1.0 / self.views,
            bend: Bend {
                curvature: in_space * parabola.bend,
                offset: offset - step(parabola.straight_at(x)),
                slope: (slope - parabola.straight_slope) / reach,
                across: normal,
                off: tells_bend.then(|| (alone.bend - parabola.bend) * alone.bent.sqrt()),
                chance: if known > 0.0 { in_space / known.sqrt() } else { 0.0 },
            },
            views: self.views,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bead::tests::arc;
    use super::super::view_error::ViewError;
    use super::*;
    use std::collections::HashSet;

    fn reach(along: f64, across: f64, same_way: f64) -> Reach {
        let of_view = ViewError::default();
        Reach { along, across, of_view, typical: 1.0, windows: &[1.0], same_way }
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
            let apart = left_of(&slow.bead.tangent).dot(&(slow.bead.position - fast.bead.position));
            assert!(!inside || apart.abs() < 1e-4, "bead {k}: {apart}");
            assert!(!inside || (slow.off - fast.off).abs() < 2e-4, "bead {k}");
            assert!(!inside || slow.bead.tangent.dot(&fast.bead.tangent) > 0.99999, "bead {k}");
        }
    }

    #[test]
    fn a_shared_course_is_that_of_each_bead_alone() {
        // Two surfaces beside each other, and views that err by different lengths.
        let views = 6;
        let of_view = |view: u32| {
            let of_surface = if view < 3 { 1.0 } else { 1.05 };
            arc(view, 3000 + view, 300, of_surface + 0.002 * f64::from(view % 3))
        };
        let beads: Vec<Bead> = (0..views).flat_map(of_view).collect();
        let reach = reach(0.05, 0.03, 0.8);
        let shared = on_common_courses(&beads, views as usize, &reach);
        let alone = courses_shared_by(&beads, views as usize, &reach, |_, _, _, _, _| false);
        let different = |courses: &[OnCourse]| {
            let curvatures = courses.iter().map(|course| course.bend.curvature.to_bits());
            curvatures.collect::<HashSet<_>>().len()
        };
        assert!(3 * different(&shared) < different(&alone), "{}", different(&shared));
        for (k, (shared, alone)) in shared.iter().zip(&alone).enumerate() {
            let apart = (shared.bead.position - alone.bead.position).norm();
            let turned = (shared.bead.tangent - alone.bead.tangent).norm();
            let off = (shared.off - alone.off).abs();
            // At the ends of the curves the windows of neighbours hold other parts of them.
            let inside = (30..270).contains(&(k % 300));
            let limits = if inside { [2e-5, 1e-3, 2e-5] } else { [2e-4, 1e-2, 2e-4] };
            let found = [apart, turned, off];
            assert!(found.iter().zip(limits).all(|(f, limit)| *f < limit), "bead {k}: {found:?}");
            assert_eq!(shared.bead.view, alone.bead.view);
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
            let radii = courses.iter().map(|c| c.bead.position.coords.norm());
            let (least, most) = radii.fold((f64::MAX, 0.0_f64), |(a, b), r| (a.min(r), b.max(r)));
            // A straight course would lie inside by half² / 12: 0.005 and 0.019.
            assert!(1.0 - limit < least && most < 1.0 + limit, "{least} {most}");
            assert!(courses.iter().all(|course| (course.bend.curvature - 1.0).abs() < 0.05));
        }
    }

    #[test]
    fn windows_that_tell_no_bend_say_nothing_of_the_error_of_bends() {
        let bead = arc(0, 60, 2, 1.0)[0];
        let with = |off: Option<f64>| {
            let bend = Bend { off, ..Bend::default() };
            OnCourse { off_variance: 1.0, bend, ..OnCourse::unmoved(&bead) }
        };
        let courses = [None, Some(-0.2), None, None].map(with);
        assert!((bend_error(&courses) * MEDIAN_OF_NORMAL - 0.2).abs() < 1e-12);
        assert_eq!(bend_error(&[None, None].map(with)), 0.0);
    }

    #[test]
    fn what_chance_explains_of_a_bend_is_taken_out() {
        let bead = arc(0, 60, 2, 1.0)[0];
        let across = left_of(&bead.tangent);
        let bend =
            Bend { curvature: 2.0, offset: 0.01, slope: 0.1, across, off: None, chance: 1.0 };
        let moved = Bead { position: bead.position + across * 0.01, ..bead };
        let bent = OnCourse { bend, ..OnCourse::unmoved(&moved) };
        // Errors of nothing, half, all and twice of the bend, and the share of it that stays.
        for (error, stays) in [(0.0, 1.0), (1.0, 0.75), (2.0, 0.0), (4.0, 0.0)] {
            let mut straight = bent;
            straight.straighten(error);
            let off = across.dot(&(straight.bead.position - bead.position));
            assert!((off - 0.01 * stays).abs() < 1e-12 && off.is_finite());
            assert!((straight.bend.curvature - 2.0 * stays).abs() < 1e-12);
        }
    }
}
