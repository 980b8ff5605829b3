//! Poses with times: TUM's text, and a pose between two of them.

use super::{line_number, lines, numbers};
use crate::pose::from_unit_quaternion;
use nalgebra::Quaternion;
use transect_geometry::Isometry3;

/// Poses with their times in seconds.
pub(crate) struct Timed {
    poses: Vec<(f64, Isometry3)>,
    /// Number of the lines that hold no pose, and a sentence about the first.
    pub(crate) refused: Option<(usize, String)>,
}

/// Why a trajectory has no pose for a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NoPose {
    /// The time is before the first pose or after the last one. Poses are not extrapolated.
    Outside,
    /// The nearest pose is farther away in time than allowed.
    TooFar,
}

impl Timed {
    pub(super) fn of_text(text: &str) -> Self {
        let (mut poses, mut refused) = (Vec::new(), 0);
        let mut first = None;
        for (start, line) in lines(text, 0) {
            match timed_pose(line) {
                Ok(pose) => poses.push(pose),
                Err(problem) => {
                    refused += 1;
                    first.get_or_insert((start, problem));
                }
            }
        }
        poses.sort_by(|a: &(f64, _), b| a.0.total_cmp(&b.0));
        let told = |(start, problem)| format!("line {}: {problem}", line_number(text, start));
        Self { poses, refused: first.map(|first| (refused, told(first))) }
    }

    /// The first and the last time.
    pub(crate) fn span(&self) -> Option<(f64, f64)> {
        Some((self.poses.first()?.0, self.poses.last()?.0))
    }

    /// The number of times with two poses that differ, and the first of them.
    pub(crate) fn contradicting(&self) -> Option<(usize, f64)> {
        let pairs = self.poses.iter().zip(self.poses.iter().skip(1));
        let mut differ = pairs.filter(|(a, b)| a.0 == b.0 && a.1 != b.1).map(|(a, _)| a.0);
        let first = differ.next()?;
        Some((1 + differ.count(), first))
    }

    /// The pose at a time, the first of several there or interpolated between its neighbours.
    pub(crate) fn at(&self, time: f64, most_difference: f64) -> Result<Isometry3, NoPose> {
        let next = self.poses.partition_point(|(t, _)| *t < time);
        let (after, b) = self.poses.get(next).ok_or(NoPose::Outside)?;
        if *after == time {
            return Ok(*b);
        }
        let previous = next.checked_sub(1).and_then(|i| self.poses.get(i));
        let (before, a) = previous.ok_or(NoPose::Outside)?;
        let (since, until) = (time - before, after - time);
        if since.min(until) > most_difference {
            return Err(NoPose::TooFar);
        }
        // Opposite rotations have no shortest way between them; the nearer pose counts then.
        let nearer = if since <= until { a } else { b };
        Ok(a.try_lerp_slerp(b, since / (since + until), f64::EPSILON).unwrap_or(*nearer))
    }
}

/// The time and the pose of a line of TUM's format.
fn timed_pose(line: &str) -> Result<(f64, Isometry3), String> {
    let wanted = "expected 8 numbers: time tx ty tz qx qy qz qw";
    let numbers =
        numbers(std::iter::once(line)).map_err(|problem| format!("{problem}; {wanted}"))?;
    let &[time, x, y, z, i, j, k, w] = numbers.as_slice() else {
        return Err(format!("{} numbers; {wanted}", numbers.len()));
    };
    if !time.is_finite() {
        return Err("the time is not finite".to_owned());
    }
    Ok((time, from_unit_quaternion([x, y, z], Quaternion::new(w, i, j, k))?))
}
