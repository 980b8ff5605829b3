//! Decompression of LZF, the compression of PCD files.
//!
//! Reference: Marc Lehmann, *LibLZF*. A control byte below 32 announces that many literal bytes and
//! one more. Every other control byte repeats earlier bytes. Three bits of it are the length less 2
//! (7: the next byte is added). Five bits and the next byte are the distance less 1.

/// Most bytes that one compressed byte can become: three bytes repeat at most 264.
const LARGEST_RATIO: usize = 88;

const TRUNCATED: &str = "truncated: the compressed data end inside a piece";

/// The bytes behind LZF data, which must be `length` in number.
pub(super) fn decompress(data: &[u8], length: usize) -> Result<Vec<u8>, String> {
    if length > data.len().saturating_mul(LARGEST_RATIO) {
        let found = data.len();
        return Err(format!("{found} compressed bytes cannot hold the announced {length} bytes"));
    }
    let mut out = Vec::with_capacity(length);
    let mut rest = data;
    while let Some((&control, after)) = rest.split_first() {
        let control = usize::from(control);
        if control < 32 {
            let (literal, after) = after.split_at_checked(control + 1).ok_or(TRUNCATED)?;
            out.extend_from_slice(literal);
            rest = after;
        } else {
            let mut bytes = after.iter();
            let mut byte = || bytes.next().map(|b| usize::from(*b)).ok_or(TRUNCATED);
            let more = if control >> 5 == 7 { byte()? } else { 0 };
            let distance = ((control & 31) << 8) + byte()? + 1;
            repeat(&mut out, distance, (control >> 5) + more + 2)?;
            rest = bytes.as_slice();
        }
        if out.len() > length {
            return Err(format!("the data hold more than the announced {length} bytes"));
        }
    }
    let found = out.len();
    let problem = || format!("the data hold {found} bytes; the header announces {length}");
    (found == length).then_some(out).ok_or_else(problem)
}

/// Appends `count` bytes from `distance` bytes before the end; they may overlap.
fn repeat(out: &mut Vec<u8>, distance: usize, count: usize) -> Result<(), String> {
    let start = out.len().checked_sub(distance);
    let start = start.ok_or("the compressed data repeat bytes before their start")?;
    for at in start..start + count {
        out.extend(out.get(at).copied());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::decompress;

    #[test]
    fn literals_and_overlapping_repeats() {
        // "ab", then 4 bytes from 2 back, then 264 bytes from 1 back.
        let data = [1, b'a', b'b', 0x40, 1, 0xe0, 255, 0];
        let mut wanted = b"ababab".to_vec();
        wanted.extend([b'b'; 264]);
        assert_eq!(decompress(&data, 270), Ok(wanted));
        assert!(decompress(&data, 269).unwrap_err().contains("more than the announced 269"));
        assert!(decompress(&data[..5], 7).unwrap_err().contains("hold 6 bytes; the header"));
        assert!(decompress(&data[..6], 30).unwrap_err().contains("truncated"));
        assert!(decompress(&[0x40, 1], 4).unwrap_err().contains("before their start"));
        assert!(decompress(&[], usize::MAX).unwrap_err().contains("cannot hold"));
    }
}
