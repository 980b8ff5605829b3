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
    check_tags(path, bytes)?;
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(undecodable)?;
    let (cols, rows) = decoder.dimensions().map_err(undecodable)?;
    let size = ImageSize { rows: rows as usize, cols: cols as usize };
    let color = decoder.colortype().map_err(undecodable)?;
    let unsupported = || {
        let problem = format!(
            "the image is {color:?}; expected one channel of unsigned 16-bit integers, or of \
             floating-point numbers of 32 or 64 bits; convert it"
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

/// Refuses a file whose first directory announces a tag larger than the file. The decoder takes
/// memory for tags before its limits can be set.
fn check_tags(path: &Path, bytes: &[u8]) -> Result<(), ReadError> {
    let big_endian = bytes.starts_with(b"MM");
    let number = |at: usize, length: usize| -> Option<usize> {
        let digits = bytes.get(at..at.checked_add(length)?)?.iter().map(|b| usize::from(*b));
        let join = |sum: usize, digit: usize| sum << 8 | digit;
        Some(if big_endian { digits.fold(0, join) } else { digits.rev().fold(0, join) })
    };
    let damaged = |problem: String| ReadError::damaged(path, Place::Whole, problem);
    if number(2, 2) == Some(43) {
        return Err(damaged("cannot be decoded: BigTIFF; save it as a plain TIFF".to_owned()));
    }
    let directory = number(4, 4).unwrap_or(usize::MAX);
    for tag in 0..number(directory, 2).unwrap_or(0) {
        let at = directory + 2 + 12 * tag;
        let Some((kind, count)) = number(at + 2, 2).zip(number(at + 4, 4)) else { break };
        // Bytes, 16-bit and 32-bit numbers by their codes; all others have at most 64 bits.
        let size = match kind {
            1 | 2 | 6 | 7 => 1,
            3 | 8 => 2,
            4 | 9 | 11 | 13 => 4,
            _ => 8,
        };
        if count.saturating_mul(size) > bytes.len() {
            let problem = format!(
                "cannot be decoded: entry {tag} of the directory announces {count} values of \
                 {size} bytes, but the file has {} bytes",
                bytes.len()
            );
            return Err(damaged(problem));
        }
    }
    Ok(())
}

/// Bytes of a usual tile: 256 × 256 numbers of 64 bits. Theory. Doubled, a damaged header may take
/// 512 KiB more.
const TILE: usize = 256 * 256 * 8;

#[cfg(test)]
mod tests {
    use super::*;
    use tiff::encoder::colortype::{ColorType, Gray8, Gray16, Gray32Float, Gray64Float};
    use tiff::encoder::{Compression, TiffEncoder, TiffValue};

    fn image<C: ColorType>(values: &[C::Inner], compression: Compression) -> Vec<u8>
    where
        [C::Inner]: TiffValue,
    {
        let mut bytes = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut bytes).unwrap().with_compression(compression);
        encoder.write_image::<C>(values.len() as u32 / 2, 2, values).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn counts_and_floating_point_numbers_come_back() {
        let size = ImageSize { rows: 2, cols: 2 };
        let read = |bytes: &[u8]| decode(Path::new("a.tif"), bytes).unwrap();
        for compression in [Compression::Uncompressed, Compression::Lzw] {
            let counts = [0, 1, 500, 65535];
            let found = read(&image::<Gray16>(&counts, compression));
            assert_eq!(found, (size, TiffSamples::Counts(counts.to_vec())));
            let singles = [0.0, 1.5, 2.5, 1e9];
            let found = read(&image::<Gray32Float>(&singles, compression));
            assert_eq!(found, (size, TiffSamples::Singles(singles.to_vec())));
            let doubles = [0.0, 1.5, 2.5, 1e99];
            let found = read(&image::<Gray64Float>(&doubles, compression));
            assert_eq!(found, (size, TiffSamples::Doubles(doubles.to_vec())));
        }
    }

    #[test]
    fn tags_larger_than_the_file_are_refused_before_memory_is_taken() {
        let mut bytes = image::<Gray16>(&[1, 2, 3, 4], Compression::Uncompressed);
        let directory = u32::from_le_bytes(bytes[4..8].try_into().unwrap()) as usize;
        // The first entry becomes a text of 256 MiB.
        bytes[directory + 4..directory + 6].copy_from_slice(&2_u16.to_le_bytes());
        bytes[directory + 6..directory + 10].copy_from_slice(&(1_u32 << 28).to_le_bytes());
        let error = decode(Path::new("a.tif"), &bytes).unwrap_err().to_string();
        assert!(error.contains("a.tif: cannot be decoded: entry 0 of the directory"), "{error}");
    }

    #[test]
    fn other_images_and_announced_sizes_beyond_the_file_are_refused() {
        let error = |bytes: &[u8]| decode(Path::new("a.tif"), bytes).unwrap_err().to_string();
        let bytes = error(&image::<Gray8>(&[1, 2, 3, 4], Compression::Uncompressed));
        assert!(
            bytes.starts_with(
                "a.tif: the image is Gray(8); expected one channel of unsigned 16-bit"
            ),
            "{bytes}"
        );
        let mut huge = image::<Gray16>(&[7; 4], Compression::Uncompressed);
        // The entries of the width (256) and the height (257), with a value of 32 bits each.
        for tag in [256_u16, 257] {
            let entry = tag.to_le_bytes().into_iter().chain([4, 0, 1, 0, 0, 0]).collect::<Vec<_>>();
            let at = huge.windows(8).position(|w| w == entry).unwrap() + 8;
            huge[at..at + 4].copy_from_slice(&30_000_u32.to_le_bytes());
        }
        let huge = error(&huge);
        let wanted = "a.tif: the header announces 30000 rows × 30000 columns, but the file has";
        assert!(huge.starts_with(wanted), "{huge}");
        assert!(error(b"II*\0").starts_with("a.tif: cannot be decoded: "));
    }
}
