//! Grey `.tif` images of 16-bit integers or of floating-point numbers.

use crate::input::check_announced;
use crate::{Place, ReadError};
use std::io::Cursor;
use std::path::Path;
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use transect_device::ImageSize;

/// Row-major numbers.
#[derive(Debug, PartialEq)]
pub(crate) enum TiffSamples {
    Counts(Vec<u16>),
    Singles(Vec<f32>),
    Doubles(Vec<f64>),
}

/// The first image in a file's bytes.
pub(crate) fn decode(path: &Path, bytes: &[u8]) -> Result<(ImageSize, TiffSamples), ReadError> {
    let undecodable = |e: tiff::TiffError| {
        ReadError::damaged(path, Place::Whole, format!("cannot be decoded: {e}"))
    };
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(undecodable)?;
    let (cols, rows) = decoder.dimensions().map_err(undecodable)?;
    let size = ImageSize { rows: rows as usize, cols: cols as usize };
    let color = decoder.colortype().map_err(undecodable)?;
    let unsupported = || {
        let problem = format!(
            "the image is {color:?}; grey of 16-bit integers, or of floating-point numbers of 32 \
             or 64 bits is read"
        );
        ReadError::unsupported(path, Place::Whole, problem)
    };
    let ColorType::Gray(bits @ (16 | 32 | 64)) = color else { return Err(unsupported()) };
    let needed = size.rows.checked_mul(size.cols);
    let needed = needed.and_then(|pixels| pixels.checked_mul(usize::from(bits / 8)));
    let needed = check_announced(path, size, needed, bytes.len())?;
    let mut limits = Limits::default();
    // A piece of the image, such as a tile, can be larger than the image by the tile's margin.
    (limits.decoding_buffer_size, limits.intermediate_buffer_size) = (needed, 2 * needed + TILE);
    limits.ifd_value_size = bytes.len();
    let samples = match decoder.with_limits(limits).read_image().map_err(undecodable)? {
        DecodingResult::U16(counts) => TiffSamples::Counts(counts),
        DecodingResult::F32(values) => TiffSamples::Singles(values),
        DecodingResult::F64(values) => TiffSamples::Doubles(values),
        _ => return Err(unsupported()),
    };
    Ok((size, samples))
}

/// Bytes of a usual tile: 256 × 256 numbers of 64 bits. Theory. Doubled, a damaged header may take
/// 512 KiB more.
const TILE: usize = 256 * 256 * 8;
