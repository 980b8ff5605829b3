//! Poses of cloud files: world from sensor, one per file.
//!
//! In the order of precedence:
//!
//! 1. the file that the caller names, or `poses.txt` in the folder: one pose per file, in the order
//!    of the files' names, as lines of 12 (KITTI) or 16 numbers, or as four lines of 4 numbers;
//! 2. `NAME.pose.txt` beside each `NAME.pcd`, `.ply` or `.bin`: 4 × 4 or 3 × 4 numbers;
//! 3. `T_A_B.txt`: A from B, for the files A and B of the folder; A is the world;
//! 4. the line VIEWPOINT of PCD files;
//! 5. the identity, for a file alone.
//!
//! KITTI's poses are those of camera 0. A file `calib.txt` with a line `Tr:` (camera from lidar)
//! beside the clouds or in the folder above turns them into poses of the lidar.

use super::{Kind, pcd};
use crate::input::{read_head, read_text};
use crate::pose::from_row_major;
use crate::{Place, ReadError};
use std::path::{Path, PathBuf};
use transect_geometry::Isometry3;

/// The names of a trajectory and of a calibration in the folder of the clouds.
const TRAJECTORY: &str = "poses.txt";
const CALIBRATION: &str = "calib.txt";

/// The poses of all files, in their order.
pub(super) struct Poses {
    pub(super) poses: Vec<Isometry3>,
    pub(super) notes: Vec<String>,
    /// The files that state the poses.
    pub(super) files: Vec<PathBuf>,
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
            "{count} clouds without poses; pass --poses FILE with one line of 12 numbers per cloud \
             (KITTI, 3 × 4, world from sensor), or add {TRAJECTORY}, NAME.pose.txt or \
             T_TARGET_SOURCE.txt to the folder; a file alone needs no pose"
        );
        return Err(ReadError::damaged(path, Place::Whole, problem));
    }
    let note = format!(
        "{}: {known} of {} poses from VIEWPOINT lines: the points are taken to be in the frame of \
         the sensor",
        path.display(),
        files.len()
    );
    let notes = if known > 0 { vec![note] } else { Vec::new() };
    let poses = viewpoints.into_iter().map(Option::unwrap_or_default).collect();
    Ok(Poses { poses, notes, files: Vec::new() })
}

/// Poses of one file for all clouds.
fn of_trajectory(folder: &Path, file: &Path, clouds: &[PathBuf]) -> Result<Poses, ReadError> {
    let (mut poses, mut notes) = read(file)?;
    if poses.len() != clouds.len() {
        let problem = format!(
            "the file has {} poses; expected one for each of the {} clouds in {}",
            poses.len(),
            clouds.len(),
            folder.display()
        );
        return Err(ReadError::damaged(file, Place::Whole, problem));
    }
    let mut files = vec![file.to_owned()];
    if let Some((path, camera_from_lidar)) = calibration(folder)? {
        poses.iter_mut().for_each(|world_from_camera| *world_from_camera *= camera_from_lidar);
        let path_text = path.display();
        notes.push(format!("{path_text}: \"Tr:\" turns the poses of camera 0 into the lidar's"));
        files.push(path);
    }
    Ok(Poses { poses, notes, files })
}

/// KITTI's camera-from-lidar, from the folder of the clouds or the one above.
fn calibration(folder: &Path) -> Result<Option<(PathBuf, Isometry3)>, ReadError> {
    let above = folder.parent().map(|above| above.join(CALIBRATION));
    let places = [Some(folder.join(CALIBRATION)), above];
    let Some(path) = places.into_iter().flatten().find(|path| path.is_file()) else {
        return Ok(None);
    };
    let text = read_text(&path)?;
    for (line, text) in (1..).zip(text.lines()) {
        let Some(numbers) = text.strip_prefix("Tr:") else { continue };
        let at = Place::Line(line);
        let numbers = numbers_of(&path, &at, numbers)?;
        let (pose, _) = pose(&path, at, &numbers)?;
        return Ok(Some((path, pose)));
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
    let (mut poses, mut notes) = (Vec::new(), Vec::new());
    for file in &files {
        let (pose, note) = read_one(file)?;
        poses.push(pose);
        notes.extend(note);
    }
    Ok(Some(Poses { poses, notes, files }))
}

/// Files `T_A_B.txt` with one A for all other clouds; `None` if there is no such file.
fn of_pairs(folder: &Path, clouds: &[PathBuf]) -> Result<Option<Poses>, ReadError> {
    let stem = |path: &PathBuf| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let stems: Vec<String> = clouds.iter().map(stem).collect();
    let pair = |a: &String, b: &String| folder.join(format!("T_{a}_{b}.txt"));
    let Some(world) = stems.iter().find(|a| stems.iter().any(|b| pair(a, b).is_file())) else {
        return Ok(None);
    };
    let mut found = Poses { poses: Vec::new(), notes: Vec::new(), files: Vec::new() };
    found.notes.push(format!("{}: the world is the frame of {world}", folder.display()));
    for stem in &stems {
        if stem == world {
            found.poses.push(Isometry3::identity());
            continue;
        }
        let file = pair(world, stem);
        let (pose, note) = read_one(&file)?;
        found.poses.push(pose);
        found.notes.extend(note);
        found.files.push(file);
    }
    Ok(Some(found))
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

/// The one pose of a file.
fn read_one(file: &Path) -> Result<(Isometry3, Vec<String>), ReadError> {
    let (poses, notes) = read(file)?;
    let &[pose] = poses.as_slice() else {
        let problem = format!("the file has {} poses; expected one, of 4 × 4 numbers", poses.len());
        return Err(ReadError::damaged(file, Place::Whole, problem));
    };
    Ok((pose, notes))
}

/// All poses of a text file: lines of 12 or 16 numbers, or of 4 numbers in groups of four or three.
fn read(file: &Path) -> Result<(Vec<Isometry3>, Vec<String>), ReadError> {
    let text = read_text(file)?;
    let lines = (1..).zip(text.lines().map(str::trim));
    let mut lines = lines.filter(|(_, l)| !l.is_empty() && !l.starts_with('#')).peekable();
    let (mut poses, mut repaired, mut largest) = (Vec::new(), 0, 0.0_f64);
    while let Some((line, text)) = lines.next() {
        let mut numbers = numbers_of(file, &Place::Line(line), text)?;
        while numbers.len() % 4 == 0 && numbers.len() < 16 && text.split_whitespace().count() == 4 {
            let Some((line, text)) = lines.next() else { break };
            numbers.extend(numbers_of(file, &Place::Line(line), text)?);
        }
        let (pose, deviation) = pose(file, Place::Line(line), &numbers)?;
        poses.push(pose);
        repaired += usize::from(deviation.is_some());
        largest = largest.max(deviation.unwrap_or(0.0));
    }
    let note = format!(
        "{}: {repaired} of {} poses replaced by the nearest rotation; the largest deviation is \
         {largest:.1e}",
        file.display(),
        poses.len()
    );
    let notes = if repaired > 0 { vec![note] } else { Vec::new() };
    Ok((poses, notes))
}

fn numbers_of(file: &Path, at: &Place, text: &str) -> Result<Vec<f64>, ReadError> {
    let parse = |word: &str| {
        let start: String = word.chars().take(20).collect();
        word.parse().map_err(|_| {
            ReadError::damaged(file, at.clone(), format!("{start:?} is no number of a pose"))
        })
    };
    text.split(|c: char| c.is_whitespace() || c == ',')
        .filter(|w| !w.is_empty())
        .map(parse)
        .collect()
}

/// A pose, and how far it was from a rotation if it had to be repaired.
fn pose(file: &Path, at: Place, numbers: &[f64]) -> Result<(Isometry3, Option<f64>), ReadError> {
    let damaged = |problem: String| ReadError::damaged(file, at.clone(), problem);
    let full: Vec<f64> = match numbers.len() {
        12 => numbers.iter().chain(&[0.0, 0.0, 0.0, 1.0]).copied().collect(),
        _ => numbers.to_vec(),
    };
    let count = numbers.len();
    let full = full.try_into().map_err(|_| {
        damaged(format!("{count} numbers; a pose has 12 (3 × 4) or 16 (4 × 4), row by row"))
    })?;
    let pose = from_row_major(&full).map_err(damaged)?;
    Ok((pose.world_from_sensor, pose.repaired))
}
