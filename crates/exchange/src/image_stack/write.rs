//! Writing stacks, for simulations and conversions.

use std::io::{self, Write};
use transect_device::ImageSize;

/// A camera's counts, row by row, image by image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Counts<'a> {
    /// From 0 to 255.
    Eight(&'a [u8]),
    /// From 0 to 65 535.
    Sixteen(&'a [u16]),
}

impl Counts<'_> {
    fn check(&self, steps: usize, size: ImageSize) -> io::Result<()> {
        let found = match self {
            Self::Eight(counts) => counts.len(),
            Self::Sixteen(counts) => counts.len(),
        };
        let wanted = size.rows.checked_mul(size.cols).and_then(|n| n.checked_mul(steps));
        if wanted == Some(found) {
            return Ok(());
        }
        Err(io::Error::other(format!("{found} counts do not fill {steps} images of {size}")))
    }
}

/// Writes a stack of intensity images as `.npy`, steps × rows × columns of `u1` or `u2`.
///
/// # Errors
/// An error of `out`, or a number of counts that is not steps × rows × columns.
pub fn write_npy_stack(
    steps: usize,
    size: ImageSize,
    counts: Counts<'_>,
    mut out: &mut dyn Write,
) -> io::Result<()> {
    counts.check(steps, size)?;
    let shape = [steps, size.rows, size.cols];
    match counts {
        Counts::Eight(counts) => {
            crate::npy::write_header(&mut out, "|u1", &shape)?;
            out.write_all(counts)
        }
        Counts::Sixteen(counts) => {
            crate::npy::write_header(&mut out, "<u2", &shape)?;
            let bytes: Vec<u8> = counts.iter().flat_map(|c| c.to_le_bytes()).collect();
            out.write_all(&bytes)
        }
    }
}

/// Writes one intensity image as a grey `.png` of 8 or 16 bits.
///
/// # Errors
/// An error of `out`, or a number of counts that is not rows × columns.
pub fn write_png_image(size: ImageSize, counts: Counts<'_>, out: &mut dyn Write) -> io::Result<()> {
    counts.check(1, size)?;
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let mut encoder = png::Encoder::new(out, side(size.cols)?, side(size.rows)?);
    encoder.set_color(png::ColorType::Grayscale);
    let wide: Vec<u8>;
    let (depth, bytes) = match counts {
        Counts::Eight(counts) => (png::BitDepth::Eight, counts),
        Counts::Sixteen(counts) => {
            wide = counts.iter().flat_map(|c| c.to_be_bytes()).collect();
            (png::BitDepth::Sixteen, wide.as_slice())
        }
    };
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    writer.write_image_data(bytes).map_err(io::Error::other)?;
    writer.finish().map_err(io::Error::other)
}
