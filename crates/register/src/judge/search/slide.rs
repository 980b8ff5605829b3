//! A pose that slides along the surfaces of the others.
//!
//! **Problem.** Least squares do not slide a view along a wall: the distances hardly change. Which
//! points meet a surface, and which lie in free space, does change.
//!
//! **Idea.** The pose goes on by small steps (compass search: Kolda, Lewis and Torczon, 2003), with
//! least squares after every step. The steps are motions that the view's own surface determines
//! separately: the least determined ones are slides along it.
//!
//! **Limit.** It goes on only while contradictions become fewer. Agreement alone would draw a view
//! of a tunnel along it, to where it sees more of what the others saw.

use super::super::motion::Changed;
use super::points::Oriented;
use nalgebra::{Matrix6, Translation3, UnitQuaternion, Vector6};
use transect_device::{Isometry3, Vector3};

/// Lengths of the steps, over the spacing. No unit. Chosen by hand: poses from pairs are off by one
/// or two, and distances up to half of it tell the rest. Doubled, the pose stays a spacing off.
const STEPS: [f64; 3] = [2.0, 1.0, 0.5];

/// Small motions of a view in its sensor frame: six of each length, and back.
pub struct Steps(Vec<Isometry3>);

impl Steps {
    /// The steps of a view with these points.
    pub fn of(own: &[Oriented], spacing: f64) -> Self {
        let count = own.len().max(1) as f64;
        let middle = own.iter().map(|o| o.point.coords).sum::<Vector3>() / count;
        let squares = own.iter().map(|o| (o.point.coords - middle).norm_squared());
        let size = (squares.sum::<f64>() / count).sqrt();
        let row = |o: &Oriented| {
            let turn = (o.point.coords - middle).cross(&o.normal) / size;
            Vector6::new(turn.x, turn.y, turn.z, o.normal.x, o.normal.y, o.normal.z)
        };
        let rows = own.iter().map(row);
        let apart = rows.map(|row| row * row.transpose()).sum::<Matrix6<f64>>().symmetric_eigen();
        let step = |motion: Vector6<f64>| {
            let [turn, shift] = [0, 3].map(|k| motion.fixed_rows::<3>(k).into_owned());
            let turn = UnitQuaternion::from_scaled_axis(turn / size);
            let about = Translation3::from(middle + shift);
            Isometry3::from_parts(about, turn) * Translation3::from(-middle)
        };
        let lengths = STEPS.iter().flat_map(|length| [*length, -length]);
        let motions = lengths.flat_map(|length| {
            let motions = apart.eigenvectors.column_iter().map(|v| v.into_owned());
            motions.map(move |motion| motion * (length * spacing)).collect::<Vec<_>>()
        });
        Self(motions.map(step).collect())
    }

    /// The pose from which no step leads to a better one. `at` compares the view at a pose with the
    /// others, and `moved` does so after least squares from there.
    pub fn slid(
        &self,
        start: Changed,
        at: impl Fn(&Isometry3) -> Changed,
        moved: impl Fn(&Isometry3) -> Changed,
        agreement: impl Fn(&Changed) -> f64,
    ) -> Changed {
        let is_better = |next: &Changed, than: &Changed| {
            let contradicts_less = next.counts.bad_share() < than.counts.bad_share();
            contradicts_less && agreement(next) > agreement(than)
        };
        let mut best = start;
        for steps in self.0.chunks(2 * 6) {
            loop {
                let from = best.placing.world_from_sensor;
                let around = steps.iter().map(|step| at(&(from * step)));
                let step = around.max_by(|a, b| agreement(a).total_cmp(&agreement(b)));
                let next = step.map(|step| moved(&step.placing.world_from_sensor));
                let Some(next) = next.filter(|next| is_better(next, &best)) else { break };
                best = next;
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::blame::Counts;
    use super::super::super::pair::Placing;
    use super::*;
    use transect_device::Point3;

    /// Slides along a floor, where patches contradict and agree by the distance along x.
    fn slid_from(x: f64, counts: impl Fn(f64) -> [usize; 2]) -> f64 {
        let at = |pose: &Isometry3| {
            let [good, bad] = counts(pose.translation.x);
            let placing = Placing { world_from_sensor: *pose, scale: 1.0 };
            Changed { placing, counts: Counts { good, bad, unclear: 0 }, cost: 0.0 }
        };
        let agreement = |c: &Changed| c.counts.good as f64 * (-200.0 * c.counts.bad_share()).exp();
        let steps = Steps::of(&corner(false), 0.1);
        let start = at(&Isometry3::translation(x, 0.0, 0.0));
        steps.slid(start, at, at, agreement).placing.world_from_sensor.translation.x
    }

    #[test]
    fn a_pose_slides_to_where_nothing_contradicts_and_no_farther() {
        let off = |x: f64| (100.0 * x.abs()) as usize;
        let slid = slid_from(0.7, |x| [1000, off(x)]);
        assert!(slid.abs() < 0.06, "{slid}");
        // More agrees farther along, but nothing contradicts where it is.
        assert_eq!(slid_from(0.7, |x| [1000 + off(x).min(200), 0]), 0.7);
    }

    /// Points on a floor, and on a wall beside it where there is one.
    fn corner(has_wall: bool) -> Vec<Oriented> {
        let grid = |k: usize| [(k % 9) as f64 - 4.0, (k / 9) as f64];
        let floor = (0..81).map(grid).map(|[x, y]| (Point3::new(x, y, 2.0), Vector3::z()));
        let wall = (0..81).map(grid).map(|[x, z]| (Point3::new(x, 8.0, 2.0 + z), -Vector3::y()));
        let all = floor.chain(wall.filter(|_| has_wall));
        all.map(|(point, normal)| Oriented { point, normal }).collect()
    }

    #[test]
    fn some_steps_stay_on_the_surface() {
        for (has_wall, slides) in [(false, 3), (true, 1)] {
            let own = corner(has_wall);
            let off = |step: &Isometry3| {
                let off = own.iter().map(|o| (step * o.point - o.point).dot(&o.normal).abs());
                off.fold(0.0, f64::max)
            };
            for (step, length) in Steps::of(&own, 0.01).0.chunks(6).zip([2.0, -2.0, 1.0, -1.0]) {
                let moved = |s: &Isometry3| (s.translation.vector, s.rotation.scaled_axis());
                assert!(step.iter().all(|s| moved(s).0.norm() + moved(s).1.norm() > 1e-4));
                let on = step.iter().filter(|step| off(step) < 1e-3 * f64::abs(length));
                assert_eq!(on.count(), slides, "{has_wall} {length}");
            }
        }
    }
}
