//! The order in which a file holds the pixels of an image.

use crate::{ImageError, ImageSize, RangeImage};
use std::fmt;

/// An order of the pixels in a file, where it is not the order of the sensor's rows and columns.
///
/// Nothing in an image tells its order: the surfaces that it shares with other views do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ImageOrder {
    /// The rows of the file are the columns of the sensor.
    Transposed,
    /// The columns run from right to left.
    Mirrored,
    /// The rows run from the bottom to the top, as graphics cards store them.
    UpsideDown,
    /// The image is right. The camera's numbers for columns and rows (fx and fy, cx and cy) are
    /// exchanged.
    SwappedCamera,
}

impl ImageOrder {
    /// Every order.
    pub const ALL: [Self; 4] =
        [Self::Transposed, Self::Mirrored, Self::UpsideDown, Self::SwappedCamera];

    /// The name by which options and reports call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Transposed => "transposed",
            Self::Mirrored => "mirrored",
            Self::UpsideDown => "upside-down",
            Self::SwappedCamera => "swapped-camera",
        }
    }

    /// The assumption of the order about the images, as a sentence without a full stop.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Transposed => "the rows of the files are the columns of the images",
            Self::Mirrored => "the columns of the images run from right to left",
            Self::UpsideDown => "the rows of the images run from the bottom to the top",
            Self::SwappedCamera => "fx and fy, and cx and cy, of the camera are exchanged",
        }
    }

    /// The image in the order of the sensor.
    ///
    /// # Errors
    /// None in practice: the size stays, or its rows and columns are exchanged.
    pub fn apply(self, image: RangeImage) -> Result<RangeImage, ImageError> {
        let ImageSize { rows, cols } = image.size();
        let size = match self {
            Self::Transposed => ImageSize { rows: cols, cols: rows },
            Self::Mirrored | Self::UpsideDown => image.size(),
            Self::SwappedCamera => return Ok(image),
        };
        let values = size.all_pixels().map(|pixel| {
            let (row, col) = match self {
                Self::Transposed => (pixel.col, pixel.row),
                Self::Mirrored => (pixel.row, cols - 1 - pixel.col),
                _ => (rows - 1 - pixel.row, pixel.col),
            };
            image.row(row)[col]
        });
        RangeImage::from_values(size, values.collect())
    }
}

impl fmt::Display for ImageOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
