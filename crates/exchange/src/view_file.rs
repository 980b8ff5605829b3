//! The image file of one view, with the facts that its manifest states about the image.

use crate::image_file::{self, Pixels};
use crate::missing::{self, MissingValue, Origin};
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
        missing::clear_stated(&mut values, self.marks()).map_err(|p| p.in_file(&self.path))?;
        let unusable = |e| self.unusable("the image", e);
        let image = RangeImage::from_values(size, values).map_err(unusable)?;
        // In the file's own order, since errors name its rows and columns.
        let image = missing::without_marks(image, notes).map_err(|p| p.in_file(&self.path))?;
        match self.order {
            Some(order) => order.apply(image).map_err(unusable),
            None => Ok(image),
        }
    }

    /// The grid of points in the file. Its size must be the stated one.
    pub(crate) fn load_points(
        &self,
        notes: &mut Vec<String>,
    ) -> Result<(ImageSize, Vec<Point3>), ReadError> {
        let (size, mut points) = image_file::read_points(&self.path, self.scale, notes)?;
        self.check_size(size)?;
        missing::clear_stated_point(&mut points, self.marks())
            .and_then(|()| missing::clear_points(size, &mut points, Origin::Manifest, notes))
            .map_err(|p| p.in_file(&self.path))?;
        Ok((size, points))
    }

    /// The values of missing pixels after the file's scale. A file of 32-bit numbers holds the
    /// stated value rounded to 32 bits, and its pixels are scaled after that.
    fn marks(&self) -> Option<[MissingValue; 2]> {
        let scale = self.scale.unwrap_or(1.0);
        self.missing.map(|stated| [stated, stated.single()].map(|mark| mark.scaled(scale)))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_data::{write_npy, write_to_folder};

    fn file(path: PathBuf, scale: Option<f64>, missing: MissingValue) -> ViewFile {
        let missing = Some(missing);
        ViewFile { path, stated_rows: None, stated_cols: None, scale, missing, order: None }
    }

    /// 9999.9 is no 32-bit number: the file holds the nearest one.
    #[test]
    fn a_stated_value_is_found_in_files_of_32_bit_numbers() {
        let (_folder, path) = write_to_folder("a.npy", b"");
        for scale in [None, Some(0.001)] {
            write_npy(&path, &[2, 2], &[9999.9, 500.0, 510.0, 520.0]);
            let range = file(path.clone(), scale, MissingValue::Number(9999.9));
            assert_eq!(range.load_image(&mut Vec::new()).unwrap().valid_count(), 3, "{scale:?}");
            write_npy(&path, &[1, 2, 3], &[9999.9, 0.1, 1.0, 500.0, 2.0, 3.0]);
            let grid = file(path.clone(), scale, MissingValue::Point([9999.9, 0.1, 1.0]));
            let (_, points) = grid.load_points(&mut Vec::new()).unwrap();
            assert!(points[0].x.is_nan() && points[1].x > 0.0, "{scale:?}: {points:?}");
        }
    }

    #[test]
    fn a_stated_value_is_found_in_files_of_64_bit_numbers() {
        let mut bytes = Vec::new();
        crate::npy::write_header(&mut bytes, "<f8", &[1, 2]).unwrap();
        bytes.extend([9999.9_f64, 500.0].iter().flat_map(|v| v.to_le_bytes()));
        let (_folder, path) = write_to_folder("a.npy", &bytes);
        let range = file(path, Some(0.001), MissingValue::Number(9999.9));
        assert_eq!(range.load_image(&mut Vec::new()).unwrap().valid_count(), 1);
    }
}
