//! The model database: one crash-safe file of views, partial models and fused planes
//! (dissertation, section 2.5.2).
//!
//! Problem: weeks of scanning must survive crashes and full disks, may be larger than memory, and a
//! wrong view must be removable.
//!
//! Idea: the file keeps the partial curves of every view, plane by plane, beside the fused planes.
//! The fused curves of a plane are a pure function ([`Fuse`]) of the partial curves on it, in order
//! of view ids. After a view is removed or replaced, its planes are fused again. The result is that
//! of a store which never had it.
//!
//! 1. Each view is added or removed in one transaction; views are replaced together in one. After a
//!    crash at any moment the file holds a whole number of views, and of replaced ones all or none.
//! 2. Only the planes of a view are read and written, one batch in memory at a time. Where many
//!    views are added at once, fusing can wait for the last one ([`ViewTransaction::defer_planes`],
//!    [`Store::fuse_pending`]). Until then the fused curves cannot be read.
//! 3. A [`Snapshot`] has the views that were complete when it was taken, also while the next one is
//!    written.
//! 4. Below the database (redb) every block has a checksum (`blocks`), so a damaged file gives an
//!    error, not a wrong answer or a panic.
//! 5. [`Store::export`] writes the contents as lines of JSON, which can still be read when this
//!    format is obsolete.
//!
//! One process at a time can change the file ([`Store::open`]), or any number of processes can read
//! it ([`Store::open_read_only`]). Others get [`StoreProblem::InUse`] or
//! [`StoreProblem::BeingRead`].
//!
//! Departure from the dissertation: there one merged model is kept, without the partial ones.
//!
//! Cost of a view: the partial curves of all views on its planes are read, and the changes are
//! written twice. For a small model that is computed and read once, use a plain file:
//! [`Model::save`](crate::Model::save).
//!
//! ```
//! use transect_geometry::{Curve, Isometry3, LengthUnit, Node, PlaneFamily, PlaneIndex, Point2, StraightGuide, Vector3};
//! use transect_model::store::{Store, StoreHeader, ViewDescription, ViewId};
//!
//! let folder = tempfile::tempdir()?;
//! let planes = PlaneFamily::new(StraightGuide::along(Vector3::z())?, 0.0, 0.5)?;
//! let (options, tool) = (String::new(), "example".to_owned());
//! let header = StoreHeader { unit: LengthUnit::Metre, planes, options, tool };
//! let store = Store::create(folder.path().join("room.transect"), &header)?;
//!
//! // What stands for fusion here: all curves of all views.
//! let fuse = |_: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]| -> Vec<Curve> {
//!     partials.iter().flat_map(|(_, curves)| curves.clone()).collect()
//! };
//! let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 3.0)].map(|(x, y)| Node::at(Point2::new(x, y)));
//! let triangle = Curve::new(corners.to_vec(), true)?;
//! for id in ["front", "back"] {
//!     let mut view = store.begin_view(ViewDescription {
//!         id: id.into(),
//!         name: id.to_owned(),
//!         sensor: "imaging radar".to_owned(),
//!         source: format!("{id}.npy"),
//!         source_hash: String::new(),
//!         world_from_sensor: Isometry3::identity(),
//!         sigma: Some(0.001),
//!     })?;
//!     view.add_planes([(PlaneIndex(4), vec![triangle.clone()])], &fuse)?;
//!     view.commit()?;
//! }
//! store.remove_view(&"back".into(), &fuse)?;
//! let section = store.read()?.plane(PlaneIndex(4))?.ok_or("no curves")?;
//! assert!((section.measures().solid.estimate - 3.0).abs() < 1e-12); // square metres
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod blocks;
mod change;
mod copy;
mod error;
mod export;
mod fuse;
mod import;
mod in_memory;
mod lines;
mod medium;
mod pending;
mod query;
mod snapshot;
mod tables;
mod verify;
mod view;
mod view_id;

#[cfg(test)]
mod test_media;
#[cfg(test)]
mod tests;

pub use blocks::STORE_VERSION;
pub use change::{ViewReplacement, ViewTransaction};
pub use copy::ViewCopy;
pub use error::{StoreError, StoreProblem};
pub use fuse::{Fuse, PlaneInputs};
pub use lines::{LINES_START, LINES_VERSION};
pub use query::SpaceQuery;
pub use snapshot::Snapshot;
pub use verify::Verification;
pub use view::{StoreHeader, StoredView, ViewDescription};
pub use view_id::ViewId;

use crate::regular_file::{open_regular, require_regular};
use blocks::Blocks;
use in_memory::InMemory;
use medium::Medium;
use redb::{Database, ReadableDatabase, StorageBackend, WriteTransaction};
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use tables::{COPIES, FUSED, HEADER, PARTIALS, PENDING, VIEWS};

/// Memory for pages of the file, in bytes. Chosen by hand; doubled, pages are read again less
/// often.
const CACHE_BYTES: usize = 64 << 20;

/// A model in a file.
///
/// A file that opens holds a whole number of views. [`Store::verify`] checks everything else.
pub struct Store {
    path: PathBuf,
    database: Database,
}

impl std::fmt::Debug for Store {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Store").field("path", &self.path).finish_non_exhaustive()
    }
}

impl Store {
    /// Creates a store without views, in a file that must not exist yet.
    ///
    /// # Errors
    /// If the file exists or cannot be written, or the planes of the header are not usable.
    pub fn create(path: impl AsRef<Path>, header: &StoreHeader) -> Result<Self, StoreError> {
        let path = path.as_ref();
        build(path, |file| Self::create_in(path, file, header)).map_err(|p| p.at(path))
    }

    /// Opens a store for reading and writing, alone.
    ///
    /// # Errors
    /// [`StoreProblem::InUse`] or [`StoreProblem::BeingRead`] if it is open elsewhere,
    /// [`StoreProblem::Damaged`] if the file is not a complete store, or an I/O error.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, StoreError> {
        let path = path.as_ref();
        let open = || {
            require_regular(path)?;
            let file = File::options().read(true).write(true).open(path)?;
            lock(&file)?;
            Self::open_in(path, file)
        };
        open().map_err(|problem: StoreProblem| problem.at(path))
    }

    /// Opens a store for reading; any number of processes can do so at a time.
    ///
    /// The file is never written. Changes stay in memory, and are lost when the store is dropped.
    /// Such changes are the repair of a file that a crash left, and the planes of
    /// [`Store::fuse_pending`].
    ///
    /// # Errors
    /// [`StoreProblem::InUse`] while another process writes, otherwise as for [`Store::open`].
    pub fn open_read_only(path: impl AsRef<Path>) -> Result<Self, StoreError> {
        let path = path.as_ref();
        let open = || {
            let file = open_regular(path)?;
            file.try_lock_shared().map_err(|error| locked(error, StoreProblem::InUse))?;
            Self::open_on(path, InMemory::over(Blocks::open(file)?)?)
        };
        open().map_err(|problem: StoreProblem| problem.at(path))
    }

    pub(crate) fn create_in(
        path: &Path,
        medium: impl Medium,
        header: &StoreHeader,
    ) -> Result<Self, StoreProblem> {
        header.check()?;
        let blocks = Blocks::create(medium)?;
        let store = Self { path: path.to_owned(), database: database(blocks)? };
        let transaction = store.write()?;
        transaction.open_table(HEADER)?.insert("header", header.encode()?.as_slice())?;
        transaction.open_table(VIEWS)?;
        transaction.open_table(COPIES)?;
        transaction.open_table(PARTIALS)?;
        transaction.open_table(FUSED)?;
        transaction.open_table(PENDING)?;
        transaction.commit()?;
        Ok(store)
    }

    pub(crate) fn open_in(path: &Path, medium: impl Medium) -> Result<Self, StoreProblem> {
        Self::open_on(path, Blocks::open(medium)?)
    }

    fn open_on(path: &Path, blocks: impl StorageBackend) -> Result<Self, StoreProblem> {
        let store = Self { path: path.to_owned(), database: database(blocks)? };
        store.snapshot()?;
        Ok(store)
    }

    /// A snapshot of the store for reading.
    ///
    /// # Errors
    /// If the store is damaged.
    pub fn read(&self) -> Result<Snapshot, StoreError> {
        self.run(|| self.snapshot())
    }

    fn snapshot(&self) -> Result<Snapshot, StoreProblem> {
        Snapshot::of(&self.path, &self.database.begin_read()?)
    }

    /// The views in order of their ids.
    ///
    /// # Errors
    /// If the store is damaged.
    pub fn views(&self) -> Result<Vec<StoredView>, StoreError> {
        self.read()?.views()
    }

    /// Returns the space of removed and replaced views to the disk; `true` if there was any.
    ///
    /// # Errors
    /// [`StoreProblem::Readers`] while a snapshot is alive, or an I/O error.
    pub fn compact(&mut self) -> Result<bool, StoreError> {
        self.database.compact().map_err(|error| StoreProblem::from(error).at(&self.path))
    }

    /// Closes the file and returns the error if that fails. Dropping the store hides such an error.
    ///
    /// # Errors
    /// An I/O error. Committed views are not lost.
    pub fn close(self) -> Result<(), StoreError> {
        self.database.close().map_err(|error| StoreProblem::from(error).at(&self.path))
    }

    fn write(&self) -> Result<WriteTransaction, StoreProblem> {
        let mut transaction = self.database.try_begin_write()?;
        // Without quick repair, opening after a crash reads the whole file.
        transaction.set_quick_repair(true);
        Ok(transaction)
    }

    /// The result of some steps, with the file in their error.
    fn run<T>(&self, steps: impl FnOnce() -> Result<T, StoreProblem>) -> Result<T, StoreError> {
        steps().map_err(|problem| self.error(problem))
    }

    fn error(&self, problem: StoreProblem) -> StoreError {
        problem.at(&self.path)
    }
}

fn database(blocks: impl StorageBackend) -> Result<Database, StoreProblem> {
    Ok(Database::builder().set_cache_size(CACHE_BYTES).create_with_backend(blocks)?)
}

/// Locks a file for writing.
fn lock(file: &File) -> Result<(), StoreProblem> {
    let busy = |error| match file.try_lock_shared() {
        Ok(()) => locked(error, StoreProblem::BeingRead),
        Err(_) => locked(error, StoreProblem::InUse),
    };
    file.try_lock().map_err(busy)
}

fn locked(error: TryLockError, busy: StoreProblem) -> StoreProblem {
    match error {
        TryLockError::WouldBlock => busy,
        TryLockError::Error(error) => error.into(),
    }
}

/// Builds a store under another name and gives it its own one when it is complete, so a crash never
/// leaves half a store. A store that another process has made meanwhile stays.
fn build(
    path: &Path,
    fill: impl FnOnce(File) -> Result<Store, StoreProblem>,
) -> Result<Store, StoreProblem> {
    if path.try_exists()? {
        return Err(StoreProblem::Exists);
    }
    let beside = crate::file::path_beside(path);
    let file = File::options().read(true).write(true).create_new(true).open(&beside)?;
    let built = lock(&file).and_then(|()| fill(file));
    let named = built.and_then(|store| {
        publish(&beside, path)?;
        sync_folder_of(path)?;
        Ok(store)
    });
    if named.is_err() {
        // The unfinished file has no use.
        let _ = fs::remove_file(&beside);
    }
    named
}

/// Gives a file its name, unless there is a file of that name.
fn publish(beside: &Path, path: &Path) -> Result<(), StoreProblem> {
    match fs::hard_link(beside, path) {
        Ok(()) => Ok(fs::remove_file(beside)?),
        Err(_) if path.try_exists()? => Err(StoreProblem::Exists),
        // Some file systems have no links.
        Err(_) => Ok(fs::rename(beside, path)?),
    }
}

/// Writes the folder to disk: otherwise a power cut could remove the new name and the views
/// committed since.
fn sync_folder_of(path: &Path) -> std::io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if cfg!(unix) { File::open(folder.unwrap_or(Path::new(".")))?.sync_all() } else { Ok(()) }
}
