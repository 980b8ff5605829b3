//! One intensity image of the camera, up to 16 bits deep.

use transect_device::{ImageError, ImageSize};

/// Intensities in counts, row-major, row 0 first, one per camera cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IntensityImage {
    size: ImageSize,
    counts: Vec<u16>,
}

impl IntensityImage {
    /// An image of 8-bit counts.
    ///
    /// # Errors
    /// [`ImageError`] if the size is absurd or the number of counts differs from it.
    pub fn from_u8(size: ImageSize, counts: Vec<u8>) -> Result<Self, ImageError> {
        Self::from_u16(size, counts.into_iter().map(u16::from).collect())
    }

    /// An image of 16-bit counts.
    ///
    /// # Errors
    /// [`ImageError`] if the size is absurd or the number of counts differs from it.
    pub fn from_u16(size: ImageSize, counts: Vec<u16>) -> Result<Self, ImageError> {
        size.check()?;
        if counts.len() != size.pixels() {
            return Err(ImageError::WrongCount { size, found: counts.len() });
        }
        Ok(Self { size, counts })
    }

    /// Rows and columns.
    pub fn size(&self) -> ImageSize {
        self.size
    }

    /// Replaces `out` by the counts of one row; empties it for a row outside the image.
    pub fn copy_row(&self, row: usize, out: &mut Vec<f64>) {
        let start = row.saturating_mul(self.size.cols);
        let counts = self.counts.get(start..start.saturating_add(self.size.cols));
        out.clear();
        out.extend(counts.into_iter().flatten().copied().map(f64::from));
    }
}
