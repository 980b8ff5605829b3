//! The image file of one view, with the facts that its manifest states about the image.

use crate::image_file::{self, Pixels};
use crate::missing::{self, MissingValue};
use crate::{Place, ReadError, Unusable};
use std::path::PathBuf;
use transect_device::{ImageOrder, ImageSize, Point3, RangeImage};
use transect_sensors::SensorError;

/// An image file, and the size and scale that the manifest states.
#[derive(Debug, Clone)]
pub(crate) struct ViewFile {
    pub(crate) path: PathBuf,
    /// Rows of the range image, where the manifest states them.
    pub(crate) stated_rows: Option<usize>,
    /// Columns of the range image, where the manifest states them.
    pub(crate) stated_cols: Option<usize>,
    /// Length units per count of an integer image.
    pub(crate) scale: Option<f64>,
    /// The value of pixels without a return, where the manifest states it.
    pub(crate) missing: Option<MissingValue>,
    /// The order of the pixels in the file, where it is another than the sensor's.
    pub(crate) order: Option<ImageOrder>,
}

impl ViewFile {
    /// The range image in the file. Its size must be the stated one.
    pub(crate) fn load_image(&self, notes: &mut Vec<String>) -> Result<RangeImage, ReadError> {
        let Pixels { size, mut values, .. } = image_file::read(&self.path, self.scale, notes)?;
        self.check_size(size)?;
        missing::clear_stated(&mut values, self.mark()).map_err(|p| p.in_file(&self.path))?;
        let image = RangeImage::from_values(size, values);
        let image = match self.order {
            Some(order) => image.and_then(|image| order.apply(image)),
            None => image,
        };
        let image = image.map_err(|e| self.unusable("the image", e))?;
        missing::without_marks(image, notes).map_err(|p| p.in_file(&self.path))
    }

    /// The grid of points in the file. Its size must be the stated one.
    pub(crate) fn load_points(
        &self,
        notes: &mut Vec<String>,
    ) -> Result<(ImageSize, Vec<Point3>), ReadError> {
        let (size, mut points) = image_file::read_points(&self.path, self.scale)?;
        self.check_size(size)?;
        missing::clear_points(size, &mut points, self.mark(), notes)
            .map_err(|p| p.in_file(&self.path))?;
        Ok((size, points))
    }

    /// The value of missing pixels after the file's scale.
    fn mark(&self) -> Option<MissingValue> {
        Some(self.missing?.scaled(self.scale.unwrap_or(1.0)))
    }

    pub(crate) fn damaged(&self, problem: impl Into<String>) -> ReadError {
        ReadError::damaged(&self.path, Place::Whole, problem)
    }

    /// The error for numbers of the view that do not make `what`.
    pub(crate) fn unusable(&self, what: &'static str, why: impl Into<Unusable>) -> ReadError {
        ReadError::unusable(&self.path, Place::Whole, what, why)
    }

    pub(crate) fn bad_sensor(&self, why: SensorError) -> ReadError {
        self.unusable("the sensor", why)
    }

    pub(crate) fn check_size(&self, found: ImageSize) -> Result<(), ReadError> {
        let stated = ImageSize {
            rows: self.stated_rows.unwrap_or(found.rows),
            cols: self.stated_cols.unwrap_or(found.cols),
        };
        if stated == found {
            return Ok(());
        }
        let problem = format!(
            "the image has {found}, but the manifest or the camera file states {stated}, or most \
             images have them"
        );
        Err(self.damaged(problem))
    }
}
