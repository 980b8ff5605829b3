//! Where a folder keeps the images, the poses and the camera of a depth sequence.

use crate::image_file::EXTENSIONS;
use crate::input::read_text;
use crate::{CameraOption, OpenOptions, Place, ReadError};
use std::path::{Path, PathBuf};

/// Metres per count where no layout says otherwise: sensors write millimetres.
const MILLIMETRES: f64 = 0.001;
/// Metres per count of TUM RGB-D, ICL-NUIM and ETH3D: 5000 counts per metre.
const TUM_SCALE: f64 = 1.0 / 5000.0;

/// Lists of images with their times; the second and third name the images of two cameras.
const LISTS: [&str; 3] = ["depth.txt", "associations.txt", "associated.txt"];
/// Files and folders that hold poses. ICL-NUIM's `*.gt.freiburg` is found by its extension.
const POSES: [&str; 10] = [
    "groundtruth.txt",
    "pose",
    "poses",
    "trajectory.log",
    "trajectory.json",
    "trajectory.txt",
    "poses.txt",
    "traj.txt",
    "scene/trajectory.log",
    "scene/trajectory.json",
];
/// Files that hold a camera. `calibration.txt` is ETH3D's; a `trajectory.json` may hold one, too.
const CAMERAS: [&str; 10] = [
    "camera-intrinsics.txt",
    "intrinsic/intrinsic_depth.txt",
    "calibration.txt",
    "camera.json",
    "camera_intrinsic.json",
    "intrinsic.json",
    "intrinsics.json",
    "camera.txt",
    "trajectory.json",
    "scene/trajectory.json",
];

/// One depth image of a sequence.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct DepthImage {
    /// The file, relative to the folder.
    pub(super) file: String,
    /// The time that a list states, or the number that is the file's name.
    pub(super) time: Option<f64>,
    /// The number at the end of the file's name.
    pub(super) number: Option<usize>,
}

/// The pieces of a sequence.
#[derive(Debug)]
pub(super) struct Layout {
    pub(super) images: Vec<DepthImage>,
    /// The file that lists the images, if there is one.
    pub(super) list: Option<PathBuf>,
    /// A trajectory, or a folder with one file per image.
    pub(super) poses: PathBuf,
    pub(super) camera: CameraOption,
    /// Metres per count of images of integers.
    pub(super) scale: f64,
}

/// Whether a folder is a depth sequence: it has a list of images, images, or 7-Scenes' camera.
pub(crate) fn is_one(folder: &Path) -> bool {
    let mut names = LISTS.iter().chain(CAMERAS.first());
    names.any(|name| folder.join(name).is_file())
        || [folder, &folder.join("depth")].iter().any(|f| !in_folder(f, "").is_empty())
}

impl Layout {
    /// The pieces in a folder. Those that the options name replace those of the folder.
    pub(super) fn find(folder: &Path, options: &OpenOptions) -> Result<Self, ReadError> {
        std::fs::read_dir(folder).map_err(|e| ReadError::io(folder, e))?;
        let list = LISTS.iter().map(|name| folder.join(name)).find(|path| path.is_file());
        let images = match &list {
            Some(list) => listed(list)?,
            None => unlisted(folder),
        };
        if images.is_empty() {
            let problem = format!(
                "no depth images; expected a list {}, files *.depth.png, or images ({}) in a \
                 folder \"depth\" or here",
                LISTS.join(" or "),
                EXTENSIONS.join(", ")
            );
            return Err(ReadError::damaged(
                list.as_deref().unwrap_or(folder),
                Place::Whole,
                problem,
            ));
        }
        let poses = options.poses.clone().or_else(|| poses_in(folder, &images));
        let poses =
            poses.ok_or_else(|| absent(folder, "poses", "the setting `poses`, a file", &POSES))?;
        let camera = options.camera.clone().or_else(|| camera_in(folder));
        let camera = camera.ok_or_else(|| {
            absent(folder, "camera", "the setting `camera`, a file or FX,FY,CX,CY", &CAMERAS)
        })?;
        let scale = if list.is_some() || is_tum(&poses) { TUM_SCALE } else { MILLIMETRES };
        Ok(Self { images, list, poses, camera, scale })
    }
}

fn absent(folder: &Path, what: &str, setting: &str, names: &[&str]) -> ReadError {
    let names = names.join(", ");
    let problem =
        format!("no {what} beside the depth images; pass {setting}, or add one of {names}");
    ReadError::damaged(folder, Place::Whole, problem)
}

/// Whether the name of a trajectory is TUM's or ICL-NUIM's.
fn is_tum(poses: &Path) -> bool {
    poses.ends_with("groundtruth.txt") || poses.extension().is_some_and(|e| e == "freiburg")
}

fn poses_in(folder: &Path, images: &[DepthImage]) -> Option<PathBuf> {
    // 7-Scenes has the poses beside the images.
    let beside = |image: &DepthImage| pose_file(folder, &image.file).is_some();
    if images.iter().any(beside) {
        return Some(folder.to_owned());
    }
    let known = POSES.iter().map(|name| folder.join(name)).find(|path| path.exists());
    known.or_else(|| files(folder).into_iter().map(|f| folder.join(f)).find(|f| is_tum(f)))
}

fn camera_in(folder: &Path) -> Option<CameraOption> {
    let mut known = CAMERAS.iter().map(|name| folder.join(name));
    known.find(|path| path.is_file()).map(CameraOption::File)
}

/// The file with the pose of an image, in a folder with one per image.
pub(super) fn pose_file(folder: &Path, image: &str) -> Option<PathBuf> {
    let stem = stem(image);
    let names = [format!("{stem}.pose.txt"), format!("{stem}.txt")];
    names.iter().map(|name| folder.join(name)).find(|path| path.is_file())
}

/// The name of an image without its folder, its extension and `.depth`.
pub(super) fn stem(image: &str) -> &str {
    let name = image.rsplit(['/', '\\']).next().unwrap_or(image);
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    stem.strip_suffix(".depth").unwrap_or(stem)
}

/// The images of a list, in its order. A line holds a time and a file, of one camera or of two.
fn listed(list: &Path) -> Result<Vec<DepthImage>, ReadError> {
    let text = read_text(list)?;
    let mut images = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let words: Vec<&str> = line.split_ascii_whitespace().take(5).collect();
        let (time, file) = match *words.as_slice() {
            [time, file] => (time, file),
            [time, file, _, other] if !other.starts_with("depth") => (time, file),
            [_, _, time, file] => (time, file),
            _ => ("", ""),
        };
        let Some(time) = time.parse().ok().filter(|t: &f64| t.is_finite()) else {
            let start: String = line.chars().take(40).collect();
            let problem = format!(
                "the line is {start:?}; expected a time and a file, or a time and a file of two \
                 cameras; correct the line, or make it a comment with \"#\""
            );
            return Err(ReadError::damaged(list, Place::Line(number), problem));
        };
        images.push(DepthImage { time: Some(time), ..image(file.to_owned()) });
    }
    Ok(images)
}

/// The images of a folder without a list, in the order of their numbers.
fn unlisted(folder: &Path) -> Vec<DepthImage> {
    let inside = || in_folder(&folder.join("depth"), "").into_iter().map(|f| format!("depth/{f}"));
    let mut names = in_folder(folder, ".depth");
    if names.is_empty() {
        names = inside().collect();
    }
    if names.is_empty() {
        names = in_folder(folder, "");
    }
    let mut images: Vec<DepthImage> = names.into_iter().map(image).collect();
    let key = |image: &DepthImage| {
        let stem = stem(&image.file);
        let prefix = stem.trim_end_matches(|c: char| c.is_ascii_digit()).to_owned();
        (prefix, image.number, image.file.clone())
    };
    images.sort_by_cached_key(key);
    images
}

fn image(file: String) -> DepthImage {
    let stem = stem(&file);
    let digits = stem.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let number: Option<usize> = stem.get(digits..).and_then(|digits| digits.parse().ok());
    let time = stem.parse().ok().filter(|t: &f64| t.is_finite()).or(number.map(|n| n as f64));
    DepthImage { file, time, number }
}

/// The images of a folder whose names end with `suffix` before the extension.
fn in_folder(folder: &Path, suffix: &str) -> Vec<String> {
    let is_image = |name: &String| {
        name.rsplit_once('.').is_some_and(|(stem, extension)| {
            let known = EXTENSIONS.iter().any(|e| extension.eq_ignore_ascii_case(e));
            known && stem.ends_with(suffix)
        })
    };
    files(folder).into_iter().filter(is_image).collect()
}

/// The names in a folder, sorted; none if it cannot be read.
fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<_> = entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
