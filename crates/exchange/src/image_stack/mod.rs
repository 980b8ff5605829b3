//! Stacks of a camera's intensity images, one per laser angle: a `.npy` of three dimensions or a
//! folder of `.png` files.
//!
//! Images are read one at a time and handed on, so that a stack may be larger than memory. Sizes
//! are compared with the camera's and with the file before memory is taken.

mod npy_stack;
mod png_folder;
#[cfg(test)]
mod tests;
mod write;

pub use write::{Counts, write_npy_stack, write_png_image};

use crate::{Place, ReadError};
use npy_stack::NpyStack;
use png_folder::PngFolder;
use std::path::{Path, PathBuf};
use transect_device::ImageSize;
use transect_sensors::light_stripe::stripe::IntensityImage;

/// A stack of known size whose images have not been read.
pub(crate) enum ImageStack {
    Npy(NpyStack),
    Folder(PngFolder),
}

/// The image of a stack, for messages.
pub(crate) struct Located<'a> {
    pub(crate) path: &'a Path,
    pub(crate) place: Place,
}

impl ImageStack {
    /// The stack at a path, of images of the camera's size; `None` if the path is not a stack.
    pub(crate) fn open(
        path: &Path,
        camera: ImageSize,
        notes: &mut Vec<String>,
    ) -> Result<Option<Self>, ReadError> {
        if path.is_dir() {
            return PngFolder::open(path, camera, notes).map(|f| Some(Self::Folder(f)));
        }
        let extension = path.extension().and_then(|e| e.to_str());
        if !extension.is_some_and(|e| e.eq_ignore_ascii_case("npy")) {
            return Ok(None);
        }
        Ok(NpyStack::open(path, camera, notes)?.map(Self::Npy))
    }

    /// The images in a folder, in their order.
    pub(crate) fn files_of_folder(path: &Path) -> Result<Vec<PathBuf>, ReadError> {
        png_folder::list(path).map(|(files, _)| files)
    }

    /// Number of images; not 0.
    pub(crate) fn steps(&self) -> usize {
        match self {
            Self::Npy(stack) => stack.steps(),
            Self::Folder(folder) => folder.steps(),
        }
    }

    /// Reads image after image, until one fails.
    pub(crate) fn for_each(
        &self,
        take: impl FnMut(Located<'_>, IntensityImage) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        match self {
            Self::Npy(stack) => stack.for_each(take),
            Self::Folder(folder) => folder.for_each(take),
        }
    }
}
