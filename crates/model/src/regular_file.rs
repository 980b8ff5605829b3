//! Opening files for reading, in one place for the whole workspace.

use std::fs::File;
use std::io;
use std::path::Path;

/// Opens a regular file for reading.
///
/// Folders, pipes, sockets and devices are refused before they are opened: opening a pipe waits
/// for its writer, and `/dev/zero` has no end. Links to regular files are followed.
///
/// # Errors
/// The error of the system, or [`io::ErrorKind::InvalidInput`] with the kind of file that was
/// found.
///
/// ```
/// let folder = tempfile::tempdir().unwrap();
/// let error = transect_model::open_regular(folder.path()).unwrap_err();
/// assert!(error.to_string().starts_with("a folder, where a regular file was expected"));
/// ```
pub fn open_regular(path: &Path) -> io::Result<File> {
    require_regular(path)?;
    File::open(path)
}

/// Refuses a path that does not lead to a regular file.
pub(crate) fn require_regular(path: &Path) -> io::Result<()> {
    let kind = std::fs::metadata(path)?.file_type();
    if kind.is_file() {
        return Ok(());
    }
    let found = if kind.is_dir() { "a folder" } else { "a pipe, socket or device" };
    let advice = "name a file, or copy the data into one";
    let problem = format!("{found}, where a regular file was expected; {advice}");
    Err(io::Error::new(io::ErrorKind::InvalidInput, problem))
}
