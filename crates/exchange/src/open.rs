//! Opening a scan: the one list of scan formats.
//!
//! To add a format, write a module with a function like `manifest::open` and add a line to
//! [`FORMATS`]. See "Add a scan format" in `docs/add-a-sensor.md`.

use crate::{ReadError, Scan, depth_folder, manifest, stanford};
use std::path::Path;
use transect_geometry::LengthUnit;

/// A kind of scan on disk.
struct Format {
    /// The words for it in the message that lists the accepted formats.
    name: &'static str,
    /// Whether a path is of this kind. The path exists.
    recognise: fn(&Path) -> bool,
    /// Reads everything but the images. The unit is the caller's, if the caller named one.
    open: fn(&Path, Option<LengthUnit>) -> Result<Scan, ReadError>,
}

/// The formats in the order in which they are tried.
const FORMATS: [Format; 4] = [
    Format {
        name: "a folder with scan.json",
        recognise: manifest::is_in,
        open: |folder, unit| manifest::open(&folder.join(manifest::FILE_NAME), unit),
    },
    Format {
        name: "a scan manifest (*.json)",
        recognise: |path| is_file_with(path, "json"),
        open: manifest::open,
    },
    Format {
        name: "a Stanford configuration (*.conf)",
        recognise: |path| is_file_with(path, "conf"),
        open: stanford::open,
    },
    Format {
        name: "a folder of *.depth.png and *.pose.txt with camera-intrinsics.txt",
        recognise: depth_folder::is_one,
        open: depth_folder::open,
    },
];

fn is_file_with(path: &Path, extension: &str) -> bool {
    !path.is_dir() && path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

impl Scan {
    /// Opens a scan whose files state their unit, or have one by convention.
    ///
    /// # Errors
    /// See [`Scan::open_with_unit`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        Self::open_with_unit(path, None)
    }

    /// Opens a scan: a folder with `scan.json`, a manifest (`*.json`), a Stanford configuration
    /// (`*.conf`), or a folder of depth images with poses and `camera-intrinsics.txt`.
    ///
    /// `unit` is used if the files do not state a unit. Lengths are never converted.
    ///
    /// # Errors
    /// [`ReadError`] if the path is none of these, a file is damaged, the unit is missing, or the
    /// files state another unit than `unit`.
    pub fn open_with_unit(path: &Path, unit: Option<LengthUnit>) -> Result<Self, ReadError> {
        std::fs::metadata(path).map_err(|e| ReadError::io(path, e))?;
        match FORMATS.iter().find(|format| (format.recognise)(path)) {
            Some(format) => (format.open)(path, unit),
            None => {
                let accepted = FORMATS.map(|format| format.name).join("; ");
                Err(ReadError::NotAScan { path: path.to_owned(), accepted })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_scan_is_told_what_would_be() {
        let folder = tempfile::tempdir().unwrap();
        let error = Scan::open(folder.path()).unwrap_err().to_string();
        assert!(error.contains("accepted are: a folder with scan.json; "), "{error}");
        let missing = Scan::open(&folder.path().join("nowhere")).unwrap_err();
        assert!(matches!(missing, ReadError::Io { .. }), "{missing}");
        let text = folder.path().join("notes.txt");
        std::fs::write(&text, "no scan").unwrap();
        assert!(matches!(Scan::open(&text), Err(ReadError::NotAScan { .. })));
    }
}
