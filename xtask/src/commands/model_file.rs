//! Opening model files and model stores, for the commands that ask them something.

use crate::failure::Failure;
use std::io::Read;
use std::path::Path;
use transect::{Grower, Setup, Unwatched};
use transect_geometry::{LengthUnit, PlaneFamily, PlaneIndex};
use transect_model::store::{
    Damage, Snapshot, Store, StoreError, StoreHeader, StoreProblem, ViewId,
};
use transect_model::{CodecError, FileError, Model, ModelVolume, SCHEMA_VERSION, Section};

/// Whether a file begins like a model or a store.
pub fn looks_like_one(path: &Path) -> bool {
    let mut magic = [0; 8];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut magic));
    read.is_ok() && magic == *b"TRANSECT"
}

/// Opens a store, and says what to do if the file is something else.
pub fn open_store(path: &Path) -> Result<Store, Failure> {
    Store::open(path).map_err(|error| match error.problem {
        StoreProblem::Damaged(Damage::WrongVersion { found: SCHEMA_VERSION }) => {
            let reason = "a plain model file, which no view can be added to or taken out of; \
                          a store is made by reconstruct --store FILE";
            Failure::with_file(path, reason)
        }
        _ => error.into(),
    })
}

/// Opens a store whose planes have all been fused: what an interrupted run left is finished first.
pub fn open_finished(path: &Path) -> Result<Store, Failure> {
    let store = open_store(path)?;
    let waiting = store.read()?.pending()?.len();
    if waiting > 0 {
        let setup = setup_of(path, store.read()?.header())?;
        eprintln!("note: fusing {waiting} planes that an interrupted run left");
        Grower::new(&store, &setup)?.fuse_pending(&Unwatched)?;
    }
    Ok(store)
}

/// The settings that a store was made with.
pub fn setup_of(path: &Path, header: &StoreHeader) -> Result<Setup, Failure> {
    Setup::of_store(header).map_err(|error| Failure::with_file(path, error))
}

/// The view of a store that goes by a name; a name that nobody has is told with those most like it.
pub fn view_named(store: &Store, path: &Path, name: &str) -> Result<ViewId, Failure> {
    let mut names: Vec<String> = store.views()?.into_iter().map(|view| view.entry.id.0).collect();
    if names.iter().any(|there| there == name) {
        return Ok(name.into());
    }
    names.sort_by_key(|there| edits(there, name));
    names.truncate(5);
    let near = if names.is_empty() { "it has no views".to_owned() } else { names.join(", ") };
    Err(Failure::with_file(path, format!("no view {name:?}; the names most like it: {near}")))
}

/// The least number of letters to insert, delete or change that makes one text the other (Levenshtein).
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.chars().enumerate() {
        let mut diagonal = i;
        row[0] = i + 1;
        for (j, other) in b.iter().enumerate() {
            let changed = diagonal + usize::from(letter != *other);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

/// A model, whichever kind of file it is in.
pub enum ModelFile {
    /// In a plain file, read whole.
    Plain(Box<Model>),
    /// In a store, read plane by plane. The snapshot is dropped before the store.
    Store(Box<Snapshot>, Store),
}

impl ModelFile {
    /// Opens a model file, or a store whose planes have all been fused.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        match Model::load(path) {
            Ok(model) => Ok(Self::Plain(Box::new(model))),
            Err(FileError::Load { source: CodecError::WrongVersion { .. }, .. }) => {
                let store = open_finished(path)?;
                Ok(Self::Store(Box::new(store.read()?), store))
            }
            Err(error) => Err(error.into()),
        }
    }

    /// The unit of every length.
    pub fn unit(&self) -> LengthUnit {
        match self {
            Self::Plain(model) => model.unit(),
            Self::Store(snapshot, _) => snapshot.header().unit,
        }
    }

    /// Where the planes are.
    pub fn planes(&self) -> &PlaneFamily {
        match self {
            Self::Plain(model) => model.planes(),
            Self::Store(snapshot, _) => &snapshot.header().planes,
        }
    }

    /// Hands every plane with curves to a function, in order of station, one in memory at a time.
    pub fn for_each_section(
        &self,
        mut take: impl FnMut(PlaneIndex, &Section),
    ) -> Result<(), StoreError> {
        match self {
            Self::Plain(model) => {
                model.sections().for_each(|(plane, section)| take(plane, section))
            }
            Self::Store(snapshot, _) => {
                for entry in snapshot.planes()? {
                    let (plane, section) = entry?;
                    take(plane, &section);
                }
            }
        }
        Ok(())
    }

    /// The volume of the solid.
    pub fn volume(&self) -> Result<ModelVolume, StoreError> {
        match self {
            Self::Plain(model) => Ok(model.volume()),
            Self::Store(snapshot, _) => snapshot.volume(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::edits;

    #[test]
    fn edits_are_counted() {
        for (a, b, count) in [("", "", 0), ("east", "east", 0), ("eats", "east", 2), ("", "abc", 3)]
        {
            assert_eq!((edits(a, b), edits(b, a)), (count, count), "{a} {b}");
        }
        assert_eq!(edits("range_000.npy", "range_01.npy"), 2);
    }
}
