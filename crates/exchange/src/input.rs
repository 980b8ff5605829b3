//! The bytes and the text of files.

use crate::{Place, ReadError};
use std::fs::File;
use std::io::Read;
use std::path::Path;
use transect_device::{ImageSize, MAX_PIXELS};
use transect_model::open_regular;

/// The mark with which some programs begin text files.
const BYTE_ORDER_MARK: &str = "\u{feff}";

/// Opens a regular file.
pub(crate) fn open(path: &Path) -> Result<File, ReadError> {
    open_regular(path).map_err(|e| ReadError::io(path, e))
}

/// A whole file in memory.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, ReadError> {
    let mut file = open(path)?;
    let size = file.metadata().map_or(0, |m| m.len());
    let mut bytes = Vec::with_capacity(usize::try_from(size).unwrap_or(0));
    file.read_to_end(&mut bytes).map_err(|e| ReadError::io(path, e))?;
    Ok(bytes)
}

/// A whole text file in memory, without its byte order mark.
///
/// # Errors
/// [`ReadError`] if the path is no regular file, or its bytes are not UTF-8.
pub fn read_text(path: &Path) -> Result<String, ReadError> {
    let text = String::from_utf8(read_bytes(path)?);
    let mut text = text.map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        let problem = format!("byte {at} is not UTF-8; save the file as UTF-8 text");
        ReadError::damaged(path, Place::Whole, problem)
    })?;
    if text.starts_with(BYTE_ORDER_MARK) {
        text.drain(..BYTE_ORDER_MARK.len());
    }
    Ok(text)
}

/// The bytes of a text file without its byte order mark.
pub(crate) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(BYTE_ORDER_MARK.as_bytes()).unwrap_or(bytes)
}

/// Images up to this many bytes may be compressed in any ratio: 16-bit images of 4096 × 2048
/// pixels. Chosen by hand. Doubled, a damaged header may take 32 MiB.
pub(crate) const SMALL_IMAGE: usize = 16 << 20;

/// Largest ratio of an image's bytes to those of its file, beyond [`SMALL_IMAGE`]. Measured on the
/// depth images of 7-Scenes: 2 to 4. Doubled, a crafted file takes twice the memory.
const LARGEST_COMPRESSION: usize = 100;

/// The bytes that a compressed image needs, if a file of that many bytes can hold them. `needed` is
/// `None` if the number is too large for the machine.
pub(crate) fn check_announced(
    path: &Path,
    size: ImageSize,
    needed: Option<usize>,
    file_bytes: usize,
) -> Result<usize, ReadError> {
    let largest = file_bytes.saturating_mul(LARGEST_COMPRESSION);
    let most = largest.clamp(SMALL_IMAGE, 2 * MAX_PIXELS);
    needed.filter(|&n| n <= most).ok_or_else(|| {
        let problem = format!(
            "the header announces {size}, but the file has {file_bytes} bytes; a compressed image \
             of that file has at most {most} bytes. If it is sound, save it as .npy"
        );
        ReadError::damaged(path, Place::Whole, problem)
    })
}

/// The first bytes of a file, enough for the header of a cloud.
pub(crate) fn read_head(path: &Path) -> Result<Vec<u8>, ReadError> {
    /// Chosen by hand: headers have some hundred bytes. Doubled, opening a folder reads more.
    const LONGEST: u64 = 1 << 16;
    let mut bytes = Vec::new();
    open(path)?.take(LONGEST).read_to_end(&mut bytes).map_err(|e| ReadError::io(path, e))?;
    Ok(bytes)
}
