//! A grid of coloured pixels as a PNG inside an SVG file.

use super::ramp::Colour;

/// Rows and columns of colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    rows: usize,
    cols: usize,
    /// Red, green and blue of every pixel, row by row.
    rgb: Vec<u8>,
}

impl Raster {
    /// A raster by a function of row and column.
    pub fn new(rows: usize, cols: usize, colour: impl Fn(usize, usize) -> [u8; 3]) -> Self {
        let pixels = (0..rows).flat_map(|row| (0..cols).map(move |col| (row, col)));
        Self { rows, cols, rgb: pixels.flat_map(|(row, col)| colour(row, col)).collect() }
    }

    /// A colour between dark (0) and light (1) that is readable for the colour-blind, too.
    pub fn shade(share: f64) -> [u8; 3] {
        Colour::ramp(share).bytes()
    }

    /// Rows and columns.
    pub fn size(&self) -> [usize; 2] {
        [self.rows, self.cols]
    }

    /// The raster as the address of an image. `None` for a raster without pixels, which no PNG can
    /// hold.
    pub(super) fn data_address(&self) -> Option<String> {
        let mut bytes = Vec::new();
        let (width, height) = (u32::try_from(self.cols).ok()?, u32::try_from(self.rows).ok()?);
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.write_header().ok()?.write_image_data(&self.rgb).ok()?;
        Some(format!("data:image/png;base64,{}", base64(&bytes)))
    }
}

/// Bytes as text (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digit = |bits: u32, shift: u32| {
        let at = (bits >> shift & 63) as usize;
        char::from(DIGITS.get(at).copied().unwrap_or(b'='))
    };
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |k: usize| u32::from(chunk.get(k).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        text.extend([18, 12, 6, 0].iter().take(chunk.len() + 1).map(|shift| digit(bits, *shift)));
        text.extend(std::iter::repeat_n('=', 3 - chunk.len()));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_of_bytes_is_that_of_the_standard() {
        let pairs =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg==")];
        for (bytes, text) in pairs {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn an_empty_raster_has_no_address() {
        assert_eq!(Raster::new(0, 3, |_, _| [0; 3]).data_address(), None);
        let address = Raster::new(2, 3, |_, _| [9; 3]).data_address().unwrap();
        assert!(address.starts_with("data:image/png;base64,iVBORw0KGgo"), "{address}");
    }
}
