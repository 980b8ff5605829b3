//! 16-bit grey `.pgm` images (Netpbm): `P5` with binary counts, and `P2` with counts as text.
//!
//! ```text
//! P5  columns  rows  largest count     words between white space; # begins a comment
//! one byte of white space, then the counts of 2 bytes, the high byte first
//! ```

use crate::{Place, ReadError};
use std::path::Path;
use std::str::FromStr;
use transect_device::ImageSize;

/// The size and the row-major counts in a file's bytes. A note tells of bytes behind them, such as
/// those of a second image.
pub(crate) fn decode(
    path: &Path,
    bytes: &[u8],
    notes: &mut Vec<String>,
) -> Result<(ImageSize, Vec<u16>), ReadError> {
    let damaged = |problem: String| ReadError::damaged(path, Place::Whole, problem);
    let mut rest = bytes;
    let as_text = match word(&mut rest) {
        Some(b"P2") => true,
        Some(b"P5") => false,
        _ => return Err(damaged("not a .pgm file; expected P5 or P2 at its start".to_owned())),
    };
    let mut number = |name: &str| {
        let number: Option<usize> = word(&mut rest).and_then(number_of);
        number.ok_or_else(|| damaged(format!("the header has no {name}; expected a whole number")))
    };
    let (cols, rows) = (number("number of columns")?, number("number of rows")?);
    let size = ImageSize { rows, cols };
    match number("largest count")? {
        256..=65535 => {}
        largest => {
            let problem = format!(
                "the largest count is {largest}; ranges are read from 16-bit grey, which has 256 \
                 to 65535"
            );
            return Err(ReadError::unsupported(path, Place::Whole, problem));
        }
    }
    // A binary count takes two bytes; one of text takes a digit and a space before it.
    let follow = rest.len().saturating_sub(usize::from(!as_text));
    let pixels = rows.checked_mul(cols).filter(|n| *n <= follow / 2);
    let pixels = pixels.ok_or_else(|| {
        damaged(format!("truncated: the header announces {size}, {follow} bytes follow"))
    })?;
    let counts: Option<Vec<u16>> = if as_text {
        (0..pixels).map(|_| word(&mut rest).and_then(number_of)).collect()
    } else {
        let (counts, behind) = rest.get(1..).unwrap_or_default().split_at(2 * pixels);
        rest = behind;
        Some(counts.as_chunks().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect())
    };
    let counts =
        counts.ok_or_else(|| damaged(format!("fewer than {pixels} counts of 0 to 65535")))?;
    let left = if as_text { rest.trim_ascii() } else { rest }.len();
    if left > 0 {
        notes.push(format!("{left} bytes after the last count ignored"));
    }
    Ok((size, counts))
}

/// The whole number that a word is.
fn number_of<T: FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// The next word of a header, without comments. `rest` begins at the byte after it then.
fn word<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    *rest = rest.trim_ascii_start();
    while rest.starts_with(b"#") {
        let end = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        *rest = rest.get(end..).unwrap_or_default().trim_ascii_start();
    }
    let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
    let (word, after) = rest.split_at_checked(end)?;
    *rest = after;
    Some(word).filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(bytes: &[u8]) -> Result<(ImageSize, Vec<u16>), String> {
        decode(Path::new("a.pgm"), bytes, &mut Vec::new()).map_err(|e| e.to_string())
    }

    #[test]
    fn a_note_tells_of_bytes_behind_the_image() {
        let notes = |bytes| {
            let mut notes = Vec::new();
            decode(Path::new("a.pgm"), bytes, &mut notes).unwrap();
            notes
        };
        assert_eq!(notes(b"P5 1 1 65535\n\0\x01P5"), ["2 bytes after the last count ignored"]);
        assert_eq!(notes(b"P2 2 1 65535\n1 2 3 4\n"), ["3 bytes after the last count ignored"]);
        assert_eq!(notes(b"P2 2 1 65535\n1 2\n\n").len(), 0);
    }

    #[test]
    fn binary_counts_and_counts_as_text_are_the_same() {
        let size = ImageSize { rows: 2, cols: 3 };
        let wanted = Ok((size, vec![0, 1, 256, 65535, 10, 13]));
        let binary = b"P5\n# depth\n3 2\n65535\n\0\0\0\x01\x01\0\xff\xff\0\x0a\0\x0d";
        assert_eq!(counts(binary), wanted);
        assert_eq!(counts(b"P2 3 2 65535\n0 1 256\n65535 10 13"), wanted);
    }

    #[test]
    fn announced_sizes_beyond_the_file_are_refused() {
        for (bytes, problem) in [
            (&b"P5 3 2 65535\n12345"[..], "truncated: the header announces 2 rows × 3 columns"),
            (b"P5 99999999999 99999999999 65535\n", "truncated: the header announces"),
            (b"P2 9999 9999 65535\n1 2", "truncated: the header announces"),
            (b"P2 2 1 65535\n1 x 3", "fewer than 2 counts"),
            (b"P5 2 2 70000\n", "the largest count is 70000"),
            (b"P5 2 2 255\n1234", "the largest count is 255; ranges are read from 16-bit grey"),
            (b"P6 2 2 255\n", "not a .pgm file"),
            (b"P5 2 x", "the header has no number of rows"),
        ] {
            let error = counts(bytes).unwrap_err();
            assert!(error.starts_with(&format!("a.pgm: {problem}")), "{error}");
        }
    }
}
