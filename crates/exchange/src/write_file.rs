//! Files that are replaced whole or not at all.

use crate::WriteError;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a file under a temporary name in its folder and renames it when it is complete.
///
/// A program that reads the file meanwhile sees the old content or the new one, never a part. A
/// failure leaves the old content.
///
/// # Errors
/// [`WriteError`] if the folder refuses, or `content` returns an error.
///
/// ```
/// use std::io::Write;
/// let folder = tempfile::tempdir().unwrap();
/// let path = folder.path().join("station.txt");
/// transect_exchange::write_file(&path, |out| write!(out, "0.25 m")).unwrap();
/// assert_eq!(std::fs::read_to_string(&path).unwrap(), "0.25 m");
/// ```
pub fn write_file(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), WriteError> {
    let temporary = temporary_name(path);
    let written = write_and_rename(&temporary, path, content);
    if written.is_err() {
        // The first error is reported; the temporary file may not exist.
        let _ = std::fs::remove_file(&temporary);
    }
    written.map_err(|source| WriteError { path: path.to_owned(), source })
}

fn write_and_rename(
    temporary: &Path,
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, File::create(temporary)?);
    content(&mut out)?;
    let file = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    // Without it, a crash of the machine could keep the rename and lose the content.
    file.sync_all()?;
    std::fs::rename(temporary, path)
}

/// A hidden name with the process number, so that two runs do not write into one file.
fn temporary_name(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.part", std::process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_keeps_the_old_content_and_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.dxf");
        write_file(&path, |out| out.write_all(b"old")).unwrap();
        let failed = write_file(&path, |out| {
            out.write_all(b"half of the new")?;
            Err(io::Error::other("disk full"))
        });
        let error = failed.unwrap_err();
        assert!(error.to_string().ends_with("model.dxf: cannot be written"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
