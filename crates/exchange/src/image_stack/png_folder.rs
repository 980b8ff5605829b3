//! A stack in a folder: `.png` files in the order of their names.

use super::Located;
use crate::input::read_bytes;
use crate::png_file::{self, Samples};
use crate::{Place, ReadError};
use std::path::{Path, PathBuf};
use transect_device::ImageSize;
use transect_sensors::light_stripe::stripe::IntensityImage;

pub(crate) struct PngFolder {
    files: Vec<PathBuf>,
    size: ImageSize,
}

impl PngFolder {
    pub(super) fn open(
        path: &Path,
        camera: ImageSize,
        notes: &mut Vec<String>,
    ) -> Result<Self, ReadError> {
        let (files, others) = list(path)?;
        if others > 0 {
            notes.push(format!("{others} files that are no .png ignored"));
        }
        let folder = Self { files, size: camera };
        // The first image is checked before memory for the whole stack is taken.
        if let Some(first) = folder.files.first() {
            folder.image(first)?;
        }
        Ok(folder)
    }

    pub(super) fn steps(&self) -> usize {
        self.files.len()
    }

    pub(super) fn for_each(
        &self,
        mut take: impl FnMut(Located<'_>, IntensityImage) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        for path in &self.files {
            take(Located { path, place: Place::Whole }, self.image(path)?)?;
        }
        Ok(())
    }

    fn image(&self, path: &Path) -> Result<IntensityImage, ReadError> {
        let bytes = read_bytes(path)?;
        let png = png_file::decode(path, &bytes)?;
        let (size, camera) = (png.size, self.size);
        if size != camera {
            let problem = format!("the image has {size}, but the camera {camera}");
            return Err(ReadError::damaged(path, Place::Whole, problem));
        }
        let image = match png.samples {
            Samples::Eight(counts) => IntensityImage::from_u8(size, counts),
            Samples::Sixteen(counts) => IntensityImage::from_u16(size, counts),
        };
        image.map_err(|e| ReadError::unusable(path, Place::Whole, "the image", e))
    }
}

/// The `.png` files of a folder in the order of their names, at least one, and how many other
/// files there are.
pub(super) fn list(path: &Path) -> Result<(Vec<PathBuf>, usize), ReadError> {
    let io = |e| ReadError::io(path, e);
    let (mut files, mut others) = (Vec::new(), 0);
    for entry in std::fs::read_dir(path).map_err(io)? {
        let file = entry.map_err(io)?.path();
        let extension = file.extension().and_then(|e| e.to_str());
        if extension.is_some_and(|e| e.eq_ignore_ascii_case("png")) {
            files.push(file);
        } else {
            others += 1;
        }
    }
    if files.is_empty() {
        let problem = "no .png images in this folder, which a view names as its stack";
        return Err(ReadError::damaged(path, Place::Whole, problem));
    }
    files.sort();
    Ok((files, others))
}
