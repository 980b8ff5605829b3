//! A folder of depth images with one pose file each, as the 7-Scenes data set has them.
//!
//! ```text
//! camera-intrinsics.txt       3 × 3: fx 0 cx / 0 fy cy / 0 0 1, pixels
//! frame-000000.depth.png      16-bit grey, millimetres along the optical axis, 0 = missing
//! frame-000000.pose.txt       4 × 4, row-major, metres, camera to world
//! ```
//!
//! The unit is part of the convention: metres, with a depth of 0.001 m per count.

use crate::input::read_text;
use crate::manifest::{self, Manifest, SensorEntry, ViewEntry};
use crate::{OpenOptions, Place, ReadError, Scan, pose};
use std::path::{Path, PathBuf};
use transect_geometry::LengthUnit;
use transect_sensors::Intrinsics;

/// The file by which a depth folder is recognised.
const INTRINSICS: &str = "camera-intrinsics.txt";
/// Metres per count of the images.
const DEPTH_SCALE: f64 = 0.001;
const IMAGE_SUFFIX: &str = ".depth.png";

/// The form of file names in the manifest of a folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileNames {
    /// By name alone, for a manifest inside the folder.
    Relative,
    /// By absolute path, for a manifest anywhere.
    Absolute,
}

/// Whether a folder is one of depth images.
pub(crate) fn is_one(folder: &Path) -> bool {
    folder.join(INTRINSICS).is_file()
}

pub(crate) fn open(folder: &Path, options: &OpenOptions) -> Result<Scan, ReadError> {
    let manifest = depth_folder_manifest(folder, FileNames::Relative)?;
    let mut scan = manifest::to_scan(folder, folder, &manifest, options.unit)?;
    let note = format!(
        "{}: metres, 0.001 m per count of the images: the convention of depth folders",
        folder.display()
    );
    scan.notes.insert(0, note);
    let poses = scan.views.iter().map(|v| pose_file(v.path()));
    let files: Vec<_> = std::iter::once(folder.join(INTRINSICS)).chain(poses).collect();
    scan.inputs.splice(0..0, files);
    Ok(scan)
}

/// The manifest of a folder of depth images, views sorted by name.
///
/// # Errors
/// [`ReadError`] if the intrinsics or a pose is missing or wrong, or there is no image.
pub fn depth_folder_manifest(folder: &Path, names: FileNames) -> Result<Manifest, ReadError> {
    let camera = intrinsics(&folder.join(INTRINSICS))?;
    let io = |e| ReadError::io(folder, e);
    let absolute = std::path::absolute(folder).map_err(io)?;
    let name = absolute.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut views = Vec::new();
    for image in images(folder).map_err(io)? {
        let file = match names {
            FileNames::Relative => image.clone(),
            FileNames::Absolute => absolute.join(&image).to_string_lossy().into_owned(),
        };
        let pose = read_pose(&pose_file(&folder.join(image)))?;
        let mut view = ViewEntry::new(file, camera.clone(), pose);
        view.scale = Some(DEPTH_SCALE);
        views.push(view);
    }
    if views.is_empty() {
        let problem = format!("no images *{IMAGE_SUFFIX} beside {INTRINSICS}");
        return Err(ReadError::damaged(folder, Place::Whole, problem));
    }
    let mut manifest = Manifest::new(name, views);
    manifest.unit = Some(LengthUnit::Metre);
    Ok(manifest)
}

fn images(folder: &Path) -> std::io::Result<Vec<String>> {
    let mut images = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if name.ends_with(IMAGE_SUFFIX) {
            images.push(name);
        }
    }
    images.sort();
    Ok(images)
}

fn pose_file(image: &Path) -> PathBuf {
    let name = image.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.strip_suffix(IMAGE_SUFFIX).unwrap_or(&name);
    image.with_file_name(format!("{stem}.pose.txt"))
}

fn read_pose(path: &Path) -> Result<[f64; 16], ReadError> {
    let numbers = numbers(path, "a pose of 4 × 4 numbers")?;
    // The scan checks poses, too, but here the message can name the pose's own file.
    let checked = pose::from_row_major(&numbers);
    checked.map_err(|problem| ReadError::damaged(path, Place::Whole, problem))?;
    Ok(numbers)
}

fn intrinsics(path: &Path) -> Result<SensorEntry, ReadError> {
    let wanted = "a camera matrix of 3 × 3 numbers";
    let [fx, skew, cx, zero, fy, cy, last @ ..] = numbers::<9>(path, wanted)?;
    if [skew, zero] != [0.0, 0.0] || last != [0.0, 0.0, 1.0] {
        let problem = "not a camera matrix fx 0 cx / 0 fy cy / 0 0 1";
        return Err(ReadError::damaged(path, Place::Whole, problem));
    }
    Ok(SensorEntry::pinhole(Intrinsics { fx, fy, cx, cy }))
}

/// Exactly `N` numbers, separated by white space.
fn numbers<const N: usize>(path: &Path, wanted: &str) -> Result<[f64; N], ReadError> {
    let text = read_text(path)?;
    let words = text.split_ascii_whitespace().map(str::parse);
    let parsed: Option<Vec<f64>> = words.map(Result::ok).collect();
    let wrong = || ReadError::damaged(path, Place::Whole, format!("not {wanted}"));
    parsed.and_then(|n| n.try_into().ok()).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_data::{IDENTITY_POSE, in_unit, write_png};

    fn folder(pose: &str, counts: &[u16]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(INTRINSICS), "2 0 0.5\n0 2 0.5\n0 0 1\n").unwrap();
        for name in ["b", "a"] {
            write_png(&folder.path().join(format!("{name}.depth.png")), 2, counts);
            std::fs::write(folder.path().join(format!("{name}.pose.txt")), pose).unwrap();
        }
        folder
    }

    #[test]
    fn a_folder_is_a_scan_in_metres_sorted_by_name() {
        let folder = folder(IDENTITY_POSE, &[1500, 0, 65535, 2500]);
        let scan = Scan::open(folder.path()).unwrap();
        assert_eq!(scan.unit, LengthUnit::Metre);
        let names: Vec<_> = scan.views.iter().map(|v| v.name()).collect();
        assert_eq!(names, ["a.depth.png", "b.depth.png"]);
        assert_eq!(scan.inputs.len(), 5, "intrinsics, poses and images: {:?}", scan.inputs);
        let (view, notes) = scan.views[0].load().unwrap();
        assert_eq!(view.image().valid_count(), 2);
        assert_eq!(view.image().extremes(), Some((1.5, 2.5)));
        assert!(notes[0].ends_with("1 pixels at the largest count, 65535, taken as missing"));
        let other = Scan::open_with(folder.path(), &in_unit(LengthUnit::Millimetre)).unwrap_err();
        assert!(matches!(other, ReadError::UnitConflict { .. }), "{other}");
    }

    #[test]
    fn its_manifest_can_be_written_and_opened_elsewhere() {
        let (images, elsewhere) = (folder(IDENTITY_POSE, &[9; 4]), tempfile::tempdir().unwrap());
        let manifest = depth_folder_manifest(images.path(), FileNames::Absolute).unwrap();
        let path = elsewhere.path().join("scan.json");
        crate::write_file(&path, |out| manifest::write_manifest(&manifest, out)).unwrap();
        let scan = Scan::open(elsewhere.path()).unwrap();
        assert_eq!(scan.notes, Vec::<String>::new());
        assert!(scan.views[1].load().is_ok());
    }

    #[test]
    fn a_bad_pose_names_its_own_file() {
        let bad = folder(&IDENTITY_POSE.replacen('1', "nan", 1), &[9; 4]);
        let error = Scan::open(bad.path()).unwrap_err().to_string();
        assert!(error.ends_with("a.pose.txt: the pose has a number that is not finite"), "{error}");
        let short = folder("1 0 0", &[9; 4]);
        let error = Scan::open(short.path()).unwrap_err().to_string();
        assert!(error.ends_with("a.pose.txt: not a pose of 4 × 4 numbers"), "{error}");
    }

    #[test]
    fn red_kitchen_opens_with_its_rounded_rotations_repaired() {
        let Some(folder) = crate::test_data::shared("rgbd_redkitchen") else { return };
        let scan = Scan::open(&folder).unwrap();
        assert_eq!(scan.views.len(), 50);
        let repaired = &scan.notes[1];
        assert!(repaired.contains("50 of 50 poses replaced by the nearest rotation"), "{repaired}");
        let (view, _) = scan.views[0].load().unwrap();
        assert_eq!(view.image().size().to_string(), "480 rows × 640 columns");
        let (nearest, farthest) = view.image().extremes().unwrap();
        assert!(nearest > 0.8 && farthest < 4.0, "metres: {nearest} to {farthest}");
    }
}
