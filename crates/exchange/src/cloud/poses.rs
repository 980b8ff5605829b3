//! Poses of cloud files: world from sensor, one per file.
//!
//! In the order of precedence:
//!
//! 1. the file that the caller names, or `poses.txt` in the folder: one pose per file, in the order
//!    of the files' names, in any format of trajectories without times;
//! 2. `NAME.pose.txt` beside each `NAME.pcd`, `.ply` or `.bin`: 4 × 4 or 3 × 4 numbers;
//! 3. `T_A_B.txt`: A from B, for the files A and B of the folder; A is the world;
//! 4. the line VIEWPOINT of PCD files;
//! 5. the identity, for a file alone.
//!
//! KITTI's poses are those of camera 0. A file `calib.txt` with a line `Tr:` (camera from lidar)
//! beside the clouds or in the folder above turns them into poses of the lidar.

use super::{Kind, pcd};
use crate::input::{read_head, read_text};
use crate::pose::{from_row_major, repairs_note};
use crate::trajectory::{Trajectory, matrix, read_one};
use crate::{Place, ReadError};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use transect_device::Note;
use transect_geometry::Isometry3;

/// The names of a trajectory and of a calibration in the folder of the clouds.
const TRAJECTORY: &str = "poses.txt";
const CALIBRATION: &str = "calib.txt";

/// The poses of all files, in their order.
#[derive(Default)]
pub(super) struct Poses {
    pub(super) poses: Vec<Isometry3>,
    pub(super) notes: Vec<Note>,
    /// The files that state the poses.
    pub(super) files: Vec<PathBuf>,
    /// Whether the poses are those of the `VIEWPOINT` lines.
    pub(super) by_viewpoints: bool,
}

impl Poses {
    /// Adds the one pose of a file.
    fn add(&mut self, file: &Path) -> Result<(), ReadError> {
        let one = isometries(file, &[read_one(file)?])?;
        self.poses.extend(one.poses);
        self.notes.extend(one.notes);
        self.files.extend(one.files);
        Ok(())
    }
}

/// Finds the poses of files. `path` is the folder, or the file alone.
pub(super) fn find(
    path: &Path,
    files: &[PathBuf],
    stated: Option<&Path>,
) -> Result<Poses, ReadError> {
    let folder = if path.is_dir() { path } else { path.parent().unwrap_or(Path::new("")) };
    let is_folder = path.is_dir();
    let trajectory = stated.map(Path::to_owned);
    let own = Some(folder.join(TRAJECTORY)).filter(|file| is_folder && file.is_file());
    if let Some(file) = trajectory.or(own) {
        return of_trajectory(folder, &file, files);
    }
    let beside = beside(files)?;
    if let Some(found) = beside {
        return Ok(found);
    }
    if is_folder && let Some(found) = of_pairs(folder, files)? {
        return Ok(found);
    }
    let viewpoints = viewpoints(files)?;
    let known = viewpoints.iter().flatten().count();
    if known == 0 && files.len() > 1 {
        let count = files.len();
        let problem = format!(
            "{count} clouds without poses; pass the setting `poses`, a file with one line of 12 \
             numbers per cloud (KITTI, 3 × 4, world from sensor), or add {TRAJECTORY}, \
             NAME.pose.txt or T_TARGET_SOURCE.txt to the folder; a file alone needs no pose"
        );
        return Err(ReadError::damaged(path, Place::Whole, problem));
    }
    if known == 0 {
        return Ok(Poses { poses: vec![Isometry3::identity(); files.len()], ..Poses::default() });
    }
    let without = files.iter().zip(&viewpoints).find(|(_, viewpoint)| viewpoint.is_none());
    if let Some((file, _)) = without {
        let problem = format!(
            "no VIEWPOINT line, which {known} of {} clouds of the folder have; add one, or pass \
             the setting `poses`, a file with the poses of all",
            files.len()
        );
        return Err(ReadError::damaged(file, Place::Whole, problem));
    }
    let text = format!(
        "{known} poses from VIEWPOINT lines: the points are taken to be in the frame of the sensor"
    );
    let note = Note::about(path.display(), text);
    let poses = viewpoints.into_iter().flatten().collect();
    Ok(Poses { poses, notes: vec![note], by_viewpoints: true, ..Poses::default() })
}

/// Poses of one file for all clouds.
fn of_trajectory(folder: &Path, file: &Path, clouds: &[PathBuf]) -> Result<Poses, ReadError> {
    let Trajectory::Ordered(ordered) = Trajectory::read(file)? else {
        let problem = "the poses have times, but the clouds have none; expected one line of 12 \
                       numbers (3 × 4, world from sensor) for each cloud, in the order of names";
        return Err(ReadError::damaged(file, Place::Whole, problem));
    };
    if ordered.len() != clouds.len() {
        let problem = format!(
            "the file has {} poses; expected one for each of the {} clouds in {}",
            ordered.len(),
            clouds.len(),
            folder.display()
        );
        return Err(ReadError::damaged(file, Place::Whole, problem));
    }
    let matrices: Result<Vec<_>, _> = (0..clouds.len()).filter_map(|k| ordered.get(k)).collect();
    let mut found = isometries(file, &matrices?)?;
    if let Some((path, camera_from_lidar, repaired)) = calibration(folder)? {
        found.poses.iter_mut().for_each(|pose| *pose *= camera_from_lidar);
        found.notes.extend(repairs_note(&path, repaired.as_slice(), 1));
        let text = "\"Tr:\" turns camera 0's poses into the lidar's";
        found.notes.push(Note::about(path.display(), text));
        found.files.push(path);
    }
    Ok(found)
}

/// A calibration's file, its pose, and the deviation of its matrix from a rotation.
type Calibration = (PathBuf, Isometry3, Option<(f64, Place)>);

/// KITTI's camera-from-lidar, from the folder of the clouds or the one above.
fn calibration(folder: &Path) -> Result<Option<Calibration>, ReadError> {
    let above = folder.parent().map(|above| above.join(CALIBRATION));
    let places = [Some(folder.join(CALIBRATION)), above];
    let Some(path) = places.into_iter().flatten().find(|path| path.is_file()) else {
        return Ok(None);
    };
    let text = read_text(&path)?;
    for (line, text) in (1..).zip(text.lines()) {
        let Some(numbers) = text.strip_prefix("Tr:") else { continue };
        let pose = matrix(std::iter::once(numbers)).and_then(|matrix| from_row_major(&matrix));
        let pose = pose.map_err(|p| ReadError::damaged(&path, Place::Line(line), p))?;
        let repaired = pose.repaired.map(|deviation| (deviation, Place::Line(line)));
        return Ok(Some((path, pose.world_from_sensor, repaired)));
    }
    Ok(None)
}

/// `NAME.pose.txt` of every cloud; `None` if no cloud has one.
fn beside(clouds: &[PathBuf]) -> Result<Option<Poses>, ReadError> {
    let files: Vec<PathBuf> = clouds.iter().map(|c| c.with_extension("pose.txt")).collect();
    let missing: Vec<_> = files.iter().filter(|f| !f.is_file()).collect();
    if missing.len() == files.len() {
        return Ok(None);
    }
    if let Some(first) = missing.first() {
        let problem = format!(
            "{} of {} clouds have no file NAME.pose.txt; this is the first missing one",
            missing.len(),
            files.len()
        );
        return Err(ReadError::damaged(first, Place::Whole, problem));
    }
    let mut found = Poses::default();
    for file in &files {
        found.add(file)?;
    }
    Ok(Some(found))
}

/// Files `T_A_B.txt` with one A for all other clouds; `None` if there is no such file.
fn of_pairs(folder: &Path, clouds: &[PathBuf]) -> Result<Option<Poses>, ReadError> {
    let stem = |path: &PathBuf| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let stems: Vec<String> = clouds.iter().map(stem).collect();
    let pairs = pairs(folder)?;
    let known: HashSet<&str> = stems.iter().map(String::as_str).collect();
    // Names may hold underscores, so a pair can be read in several ways.
    let is_world = |a: &str, pair: &str| {
        let b = pair.strip_prefix(a).and_then(|rest| rest.strip_prefix('_'));
        b.is_some_and(|b| known.contains(b))
    };
    let Some(world) = stems.iter().find(|a| pairs.iter().any(|pair| is_world(a, pair))) else {
        return Ok(None);
    };
    let mut found = Poses::default();
    let text = format!("the world is the frame of {world}");
    found.notes.push(Note::about(folder.display(), text));
    for stem in &stems {
        if stem == world {
            found.poses.push(Isometry3::identity());
            continue;
        }
        found.add(&folder.join(format!("T_{world}_{stem}.txt")))?;
    }
    Ok(Some(found))
}

/// `A_B` of every file `T_A_B.txt` in a folder.
fn pairs(folder: &Path) -> Result<Vec<String>, ReadError> {
    let mut pairs = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(|e| ReadError::io(folder, e))? {
        let path = entry.map_err(|e| ReadError::io(folder, e))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let pair = name.strip_prefix("T_").and_then(|name| name.strip_suffix(".txt"));
        pairs.extend(pair.filter(|_| path.is_file()).map(str::to_owned));
    }
    Ok(pairs)
}

/// The viewpoints of PCD files.
fn viewpoints(files: &[PathBuf]) -> Result<Vec<Option<Isometry3>>, ReadError> {
    let viewpoint = |file: &PathBuf| {
        if Kind::of(file) != Some(Kind::Pcd) {
            return Ok(None);
        }
        let header = pcd::Header::parse(&read_head(file)?).map_err(|p| p.in_file(file))?;
        Ok(header.viewpoint)
    };
    files.iter().map(viewpoint).collect()
}

/// The isometries of a file's matrices, and a note if some had to be repaired.
fn isometries(file: &Path, matrices: &[[f64; 16]]) -> Result<Poses, ReadError> {
    let (mut poses, mut repairs) = (Vec::new(), Vec::new());
    for matrix in matrices {
        let damaged = |problem| ReadError::damaged(file, Place::Whole, problem);
        let pose = from_row_major(matrix).map_err(damaged)?;
        poses.push(pose.world_from_sensor);
        repairs.extend(pose.repaired.map(|deviation| (deviation, Place::Whole)));
    }
    let notes = repairs_note(file, &repairs, poses.len()).into_iter().collect();
    Ok(Poses { poses, notes, files: vec![file.to_owned()], ..Poses::default() })
}
