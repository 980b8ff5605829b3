//! A model as one whole file, for models that fit into memory.
//!
//! A model is saved and loaded whole. It is written to a new file beside the old one and then
//! renamed, so a crash leaves either the old model or the new one.

use crate::Model;
use crate::codec::{self, CodecError};
use crate::regular_file::open_regular;
use std::fs::{self, File};
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Why a model could not be saved or loaded, with the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// The file could not be read as a model.
    #[error("cannot load the model {}", path.display())]
    Load {
        /// The file.
        path: PathBuf,
        /// The error.
        #[source]
        source: CodecError,
    },
    /// The file could not be written; a model that was there before is unchanged.
    #[error("cannot save the model {}", path.display())]
    Save {
        /// The file.
        path: PathBuf,
        /// The error of writing.
        #[source]
        source: CodecError,
    },
}

impl Model {
    /// Writes the model as the bytes of a model file; the same model gives the same bytes.
    ///
    /// # Errors
    /// [`CodecError::Invariant`] if [`Model::check`] fails, [`CodecError::Io`] if writing does.
    pub fn to_writer(&self, out: impl Write) -> Result<(), CodecError> {
        codec::write(self, out)
    }

    /// Reads the bytes of a model file, to their end.
    ///
    /// # Errors
    /// [`CodecError`] if they are not a whole and sound model of this version.
    pub fn from_reader(input: impl Read) -> Result<Self, CodecError> {
        codec::read(input)
    }

    /// Saves the model into a file, replacing it whole.
    ///
    /// # Errors
    /// [`FileError::Save`], naming the file.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), FileError> {
        let path = path.as_ref();
        let beside = path_beside(path);
        let saved = write_and_rename(self, &beside, path);
        if saved.is_err() {
            // If this fails too, no data is lost: the model's own file was not changed.
            let _ = fs::remove_file(&beside);
        }
        saved.map_err(|source| FileError::Save { path: path.to_owned(), source })
    }

    /// Loads the model of a file.
    ///
    /// # Errors
    /// [`FileError::Load`], naming the file.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, FileError> {
        let path = path.as_ref();
        let opened = open_regular(path).map_err(CodecError::from);
        let loaded = opened.and_then(|file| codec::read(BufReader::new(file)));
        loaded.map_err(|source| FileError::Load { path: path.to_owned(), source })
    }
}

fn write_and_rename(model: &Model, beside: &Path, path: &Path) -> Result<(), CodecError> {
    let mut file = File::create_new(beside)?;
    codec::write(model, BufWriter::new(&mut file))?;
    // Without this, a power cut after the rename could leave an empty file under the new name.
    file.sync_all()?;
    drop(file);
    Ok(fs::rename(beside, path)?)
}

/// A name in the same directory, since renaming is atomic only within one file system.
pub(crate) fn path_beside(path: &Path) -> PathBuf {
    static SAVES: AtomicU64 = AtomicU64::new(0);
    let save = SAVES.fetch_add(1, Ordering::Relaxed);
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}-{save}.part", std::process::id()));
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{empty, small, view};
    use std::error::Error;

    fn names(directory: &Path) -> Vec<String> {
        let entries = fs::read_dir(directory).unwrap();
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_saved_model_loads_as_it_was_and_replaces_the_old_one() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("room.transect");
        for model in [small(), empty()] {
            model.save(&path).unwrap();
            assert_eq!(Model::load(&path).unwrap(), model);
            assert_eq!(names(directory.path()), ["room.transect"]);
        }
    }

    #[test]
    fn an_error_names_the_file_and_its_cause() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("notes.txt");
        fs::write(&path, "not a model").unwrap();
        let error = Model::load(&path).unwrap_err();
        assert!(error.to_string().contains("notes.txt"), "{error}");
        assert_eq!(error.source().unwrap().to_string(), "not a Transect model file");
        let missing = Model::load(directory.path().join("missing")).unwrap_err();
        assert!(missing.to_string().contains("missing"), "{missing}");
    }

    #[test]
    fn a_failed_save_leaves_the_old_model_and_no_litter() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("room.transect");
        small().save(&path).unwrap();
        let mut unsound = small();
        unsound.add_view(crate::ViewRecord { sigma: Some(f64::NAN), ..view("bad") });
        assert!(unsound.save(&path).is_err());
        assert_eq!(Model::load(&path).unwrap(), small());
        assert_eq!(names(directory.path()), ["room.transect"]);
        assert!(small().save(directory.path().join("nowhere/room.transect")).is_err());
    }
}
