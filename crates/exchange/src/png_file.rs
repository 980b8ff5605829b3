//! Grey `.png` images of 8 or 16 bits.

use crate::{Place, ReadError};
use std::io::Cursor;
use std::path::Path;
use transect_device::{ImageSize, MAX_PIXELS};

/// Deflate packs at most 1032 bytes into one, so a larger image cannot be in the file.
const LARGEST_COMPRESSION: usize = 1032;

/// A decoded image.
pub(crate) struct GreyImage {
    pub(crate) size: ImageSize,
    pub(crate) samples: Samples,
}

/// Row-major counts.
pub(crate) enum Samples {
    Eight(Vec<u8>),
    Sixteen(Vec<u16>),
}

/// The image in a file's bytes.
pub(crate) fn decode(path: &Path, bytes: &[u8]) -> Result<GreyImage, ReadError> {
    let damaged = |text: String| ReadError::damaged(path, Place::Whole, text);
    let undecodable = |e: png::DecodingError| damaged(format!("cannot be decoded: {e}"));
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().map_err(undecodable)?;
    let (cols, rows) = reader.info().size();
    let size = ImageSize { rows: rows as usize, cols: cols as usize };
    let wide = match reader.output_color_type() {
        (png::ColorType::Grayscale, png::BitDepth::Eight) => false,
        (png::ColorType::Grayscale, png::BitDepth::Sixteen) => true,
        (colour, depth) => {
            let problem =
                format!("the image is {colour:?} {depth:?}; grey of 8 or 16 bits is read");
            return Err(ReadError::unsupported(path, Place::Whole, problem));
        }
    };
    let most = bytes.len().saturating_mul(LARGEST_COMPRESSION).min(2 * MAX_PIXELS);
    let needed = reader.output_buffer_size().filter(|&n| n <= most);
    let absurd = || damaged(format!("{size} cannot be in a file of {} bytes", bytes.len()));
    let mut bytes = vec![0; needed.ok_or_else(absurd)?];
    reader.next_frame(&mut bytes).map_err(undecodable)?;
    let samples = if wide {
        Samples::Sixteen(bytes.as_chunks().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect())
    } else {
        Samples::Eight(bytes)
    };
    Ok(GreyImage { size, samples })
}
