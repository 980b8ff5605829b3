//! Trajectories: the poses of many views in one file. All poses are world from sensor.
//!
//! | format | a pose | belongs to |
//! |---|---|---|
//! | TUM, ICL-NUIM | a line `time tx ty tz qx qy qz qw` | its time |
//! | KITTI | a line of 3 × 4 numbers, row by row | the view in its place |
//! | 4 × 4 | a line of 16 numbers, or four lines of 4 | the view in its place |
//! | Open3D `.log` | a head of three counts, then four lines of 4 numbers | the view of its number |
//! | Open3D `.json` | `extrinsic`: sensor from world, column by column | the view in its place |
//!
//! The number of a pose in a `.log` is the first count of its head. Where the heads count from 0 in
//! order, that is the pose's place.
//!
//! The number of words in the first line tells the text formats apart. Commas separate words, too.
//! Blank lines and those that begin with `#` or `%` are comments.

mod timed;

use crate::input::read_text;
use crate::{Place, ReadError, pose};
use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
pub(crate) use timed::{NoPose, Timed};

/// The poses of a file.
pub(crate) enum Trajectory {
    /// One pose per view, in order.
    Ordered(Ordered),
    /// Poses with their times, in the order of time.
    Timed(Timed),
}

/// One pose per view, in order. Each is parsed when it is asked for: views may need a few of many,
/// and a file with many damaged lines takes no memory for them.
pub(crate) struct Ordered {
    path: PathBuf,
    poses: Poses,
}

enum Poses {
    /// A pose begins at each of `starts`. It has some lines before its numbers.
    Text {
        text: String,
        starts: Vec<usize>,
        heads: usize,
        rows: usize,
    },
    Json(Vec<Open3dView>),
}

#[derive(Deserialize)]
struct Open3dTrajectory {
    parameters: Vec<Open3dView>,
}

#[derive(Deserialize)]
struct Open3dView {
    extrinsic: [f64; 16],
}

impl Trajectory {
    pub(crate) fn read(path: &Path) -> Result<Self, ReadError> {
        let text = read_text(path)?;
        let ordered = |poses| Ok(Self::Ordered(Ordered { path: path.to_owned(), poses }));
        if text.trim_start().starts_with('{') {
            let parsed: Result<Open3dTrajectory, _> = serde_json::from_str(&text);
            let parsed =
                parsed.map_err(|e| ReadError::Json { path: path.to_owned(), source: e })?;
            return ordered(Poses::Json(parsed.parameters));
        }
        let Some((start, line)) = lines(&text, 0).next() else {
            return Err(ReadError::damaged(path, Place::Whole, "no poses"));
        };
        let (heads, rows) = match words(line).count() {
            8 => return Ok(Self::Timed(Timed::of_text(&text))),
            12 | 16 => (0, 1),
            4 => (0, 4),
            3 => (1, 4),
            found => {
                let problem = format!(
                    "the line has {found} words; a trajectory begins with 8 (TUM: time tx ty tz qx \
                     qy qz qw), 12 (KITTI: 3 × 4), 16 or 4 (4 × 4), or 3 (Open3D .log)"
                );
                let at = Place::Line(line_number(&text, start));
                return Err(ReadError::damaged(path, at, problem));
            }
        };
        let starts = lines(&text, 0).step_by(heads + rows).map(|(start, _)| start).collect();
        ordered(Poses::Text { text, starts, heads, rows })
    }
}

impl Ordered {
    pub(crate) fn len(&self) -> usize {
        match &self.poses {
            Poses::Text { starts, .. } => starts.len(),
            Poses::Json(views) => views.len(),
        }
    }

    /// The places of the poses by the numbers of their heads. `None` where the heads count from 0
    /// in order, where a number repeats, and for poses without heads.
    pub(crate) fn places_by_head(&self) -> Option<BTreeMap<usize, usize>> {
        let Poses::Text { text, starts, heads: 1.., .. } = &self.poses else { return None };
        let mut places = BTreeMap::new();
        for (place, start) in starts.iter().enumerate() {
            let (_, head) = lines(text, *start).next()?;
            let number = words(head).next()?.parse().ok()?;
            if places.insert(number, place).is_some() {
                return None;
            }
        }
        places.iter().any(|(number, place)| number != place).then_some(places)
    }

    /// Pose `k` as a row-major matrix; `None` beyond the last one.
    pub(crate) fn get(&self, k: usize) -> Option<Result<[f64; 16], ReadError>> {
        let matrix = match &self.poses {
            Poses::Text { text, starts, heads, rows } => {
                let start = *starts.get(k)?;
                let numbered = lines(text, start).skip(*heads).take(*rows);
                let matrix = matrix(numbered.map(|(_, line)| line));
                // The number of the line takes a walk through the file, so only errors need it.
                matrix.map_err(|problem| (problem, Place::Line(line_number(text, start))))
            }
            Poses::Json(views) => world_from_sensor(views.get(k)?).map_err(|problem| {
                (problem, Place::View { number: k, name: "of \"parameters\"".to_owned() })
            }),
        };
        Some(matrix.map_err(|(problem, at)| ReadError::damaged(&self.path, at, problem)))
    }
}

/// The one pose of a file, as a row-major matrix: 4 × 4 or 3 × 4 numbers.
pub(crate) fn read_one(path: &Path) -> Result<[f64; 16], ReadError> {
    let text = read_text(path)?;
    let matrix = matrix(lines(&text, 0).map(|(_, line)| line));
    matrix.map_err(|problem| ReadError::damaged(path, Place::Whole, problem))
}

/// The pose of 3 × 4 or 4 × 4 numbers, row by row, or a sentence about its problem.
pub(crate) fn matrix<'a>(lines: impl Iterator<Item = &'a str>) -> Result<[f64; 16], String> {
    let mut numbers = numbers(lines)?;
    let count = numbers.len();
    if count == 12 {
        numbers.extend([0.0, 0.0, 0.0, 1.0]);
    }
    let matrix = numbers.try_into().map_err(|_| {
        let more = if count == TOO_MANY { " or more" } else { "" };
        format!("{count}{more} numbers; a pose has 12 (3 × 4) or 16 (4 × 4), row by row")
    })?;
    pose::from_row_major(&matrix).map(|_| matrix)
}

/// More numbers than a pose or a camera has.
const TOO_MANY: usize = 17;

/// At most [`TOO_MANY`] numbers of lines.
pub(crate) fn numbers<'a>(lines: impl Iterator<Item = &'a str>) -> Result<Vec<f64>, String> {
    let number = |word: &str| {
        let start = || word.chars().take(20).collect::<String>();
        word.parse().map_err(|_| format!("{:?} is no number", start()))
    };
    lines.flat_map(words).take(TOO_MANY).map(number).collect()
}

/// Words between white space or commas.
fn words(line: &str) -> impl Iterator<Item = &str> {
    line.split(|c: char| c.is_ascii_whitespace() || c == ',').filter(|word| !word.is_empty())
}

/// The lines from a byte on that are no comments, each with the byte at which it begins.
pub(crate) fn lines(text: &str, from: usize) -> impl Iterator<Item = (usize, &str)> {
    let mut start = from;
    let rest = text.get(from..).unwrap_or_default().split_inclusive('\n');
    let lines = rest.map(move |line| {
        let begins = start;
        start += line.len();
        (begins, line.trim())
    });
    lines.filter(|(_, line)| !line.is_empty() && !line.starts_with(['#', '%']))
}

fn line_number(text: &str, start: usize) -> usize {
    1 + text.bytes().take(start).filter(|byte| *byte == b'\n').count()
}

/// The inverse of a view's extrinsic. The 3 × 3 part is inverted as it is, so that a later check
/// finds by how much it is no rotation. For the same reason, the last row stays.
fn world_from_sensor(view: &Open3dView) -> Result<[f64; 16], String> {
    let [a, d, g, k, b, e, h, l, c, f, i, m, x, y, z, n] = view.extrinsic;
    let sensor_from_world = [a, b, c, x, d, e, f, y, g, h, i, z, k, l, m, n];
    let pose = pose::from_row_major(&sensor_from_world)?;
    let inverse = Matrix3::new(a, b, c, d, e, f, g, h, i).try_inverse();
    let r = inverse.unwrap_or_else(|| {
        pose.world_from_sensor.inverse().rotation.to_rotation_matrix().into_inner()
    });
    let t = -(r * Vector3::new(x, y, z));
    let [[a, d, g], [b, e, h], [c, f, i]] = r.into();
    Ok([a, b, c, t.x, d, e, f, t.y, g, h, i, t.z, k, l, m, n])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use transect_geometry::Isometry3;

    proptest! {
        #[test]
        fn extrinsics_of_open3d_are_inverted_to_poses(
            axis in prop::array::uniform3(-3.0..3.0), place in prop::array::uniform3(-6e6..6e6),
        ) {
            let pose = Isometry3::new(Vector3::from(place), Vector3::from(axis));
            // Column by column, as nalgebra stores a matrix.
            let sensor_from_world = pose.inverse().to_homogeneous();
            let mut extrinsic = [0.0; 16];
            extrinsic.copy_from_slice(sensor_from_world.as_slice());
            let rows = world_from_sensor(&Open3dView { extrinsic }).unwrap();
            prop_assert_eq!(&rows[12..], &[0.0, 0.0, 0.0, 1.0]);
            let back = pose::from_row_major(&rows).unwrap();
            prop_assert!(back.repaired.is_none());
            prop_assert!(back.world_from_sensor.rotation.angle_to(&pose.rotation) < 1e-7);
            let way = back.world_from_sensor.translation.vector - pose.translation.vector;
            prop_assert!(way.norm() < 1e-7, "off by {}", way);
        }
    }

    #[test]
    fn the_rounded_last_row_of_an_extrinsic_is_repaired() {
        let mut extrinsic = [0.0; 16];
        extrinsic
            .copy_from_slice(Isometry3::translation(1.0, 2.0, 3.0).to_homogeneous().as_slice());
        extrinsic[15] -= 1e-7;
        let rows = world_from_sensor(&Open3dView { extrinsic }).unwrap();
        let back = pose::from_row_major(&rows).unwrap();
        assert!(back.repaired.is_some_and(|by| by < 2e-7));
        assert_eq!(back.world_from_sensor, Isometry3::translation(-1.0, -2.0, -3.0));
    }
}
