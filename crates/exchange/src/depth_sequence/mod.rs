//! Folders of depth images with a camera and a pose for each image.
//!
//! | layout | images | poses | camera | metres per count |
//! |---|---|---|---|---|
//! | 7-Scenes | `*.depth.png` | `*.pose.txt` beside each | `camera-intrinsics.txt` | 1/1000 |
//! | TUM RGB-D, ETH3D | listed in `depth.txt` | `groundtruth.txt` | `calibration.txt` (ETH3D) | 1/5000 |
//! | ICL-NUIM | listed in `associations.txt`, or `depth/N.png` | `*.gt.freiburg` | none | 1/5000 |
//! | ScanNet | `depth/N.png` | `pose/N.txt` | `intrinsic/intrinsic_depth.txt` | 1/1000 |
//! | Open3D, Redwood | `depth/N.png` | `trajectory.log` or `.json` | `intrinsic.json` | 1/1000 |
//!
//! The caller can name the poses and the camera (`OpenOptions`); then any folder with depth images
//! is a sequence. Lengths are metres. Images of floating-point numbers hold metres. The depth is
//! along the optical axis; x is right and y down. All layouts end in a [`Manifest`].

mod association;
mod camera;
mod layouts;
#[cfg(test)]
mod tests;

pub(crate) use layouts::is_one;

use crate::image_file::{self, Pixels};
use crate::manifest::{self, Manifest, ViewEntry};
use crate::posed_scan::stated;
use crate::{CameraOption, OpenOptions, Place, ReadError, Scan};
use association::associate;
use camera::Camera;
use layouts::Layout;
use std::path::{Path, PathBuf};
use transect_device::{ImageSize, Note, median};
use transect_geometry::LengthUnit;

/// Images that are read when a sequence is opened, for their kind of numbers and their depths.
/// Chosen by hand: a wrong scale shows in one image. Doubled, opening takes 30 ms longer.
const SAMPLE: usize = 3;

/// The form of file names in the manifest of a folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileNames {
    /// By name alone, for a manifest inside the folder.
    Relative,
    /// By absolute path, for a manifest anywhere.
    Absolute,
}

/// A sequence as a manifest, with the files behind it.
#[derive(Debug)]
struct Sequence {
    manifest: Manifest,
    notes: Vec<Note>,
    inputs: Vec<PathBuf>,
}

pub(crate) fn open(folder: &Path, options: &OpenOptions) -> Result<Scan, ReadError> {
    let Sequence { manifest, notes, inputs } = sequence(folder, FileNames::Relative, options)?;
    let mut scan = manifest::to_scan(folder, folder, &manifest, options.unit)?;
    scan.notes.splice(0..0, notes);
    scan.inputs.splice(0..0, inputs);
    Ok(scan)
}

/// The manifest of a folder of depth images, and notes on assumptions and images without a pose.
///
/// # Errors
/// [`ReadError`] if images, poses or the camera are missing or wrong, or no image has a pose.
pub fn depth_sequence_manifest(
    folder: &Path,
    names: FileNames,
    options: &OpenOptions,
) -> Result<(Manifest, Vec<Note>), ReadError> {
    sequence(folder, names, options).map(|found| (found.manifest, found.notes))
}

fn sequence(folder: &Path, names: FileNames, options: &OpenOptions) -> Result<Sequence, ReadError> {
    let layout = Layout::find(folder, options)?;
    let (camera, turned) = Camera::read(&layout.camera)?.with_y_down();
    let association = associate(&layout, options)?;
    let images = association.poses.iter().filter_map(|(index, _)| layout.images.get(*index));
    let images: Vec<&str> = images.map(|image| image.file.as_str()).collect();
    let sample = Sample::of(folder, &images);
    let (scale, kind) = scale(folder, &layout, &sample, options)?;
    let absolute = std::path::absolute(folder).map_err(|e| ReadError::io(folder, e))?;
    let view = |(&file, (_, pose)): (&&str, &(usize, [f64; 16]))| {
        let (file, name) = match names {
            FileNames::Relative => (file.to_owned(), None),
            FileNames::Absolute => (stated(absolute.join(file))?, Some(file.to_owned())),
        };
        let pose = if turned { with_y_turned(*pose) } else { *pose };
        let rows = camera.rows.or(sample.size.map(|size| size.rows));
        let cols = camera.cols.or(sample.size.map(|size| size.cols));
        let sensor = camera.sensor(options.pixels_hold.unwrap_or_default());
        Ok(ViewEntry { name, rows, cols, scale, ..ViewEntry::new(file, sensor, pose) })
    };
    let views = images.iter().zip(&association.poses).map(view);
    let views = views.collect::<Result<_, ReadError>>()?;
    let name = absolute.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let manifest = Manifest { unit: Some(LengthUnit::Metre), ..Manifest::new(name, views) };
    let about = |text: &str| Note::about(folder.display(), text);
    let mut notes = vec![about(&format!("metres, {kind}{}", sample.depths(scale)))];
    notes.extend(
        options
            .pixels_hold
            .map(|scale| about(&format!("images are read as asked for: {}", scale.meaning()))),
    );
    notes.extend(turned.then(|| about(Y_TURNED)));
    notes.extend(association.notes);
    let camera_file = match layout.camera {
        CameraOption::File(path) => Some(path),
        CameraOption::Numbers(_) => None,
    };
    let inputs = camera_file.into_iter().chain(layout.list).chain(association.files).collect();
    Ok(Sequence { manifest, notes, inputs })
}

/// The length units per count for the views, and words for the note.
fn scale(
    folder: &Path,
    layout: &Layout,
    sample: &Sample,
    options: &OpenOptions,
) -> Result<(Option<f64>, String), ReadError> {
    match options.depth_scale {
        // Metres are the coarsest unit in which an image can hold depths.
        Some(scale) if !(scale > 0.0 && scale <= 1.0) => {
            let problem = format!(
                "the setting `depth_scale` is {scale}; it is the metres per count, above 0 and at \
                 most 1; for N counts per metre, pass 1/N (for 1000: 0.001)"
            );
            Err(ReadError::damaged(folder, Place::Whole, problem))
        }
        Some(scale) => Ok((Some(scale), format!("{scale} m per count, as stated"))),
        None if sample.integers => {
            let scale = layout.scale;
            Ok((Some(scale), format!("{scale} m per count, the convention of this layout")))
        }
        None => Ok((None, "the images hold floating-point numbers".to_owned())),
    }
}

/// The note of [`with_y_turned`].
const Y_TURNED: &str = "the focal length fy is negative, so y points up in the camera and in the \
                        poses; both are turned to y down, which mirrors the world's y";

/// A pose whose camera and world have y down instead of up: both sides of it change their sign.
fn with_y_turned(mut pose: [f64; 16]) -> [f64; 16] {
    for (place, number) in pose.iter_mut().enumerate() {
        if (place / 4 == 1) != (place % 4 == 1) {
            *number = -*number;
        }
    }
    pose
}

/// The values of a few images, in counts.
struct Sample {
    /// Whether the images hold integers; also if none could be read.
    integers: bool,
    /// The size that most of the images have, the first of equally many. The camera is that of all
    /// images, so an image of another size is not its own.
    size: Option<ImageSize>,
    /// Least, median and largest depth of each image.
    depths: Vec<[f64; 3]>,
}

impl Sample {
    /// A sample of the first, the last and other images. Unreadable ones are left out here: each
    /// view reports its own problems when it is loaded.
    fn of(folder: &Path, images: &[&str]) -> Self {
        let mut sample = Self { integers: true, size: None, depths: Vec::new() };
        let mut sizes = Vec::new();
        let last = images.len().saturating_sub(1);
        let mut places: Vec<usize> = (0..SAMPLE).map(|k| k * last / (SAMPLE - 1)).collect();
        places.dedup();
        for image in places.iter().filter_map(|place| images.get(*place)) {
            let read = image_file::read(&folder.join(image), Some(1.0), &mut Vec::new());
            let Ok(Pixels { mut values, integers, size }) = read else { continue };
            sample.integers = integers;
            sizes.push(size);
            values.retain(|v| *v > 0.0 && v.is_finite());
            let depths = || values.iter().map(|depth| f64::from(*depth));
            let extremes = depths().reduce(f64::min).zip(depths().reduce(f64::max));
            if let (Some((least, largest)), Some(median)) = (extremes, median(depths())) {
                sample.depths.push([least, median, largest]);
            }
        }
        let count = |size: &ImageSize| sizes.iter().filter(|other| *other == size).count();
        // Of equal counts, `max_by_key` takes the last.
        sample.size = sizes.iter().rev().max_by_key(|size| count(size)).copied();
        sample
    }

    /// Words for the note: least and largest depth, and the median of the image between others.
    fn depths(&self, scale: Option<f64>) -> String {
        let metres = |of: fn(&[f64; 3]) -> f64| {
            self.depths.iter().map(move |depths| of(depths) * scale.unwrap_or(1.0))
        };
        let least = metres(|[least, ..]| *least).reduce(f64::min);
        let middle = median(metres(|[_, median, _]| *median));
        let largest = metres(|[.., largest]| *largest).reduce(f64::max);
        match (least, middle, largest) {
            (Some(least), Some(median), Some(largest)) => format!(
                "; depths {least:.3} to {largest:.3} m, median {median:.3} m, in a sample of {}",
                self.depths.len()
            ),
            _ => String::new(),
        }
    }
}
