//! Where a view belongs that is far off.
//!
//! **Problem.** Rays of a view that is turned by ten degrees meet other surfaces, or none. Least
//! squares from there on end anywhere.
//!
//! **Idea.** Two points with their normals fix a pose, and the distance and the angles between them
//! do not depend on it (Drost, Ulrich, Navab and Ilic, 2010). Wherever two points of the other
//! views have the shape of two of the view's own, there is a pose. Few of these poses bring most of
//! the view onto the others.
//!
//! **Steps.**
//! 1. The view and those that are right are thinned to points with normals (`points.rs`).
//! 2. Pairs of the view's points are looked up among those of the others (`pairs.rs`).
//! 3. A few points tell the better of the poses, and then all points the best of these
//!    (`surface.rs`).
//! 4. Least squares along the rays begin at the best ones, and at the given pose (`motion.rs`).
//! 5. The best of them slide along the surfaces to where fewer patches contradict (`slide.rs`).
//!    Near ones count before far ones: a view of a round thing, or along a wall, agrees at many
//!    poses.
//!
//! **Worth.** Forty frames of a depth camera in a room, and in a kitchen, whose poses all err; one
//! of 14 is turned by 10 or 30 degrees. Of these 28 trials 7 come back within 6 cm and 2 degrees if
//! contradictions are only limited, and 17 if they count by how unusual they are. Slides take this
//! to 21, and turn and shift that count separately take it to 27.
//!
//! **Limit.** A pose may move the view's surface as far as that is from the sensor, which a turn by
//! 60 degrees does. Farther away, scenes repeat themselves: a view into one leg of a tunnel fits
//! the other leg better, as more of it overlaps there.
//!
//! **Departures.** Drost lets pairs vote for poses, since points alone cannot tell which pose is
//! wrong. Here free space does, so each pose is tried.

mod pairs;
mod points;
mod slide;
mod surface;

use super::blame::Table;
use super::evidence::Evidence;
use super::motion::{Changed, moved_from, moved_to};
use super::pair::Placing;
use crate::tuning::LEAST_MEETINGS;
use pairs::{PairTable, Shape};
use points::{Oriented, of_view, spacing, thinned};
use rayon::prelude::*;
use slide::Steps;
use std::cmp::Reverse;
use surface::{NEAR, Surface};
use transect_device::{Isometry3, Point3, median};

/// Points of all right views together, at most. No unit. Chosen by hand: the table of their pairs
/// takes 20 MiB at most. Doubled, large scenes take four times the time.
const MOST_POINTS: usize = 1500;

/// Pairs of the view that are looked up. No unit. Chosen by hand: some of them are on surfaces that
/// others saw. Doubled, twice as many poses are tried.
const LOOKED_UP: usize = 2000;

/// Pairs of the same shape that are tried. No unit. Chosen by hand: those of two large planes are
/// thousands, and any of them gives the turn between these planes. Doubled, more of the
/// poses that are tried come from planes.
const MATCHES: usize = 60;

/// Points that give the first score of a pose. No unit. Chosen by hand: of a right pose half of
/// them lie on others, of a wrong one few. Doubled, every pose that is tried takes twice the time.
const FIRST_POINTS: usize = 32;

/// Poses that all points are tried on. No unit. Chosen by hand: one in two hundred. Doubled, this
/// step takes twice the time.
const BETTER: usize = 600;

/// Poses from which least squares begin. No unit. Chosen by hand. Half of them are the nearer ones.
/// Doubled, these rounds take twice the time.
const BEST: usize = 48;

/// Poses that slide along the surfaces, and are then looked at with all patches. No unit. Chosen by
/// hand: where hardly anything tells the turn about an axis, several are close to the right one.
/// Doubled, both take twice the time.
const FINALISTS: usize = 6;

/// Points by which two poses are told apart. No unit. Theory: three tell a motion. Doubled, each
/// comparison takes twice the time.
const CORNERS: usize = 8;

/// Poses at which a view may belong.
pub(crate) struct Places {
    /// The most probable first.
    pub poses: Vec<Isometry3>,
    /// How far surfaces may still be off at these poses.
    pub off: f64,
}

/// The poses at which a view agrees with the others, but for those that are blamed.
pub(super) fn places(
    evidence: &Evidence<'_>,
    table: &Table,
    view: usize,
    blamed: &[usize],
) -> Option<Places> {
    let views = evidence.views;
    let is_right = |k: &usize| *k != view && !blamed.contains(k);
    let right: Vec<usize> = (0..views.len()).filter(is_right).collect();
    let in_sensor = Placing { world_from_sensor: Isometry3::identity(), scale: 1.0 };
    let own = of_view(views[view], in_sensor);
    let spacing = spacing(&own)?;
    let others = right.iter().flat_map(|k| of_view(views[*k], evidence.placings[*k]));
    let others: Vec<Oriented> = others.collect();
    let given = evidence.placings[view].world_from_sensor;
    let far = median(own.iter().map(|o| o.point.coords.norm()))?;
    let wanted = Wanted { own: thinned(&own, spacing), spacing, given, far };
    let mut starts = wanted.starts(&others);
    starts.push(given);
    let moved = |from: &Isometry3| moved_from(evidence, view, from, &right);
    let at = |pose: &Isometry3| moved_to(evidence, view, pose, &right);
    let likelihood = table.likelihood(blamed);
    let agreement = |c: &Changed| c.counts.good as f64 * likelihood(c.counts);
    let mut tried: Vec<Changed> = starts.par_iter().map(moved).collect();
    tried.retain(|c| c.counts.all() >= LEAST_MEETINGS);
    let steps = Steps::of(&wanted.own, spacing);
    let slid = |start: &Changed| steps.slid(*start, at, moved, agreement);
    let slid = wanted.best(tried, agreement).par_iter().map(slid).collect();
    let best = wanted.best(slid, agreement);
    let poses = best.iter().map(|c| c.placing.world_from_sensor).collect();
    Some(Places { poses, off: NEAR * spacing })
}

/// What agreement with the others is divided by: the root of how far a pose is from the given one,
/// `off` at least. `apart` is the square of that.
///
/// A view of a round thing agrees at many poses, and the nearest of them is wanted. A pose four
/// times as far away must have twice the agreement.
pub(crate) fn root_of_far(apart: f64, off: f64) -> f64 {
    apart.sqrt().max(off).sqrt()
}

/// How far two poses of a view with these points are apart: the mean square of how far the turn
/// moves the points, and the square of how far the sensor is. They count separately: a slide along
/// a wall that takes back what a turn moves is no nearer pose.
pub(crate) fn squares_apart(
    from: &Isometry3,
    to: &Isometry3,
    points: impl Iterator<Item = Point3>,
) -> f64 {
    let turned = points.map(|p| (to.rotation * p - from.rotation * p).norm_squared());
    let (sum, count) = turned.fold((0.0, 0.0), |(sum, count), square| (sum + square, count + 1.0));
    let shifted = to.translation.vector - from.translation.vector;
    sum / f64::max(count, 1.0) + shifted.norm_squared()
}

/// The points of a view that is far off.
struct Wanted {
    /// In its sensor frame.
    own: Vec<Oriented>,
    spacing: f64,
    given: Isometry3,
    /// How far a pose may move it: the median distance of its points from the sensor.
    far: f64,
}

impl Wanted {
    /// Poses that bring the points onto others, and that differ.
    fn starts(&self, others: &[Oriented]) -> Vec<Isometry3> {
        let mut scored = self.scored(others);
        let mut starts: Vec<Isometry3> = Vec::new();
        let mut add_best = |scored: &[(usize, Isometry3)], most: usize| {
            for (_, pose) in scored {
                if starts.len() < most && starts.iter().all(|other| self.differ(other, pose)) {
                    starts.push(*pose);
                }
            }
        };
        scored.sort_by_key(|(score, _)| Reverse(*score));
        add_best(&scored, BEST / 2);
        scored.sort_by_cached_key(|(score, pose)| {
            let worth = *score as f64 / root_of_far(self.moves(pose, usize::MAX), self.spacing);
            Reverse(worth.to_bits())
        });
        add_best(&scored, BEST);
        starts
    }

    /// The better poses, with the number of points that they bring onto others.
    fn scored(&self, others: &[Oriented]) -> Vec<(usize, Isometry3)> {
        let surface = Surface::new(others, self.spacing);
        let mut others = thinned(others, self.spacing);
        others.truncate(MOST_POINTS);
        let table = PairTable::new(&others, self.spacing);
        let score = |pose: &Isometry3, points: usize| {
            self.own.iter().take(points).filter(|o| surface.holds(&o.moved(pose))).count()
        };
        let of_shape = |shape: &Shape| {
            let poses = table.matches(shape, MATCHES).map(|frame| frame * shape.frame.inverse());
            let poses = poses.filter(|pose| self.moves(pose, CORNERS) <= self.far.powi(2));
            poses.map(|pose| (score(&pose, FIRST_POINTS), pose)).collect::<Vec<_>>()
        };
        let shapes = Shape::of_all(&self.own, self.spacing, LOOKED_UP);
        let mut scored: Vec<_> = shapes.par_iter().flat_map_iter(of_shape).collect();
        scored.sort_by_key(|(score, _)| Reverse(*score));
        scored.truncate(BETTER);
        scored.par_iter_mut().for_each(|(all, pose)| *all = score(pose, self.own.len()));
        scored
    }

    /// How far a pose is from the given one, by the first points: [`squares_apart`].
    fn moves(&self, pose: &Isometry3, points: usize) -> f64 {
        squares_apart(&self.given, pose, self.own.iter().take(points).map(|o| o.point))
    }

    /// The best poses that differ: those with much agreement, and near ones before far ones.
    fn best(&self, mut of: Vec<Changed>, agreement: impl Fn(&Changed) -> f64) -> Vec<Changed> {
        let pose = |c: &Changed| c.placing.world_from_sensor;
        let far = |c: &Changed| root_of_far(self.moves(&pose(c), usize::MAX), self.spacing);
        let worth = |c: &Changed| agreement(c) / far(c);
        of.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        let mut best: Vec<Changed> = Vec::new();
        for changed in of {
            let differs = best.iter().all(|other| self.differ(&pose(other), &pose(&changed)));
            if differs && best.len() < FINALISTS {
                best.push(changed);
            }
        }
        best
    }

    /// Whether two poses are farther from each other than the points.
    fn differ(&self, a: &Isometry3, b: &Isometry3) -> bool {
        let corners = self.own.iter().take(CORNERS);
        let moved = corners.map(|o| (a * o.point - b * o.point).norm());
        moved.fold(0.0, f64::max) > self.spacing
    }
}
