//! Grey `.png` images of 8 or 16 bits.

use crate::input::{SMALL_IMAGE, check_announced};
use crate::{Place, ReadError};
use std::io::Cursor;
use std::path::Path;
use transect_device::ImageSize;

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
    // The decoder's own buffers: lines, and chunks that are not part of the image.
    let limits = png::Limits { bytes: SMALL_IMAGE };
    let decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    let mut reader = decoder.read_info().map_err(undecodable)?;
    let (cols, rows) = reader.info().size();
    let size = ImageSize { rows: rows as usize, cols: cols as usize };
    let wide = match reader.output_color_type() {
        (png::ColorType::Grayscale, png::BitDepth::Eight) => false,
        (png::ColorType::Grayscale, png::BitDepth::Sixteen) => true,
        (colour, depth) => {
            let problem = format!(
                "the image is {colour:?} of {} bits and must be grey; a picture of ranges in \
                 colours holds no ranges: export them as 16-bit grey",
                depth as u8
            );
            return Err(ReadError::unsupported(path, Place::Whole, problem));
        }
    };
    let needed = check_announced(path, size, reader.output_buffer_size(), bytes.len())?;
    let mut bytes = vec![0; needed];
    reader.next_frame(&mut bytes).map_err(undecodable)?;
    let samples = if wide {
        Samples::Sixteen(bytes.as_chunks().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect())
    } else {
        Samples::Eight(bytes)
    };
    Ok(GreyImage { size, samples })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sound file of 30 000² black pixels has some 1.7 MB. Its header alone must refuse it.
    #[test]
    fn announced_sizes_beyond_the_file_are_refused() {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 30_000, 30_000);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        drop(encoder.write_header().unwrap());
        // The signature and the chunk IHDR, and the start of the image.
        bytes.truncate(33);
        bytes.extend([0, 0x1a, 0, 0].iter().chain(b"IDAT"));
        bytes.resize(1_750_000, 0);
        let error = decode(Path::new("a.png"), &bytes).err().unwrap().to_string();
        let wanted = "a.png: the header announces 30000 rows × 30000 columns, but the file has";
        assert!(error.starts_with(wanted), "{error}");
    }
}
