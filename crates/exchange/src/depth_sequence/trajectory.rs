//! Trajectories: the poses of many images in one file. All poses are camera to world.
//!
//! | format | a pose | belongs to |
//! |---|---|---|
//! | TUM, ICL-NUIM | a line `time tx ty tz qx qy qz qw` | its time |
//! | KITTI | a line of 3 × 4 numbers, row by row | the image in its place |
//! | 4 × 4 | a line of 16 numbers, or four lines of 4 | the image in its place |
//! | Open3D `.log` | a line of three counts, then four lines of 4 numbers | the image in its place |
//! | Open3D `.json` | `extrinsic`: world to camera, column by column | the image in its place |
//!
//! The number of words in the first line tells the text formats apart.

use super::text::numbers;
use crate::input::read_text;
use crate::{Place, ReadError, pose, row_major};
use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use serde::Deserialize;
use std::path::Path;
use transect_geometry::Isometry3;

/// Largest deviation of a quaternion's length from 1 that counts as rounding. Chosen by hand: TUM
/// prints four digits. Doubled, a damaged quaternion passes for a rotation.
const QUATERNION_ROUNDING: f64 = 0.01;

/// A pose as a row-major matrix, or a sentence about its place and its problem.
pub(super) type Posed = Result<[f64; 16], String>;

/// The poses of a file.
#[derive(Debug, PartialEq)]
pub(super) enum Trajectory {
    /// One pose per image, in order.
    Ordered(Vec<Posed>),
    /// Poses with their times, in the order of time.
    Timed(Timed),
}

/// Poses with their times in seconds.
#[derive(Debug, PartialEq)]
pub(super) struct Timed {
    poses: Vec<(f64, Isometry3)>,
    /// Number of the lines that hold no pose, and a sentence about the first.
    pub(super) refused: Option<(usize, String)>,
}

/// Why a trajectory has no pose for a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NoPose {
    /// The time is before the first pose or after the last one. Poses are not extrapolated.
    Outside,
    /// The nearest pose is farther away in time than allowed.
    TooFar,
}

impl Trajectory {
    pub(super) fn read(path: &Path) -> Result<Self, ReadError> {
        let text = read_text(path)?;
        if text.trim_start().starts_with('{') {
            return Ok(Self::Ordered(open3d_json(path, &text)?));
        }
        let lines = || {
            let lines = (1..).zip(text.lines().map(str::trim));
            lines.filter(|(_, line)| !line.is_empty() && !line.starts_with(['#', '%']))
        };
        let Some((first, line)) = lines().next() else {
            return Err(ReadError::damaged(path, Place::Whole, "no poses"));
        };
        let single = |matrix: fn(&str) -> Option<[f64; 16]>| {
            Self::Ordered(lines().map(|(number, line)| checked(number, matrix(line))).collect())
        };
        Ok(match line.split_ascii_whitespace().count() {
            8 => Self::Timed(Timed::of_lines(lines())),
            12 => single(kitti),
            16 => single(exactly),
            4 => Self::Ordered(blocks(lines(), 0)),
            3 => Self::Ordered(blocks(lines(), 1)),
            found => {
                let problem = format!(
                    "the line has {found} words; a trajectory begins with 8 (TUM: time tx ty tz qx \
                     qy qz qw), 12 (KITTI: 3 × 4), 16 or 4 (4 × 4), or 3 (Open3D .log)"
                );
                return Err(ReadError::damaged(path, Place::Line(first), problem));
            }
        })
    }
}

/// Exactly `N` numbers; `None` if there are fewer, more, or other words.
fn exactly<const N: usize>(line: &str) -> Option<[f64; N]> {
    let numbers: Option<Vec<f64>> = numbers(line).take(N + 1).collect();
    numbers?.try_into().ok()
}

fn kitti(line: &str) -> Option<[f64; 16]> {
    let [a, b, c, x, d, e, f, y, g, h, i, z] = exactly(line)?;
    Some([a, b, c, x, d, e, f, y, g, h, i, z, 0.0, 0.0, 0.0, 1.0])
}

/// The matrix that begins in a line, if it is a pose.
fn checked(line: usize, matrix: Option<[f64; 16]>) -> Posed {
    let matrix = matrix.ok_or_else(|| format!("line {line}: not the numbers of a pose"))?;
    pose::from_row_major(&matrix).map_err(|problem| format!("line {line}: {problem}"))?;
    Ok(matrix)
}

/// Poses of four lines, after `heads` other lines each.
fn blocks<'a>(lines: impl Iterator<Item = (usize, &'a str)>, heads: usize) -> Vec<Posed> {
    let mut poses = Vec::new();
    let mut lines = lines.peekable();
    while let Some(&(number, _)) = lines.peek() {
        let matrix: Option<Vec<[f64; 4]>> =
            lines.by_ref().take(heads + 4).skip(heads).map(|(_, line)| exactly(line)).collect();
        let matrix = matrix.and_then(|rows| rows.concat().try_into().ok());
        poses.push(checked(number, matrix));
    }
    poses
}

#[derive(Deserialize)]
struct Open3dTrajectory {
    parameters: Vec<Open3dView>,
}

#[derive(Deserialize)]
struct Open3dView {
    extrinsic: [f64; 16],
}

fn open3d_json(path: &Path, text: &str) -> Result<Vec<Posed>, ReadError> {
    let trajectory: Open3dTrajectory = serde_json::from_str(text)
        .map_err(|source| ReadError::Json { path: path.to_owned(), source })?;
    let pose = |(number, view): (usize, &Open3dView)| {
        let [a, d, g, k, b, e, h, l, c, f, i, m, x, y, z, n] = view.extrinsic;
        let matrix = [a, b, c, x, d, e, f, y, g, h, i, z, k, l, m, n];
        let sensor_from_world = pose::from_row_major(&matrix);
        let problem = |problem| format!("view {number} of \"parameters\": {problem}");
        Ok(row_major(&sensor_from_world.map_err(problem)?.world_from_sensor.inverse()))
    };
    Ok(trajectory.parameters.iter().enumerate().map(pose).collect())
}

impl Timed {
    fn of_lines<'a>(lines: impl Iterator<Item = (usize, &'a str)>) -> Self {
        let (mut poses, mut refused) = (Vec::new(), 0);
        let mut first = None;
        for (number, line) in lines {
            match timed_pose(line) {
                Ok(pose) => poses.push(pose),
                Err(problem) => {
                    refused += 1;
                    first.get_or_insert_with(|| format!("line {number}: {problem}"));
                }
            }
        }
        poses.sort_by(|a: &(f64, _), b| a.0.total_cmp(&b.0));
        Self { poses, refused: first.map(|first| (refused, first)) }
    }

    /// The first and the last time.
    pub(super) fn span(&self) -> Option<(f64, f64)> {
        Some((self.poses.first()?.0, self.poses.last()?.0))
    }

    /// The pose at a time, interpolated between its neighbours.
    pub(super) fn at(&self, time: f64, most_difference: f64) -> Result<Isometry3, NoPose> {
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
    let [time, x, y, z, i, j, k, w] = exactly(line).ok_or(wanted)?;
    if ![time, x, y, z].iter().all(|n| n.is_finite()) {
        return Err("the pose has a number that is not finite".to_owned());
    }
    let quaternion = Quaternion::new(w, i, j, k);
    let length = quaternion.norm();
    let deviation = (length - 1.0).abs();
    if deviation.is_nan() || deviation > QUATERNION_ROUNDING {
        return Err(format!("the quaternion has length {length}; a rotation has length 1"));
    }
    let rotation = UnitQuaternion::new_normalize(quaternion);
    Ok((time, Isometry3::from_parts(Translation3::new(x, y, z), rotation)))
}
