//! Models on disk, in either kind of file.

use crate::WorkflowError;
use crate::results::find_model;
use crate::store_file::{finish, read_store};
use std::path::Path;
use transect_geometry::{LengthUnit, PlaneFamily, PlaneIndex};
use transect_model::store::{Snapshot, Store, StoreError};
use transect_model::{CodecError, FileError, Model, ModelVolume, Section};

/// A model on disk.
#[derive(Debug)]
pub enum ModelFile {
    /// In a plain file, read whole.
    Plain(Box<Model>),
    /// In a store, read plane by plane.
    Store(OpenStore),
}

/// A store that is open for reading. The snapshot is dropped before the store.
#[derive(Debug)]
pub struct OpenStore {
    /// Its contents.
    pub snapshot: Box<Snapshot>,
    /// The store itself.
    pub store: Store,
    /// Planes that an interrupted run had left and opening fused, in memory.
    pub planes_finished: usize,
}

impl ModelFile {
    /// Opens a model file, a store, or the model in a result folder, which are not written. The
    /// planes of a store that an interrupted run left are fused in memory.
    ///
    /// # Errors
    /// [`WorkflowError`] if the file is neither, is damaged, or is in use.
    pub fn open(path: &Path) -> Result<Self, WorkflowError> {
        Self::load(path, finish)
    }

    /// The same, but a store's planes are left as they are.
    ///
    /// # Errors
    /// [`WorkflowError`] if the file is neither, is damaged, or is in use.
    pub fn open_unfinished(path: &Path) -> Result<Self, WorkflowError> {
        Self::load(path, |_, _| Ok(0))
    }

    fn load(
        path: &Path,
        finish: impl FnOnce(&Path, &Store) -> Result<usize, WorkflowError>,
    ) -> Result<Self, WorkflowError> {
        let path = &find_model(path)?;
        match Model::load(path) {
            Ok(model) => Ok(Self::Plain(Box::new(model))),
            Err(FileError::Load { source: CodecError::WrongVersion { .. }, .. }) => {
                let store = read_store(path)?;
                let planes_finished = finish(path, &store)?;
                let snapshot = Box::new(store.read()?);
                Ok(Self::Store(OpenStore { snapshot, store, planes_finished }))
            }
            Err(error) => Err(error.into()),
        }
    }

    /// The unit of every length.
    pub fn unit(&self) -> LengthUnit {
        match self {
            Self::Plain(model) => model.unit(),
            Self::Store(store) => store.snapshot.header().unit,
        }
    }

    /// Where the planes are.
    pub fn planes(&self) -> &PlaneFamily {
        match self {
            Self::Plain(model) => model.planes(),
            Self::Store(store) => &store.snapshot.header().planes,
        }
    }

    /// Planes that an interrupted run had left and opening fused, in memory.
    pub fn planes_finished(&self) -> usize {
        match self {
            Self::Plain(_) => 0,
            Self::Store(store) => store.planes_finished,
        }
    }

    /// The whole model in memory.
    ///
    /// # Errors
    /// [`StoreError`] if a store cannot be read.
    pub fn into_model(self) -> Result<Model, StoreError> {
        match self {
            Self::Plain(model) => Ok(*model),
            Self::Store(store) => store.snapshot.model(),
        }
    }

    /// Hands every plane with curves to a function, in order of station, one in memory at a time.
    ///
    /// # Errors
    /// [`StoreError`] if a store cannot be read.
    pub fn for_each_section(
        &self,
        mut take: impl FnMut(PlaneIndex, &Section),
    ) -> Result<(), StoreError> {
        match self {
            Self::Plain(model) => {
                model.sections().for_each(|(plane, section)| take(plane, section))
            }
            Self::Store(store) => {
                for entry in store.snapshot.planes()? {
                    let (plane, section) = entry?;
                    take(plane, &section);
                }
            }
        }
        Ok(())
    }

    /// The volume of the solid.
    ///
    /// # Errors
    /// [`StoreError`] if a store cannot be read.
    pub fn volume(&self) -> Result<ModelVolume, StoreError> {
        match self {
            Self::Plain(model) => Ok(model.volume()),
            Self::Store(store) => store.snapshot.volume(),
        }
    }
}
