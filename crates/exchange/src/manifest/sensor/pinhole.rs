//! `pinhole`: a depth camera, with or without lens distortion.
//!
//! | key | meaning |
//! |---|---|
//! | `fx`, `fy`, `cx`, `cy` | focal lengths and principal point, in pixels |
//! | `distortion` | `[k1, k2, p1, p2, k3]`, radial and tangential (Brown, Conrady); optional |
//! | `rays` | instead of all of the above: a `.npy` of rows × cols × 3, the direction of every pixel's ray, NaN where there is none |
//! | `holds` | the pixels' values: `depth` along z (the default) or `ray_length` |
//! | `depth_offsets` | `{rows, cols, values, scale}`: what is added to 1 / depth at the nodes of a grid over the image, in 1 / length unit, after depths are multiplied by `scale`; optional, as is `scale`, see [`DepthOffsets`] |
//!
//! Column j, row i without distortion: the ray ((j − cx)/fx, (i − cy)/fy, 1), y down. With
//! distortion, the lens moves the ray to that place; see `distortion.rs` for the equations.

use super::super::keys::Keys;
use super::shared::Shared;
use super::{Sensor, distortion};
use crate::scan::FramedImage;
use crate::view_file::ViewFile;
use crate::{Place, ReadError, image_file};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect_device::{DepthOffsets, DeviceFrame, ImageOrder, ImageSize, RangeImage, Vector3};
use transect_sensors::{Intrinsics, Pinhole, PinholeScale, RayTable};

/// A depth camera in a manifest.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PinholeEntry {
    /// The rays of its pixels.
    #[serde(flatten)]
    pub lens: LensEntry,
    /// The meaning of its pixels' values, which are in the length unit.
    #[serde(skip_serializing_if = "is_usual")]
    pub holds: PinholeScale,
    /// The error of its depths, which is taken out of each image.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_offsets: Option<DepthOffsets>,
}

/// The rays of a camera's pixels.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum LensEntry {
    /// A lens by its parameters.
    Intrinsics {
        /// Focal lengths and principal point.
        #[serde(flatten)]
        intrinsics: Intrinsics,
        /// `[k1, k2, p1, p2, k3]` for image places in focal lengths; `None` for a straight lens.
        #[serde(skip_serializing_if = "Option::is_none")]
        distortion: Option<[f64; 5]>,
    },
    /// A ray per pixel.
    Rays {
        /// The `.npy` file with the rays, relative to the manifest or absolute.
        rays: String,
    },
}

/// Whether the value is the default, which is not written.
fn is_usual(holds: &PinholeScale) -> bool {
    *holds == PinholeScale::default()
}

impl PinholeEntry {
    pub(super) fn read(keys: &Keys<'_>) -> Result<Self, ReadError> {
        let lens = match keys.optional("rays")? {
            Some(rays) => LensEntry::Rays { rays },
            None => LensEntry::Intrinsics {
                intrinsics: keys.fields()?,
                distortion: keys.optional("distortion")?,
            },
        };
        let holds = keys.optional("holds")?.unwrap_or_default();
        Ok(Self { lens, holds, depth_offsets: keys.optional("depth_offsets")? })
    }

    /// The camera. A file with rays is relative to `folder`.
    pub(super) fn sensor(&self, folder: &Path) -> PinholeSensor {
        let lens = match &self.lens {
            LensEntry::Rays { rays } => Lens::Rays(folder.join(rays)),
            &LensEntry::Intrinsics { intrinsics, distortion } => {
                // Without distortion, the closed form is faster and finds pixels between rays.
                match distortion.filter(|k| k.iter().any(|k| *k != 0.0)) {
                    Some(distortion) => Lens::Distorted(intrinsics, distortion),
                    None => Lens::Straight(intrinsics),
                }
            }
        };
        let depth_offsets = self.depth_offsets.clone();
        PinholeSensor { lens, holds: self.holds, depth_offsets, tables: Shared::default() }
    }
}

#[derive(Debug)]
pub(super) struct PinholeSensor {
    lens: Lens,
    holds: PinholeScale,
    depth_offsets: Option<DepthOffsets>,
    tables: Shared<RayTable>,
}

#[derive(Debug)]
enum Lens {
    Straight(Intrinsics),
    Distorted(Intrinsics, [f64; 5]),
    Rays(PathBuf),
}

impl Sensor for PinholeSensor {
    fn file(&self) -> Option<&Path> {
        match &self.lens {
            Lens::Rays(path) => Some(path),
            _ => None,
        }
    }

    /// The tables of bent rays belong to the camera's numbers as they are.
    fn reads(&self, order: ImageOrder) -> bool {
        order != ImageOrder::SwappedCamera || matches!(self.lens, Lens::Straight(_))
    }

    fn load(&self, file: &ViewFile, notes: &mut Vec<String>) -> Result<FramedImage, ReadError> {
        let image = file.load_image(notes)?;
        let size = image.size();
        let swaps = file.order == Some(ImageOrder::SwappedCamera);
        let mut straight = |intrinsics| {
            notes.extend(beside(size, intrinsics));
            let camera = Pinhole::new(size, intrinsics).map_err(|e| file.bad_sensor(e))?;
            Ok(camera.with_scale(self.holds))
        };
        let frame: Arc<dyn DeviceFrame> = match &self.lens {
            Lens::Straight(numbers) => {
                Arc::new(straight(if swaps { swapped(*numbers) } else { *numbers })?)
            }
            Lens::Distorted(intrinsics, distortion) => {
                straight(*intrinsics)?;
                let make = || self.distorted(file, size, *intrinsics, *distortion);
                self.tables.get_or_make(size, make)?
            }
            Lens::Rays(path) => self.tables.get_or_make(size, || self.by_rays(file, size, path))?,
        };
        let image = match &self.depth_offsets {
            Some(offsets) => corrected(offsets, frame.as_ref(), &image, file, notes)?,
            None => image,
        };
        Ok(FramedImage { frame, image })
    }
}

/// The image without the error of its depths. Pixels that the offsets take behind the camera are
/// missing, with a note.
fn corrected(
    offsets: &DepthOffsets,
    frame: &dyn DeviceFrame,
    image: &RangeImage,
    file: &ViewFile,
    notes: &mut Vec<String>,
) -> Result<RangeImage, ReadError> {
    let corrected = offsets.correct(frame, image).map_err(|e| file.unusable("the image", e))?;
    let lost = image.valid_count() - corrected.valid_count();
    if lost > 0 {
        notes.push(format!(
            "\"depth_offsets\" take {lost} pixels behind the camera; they are missing now. The \
             offsets are added to 1 / depth, in 1 / length unit"
        ));
    }
    Ok(corrected)
}

/// A note on a principal point outside the image.
fn beside(size: ImageSize, Intrinsics { cx, cy, .. }: Intrinsics) -> Option<String> {
    let within = |at: f64, count: usize| (-0.5..count as f64 - 0.5).contains(&at);
    let inside = within(cx, size.cols) && within(cy, size.rows);
    (!inside).then(|| {
        format!(
            "the principal point cx = {cx}, cy = {cy} lies outside the image of {size}. That is \
             right for a part of a larger image only; cx counts columns and cy rows, from 0"
        )
    })
}

/// The numbers for columns in place of those for rows, and the reverse.
fn swapped(Intrinsics { fx, fy, cx, cy }: Intrinsics) -> Intrinsics {
    Intrinsics { fx: fy, fy: fx, cx: cy, cy: cx }
}

impl PinholeSensor {
    fn distorted(
        &self,
        file: &ViewFile,
        size: ImageSize,
        intrinsics: Intrinsics,
        distortion: [f64; 5],
    ) -> Result<RayTable, ReadError> {
        let rays = distortion::rays(size, intrinsics, distortion).map_err(|pixel| {
            let problem = "\"distortion\" cannot be inverted here: no ray, or more than one, is \
                           bent onto this pixel";
            ReadError::damaged(&file.path, Place::Pixel(pixel), problem)
        })?;
        RayTable::new(size, rays, self.holds).map_err(|e| file.bad_sensor(e))
    }

    fn by_rays(
        &self,
        file: &ViewFile,
        size: ImageSize,
        path: &Path,
    ) -> Result<RayTable, ReadError> {
        let mut leftovers = Vec::new();
        let (found, rays) = image_file::read_points(path, Some(1.0), &mut leftovers)?;
        // All views share the table, so a note could not name one of them.
        if !leftovers.is_empty() {
            let problem = "\"rays\" has bytes after its last number; save the array alone";
            return Err(ReadError::damaged(path, Place::Whole, problem));
        }
        if found != size {
            let image = file.path.display();
            let problem = format!("\"rays\" has {found}, but the image {image} has {size}");
            return Err(ReadError::damaged(path, Place::Whole, problem));
        }
        let rays: Vec<Vector3> = rays.into_iter().map(|r| r.coords).collect();
        RayTable::new(size, rays, self.holds)
            .map_err(|e| ReadError::unusable(path, Place::Whole, "\"rays\"", e))
    }
}
