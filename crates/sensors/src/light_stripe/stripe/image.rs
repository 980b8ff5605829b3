//! One intensity image of the camera, 8 or 16 bits deep.

use transect_device::{ImageError, ImageSize, MAX_PIXELS};

/// Intensities in counts, row-major, row 0 first, one per camera cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IntensityImage {
    size: ImageSize,
    counts: Counts,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Counts {
    Bits8(Vec<u8>),
    Bits16(Vec<u16>),
}

impl IntensityImage {
    /// An image of 8-bit counts.
    ///
    /// # Errors
    /// [`ImageError`] if the size is absurd or the number of counts differs from it.
    pub fn from_u8(size: ImageSize, counts: Vec<u8>) -> Result<Self, ImageError> {
        check(size, counts.len())?;
        Ok(Self { size, counts: Counts::Bits8(counts) })
    }

    /// An image of 16-bit counts.
    ///
    /// # Errors
    /// [`ImageError`] if the size is absurd or the number of counts differs from it.
    pub fn from_u16(size: ImageSize, counts: Vec<u16>) -> Result<Self, ImageError> {
        check(size, counts.len())?;
        Ok(Self { size, counts: Counts::Bits16(counts) })
    }

    /// Rows and columns.
    pub fn size(&self) -> ImageSize {
        self.size
    }

    /// Replaces `out` by the counts of one row; empties it for a row outside the image.
    pub fn copy_row(&self, row: usize, out: &mut Vec<f64>) {
        let start = row.saturating_mul(self.size.cols);
        let places = start..start.saturating_add(self.size.cols);
        out.clear();
        match &self.counts {
            Counts::Bits8(all) => {
                out.extend(all.get(places).into_iter().flatten().map(|&c| f64::from(c)))
            }
            Counts::Bits16(all) => {
                out.extend(all.get(places).into_iter().flatten().map(|&c| f64::from(c)))
            }
        }
    }
}

fn check(size: ImageSize, found: usize) -> Result<(), ImageError> {
    let ImageSize { rows, cols } = size;
    match rows.checked_mul(cols) {
        Some(n) if n > 0 && n <= MAX_PIXELS && n == found => Ok(()),
        Some(n) if n > 0 && n <= MAX_PIXELS => Err(ImageError::WrongCount { size, found }),
        _ => Err(ImageError::AbsurdSize { rows, cols }),
    }
}
