//! Errors of a store.

use super::view_id::ViewId;
use crate::{CodecError, InvariantError};
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use transect_geometry::PlaneIndex;

/// An error of a store, with its file: its text is a sentence of the file and the problem. Its
/// source is the cause of the problem, if there is one.
#[derive(Debug)]
pub struct StoreError {
    /// The store's file.
    pub path: PathBuf,
    /// The problem.
    pub problem: StoreProblem,
}

impl fmt::Display for StoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the model store {} {}", self.path.display(), self.problem)
    }
}

impl std::error::Error for StoreError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        // The text holds the problem already.
        std::error::Error::source(&self.problem)
    }
}

/// The problem with a store, or with a call. Its text continues a sentence that begins with the
/// store, as that of [`StoreError`] does.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreProblem {
    /// Another process, or another handle of this one, has the file open for writing.
    #[error(
        "is open for changes already, here or in another process; close it, or wait until that process \
         has finished"
    )]
    InUse,
    /// Another process, or another handle of this one, reads the file, and the call must write.
    #[error("is being read by another process; wait until that process has finished")]
    BeingRead,
    /// The store is to be made, and there is a file of its name.
    #[error(
        "exists already; choose another file. If another process has just made it, repeat the \
         command when that process has finished"
    )]
    Exists,
    /// Another thread of this process is changing the store.
    #[error("is being changed by another thread of this program")]
    Busy,
    /// A snapshot exists, and the call needs the store alone.
    #[error("is being read by this program; drop all snapshots before compacting and verifying")]
    Readers,
    /// The bytes of the file are not those that were written.
    #[error("cannot be read")]
    Damaged(#[source] CodecError),
    /// Reading or writing the file failed. Committed views are not lost.
    #[error("could not be read or written{}", advice(.0))]
    Io(#[source] io::Error),
    /// The database found itself inconsistent.
    #[error("is inconsistent: {0}")]
    Inconsistent(String),
    /// An earlier call failed; the store must be opened again.
    #[error("had a failure before and must be opened again")]
    Failed,
    /// A value does not decode.
    #[error("has an unreadable {what}")]
    Value {
        /// The owner of the value.
        what: String,
        /// Why.
        #[source]
        source: CodecError,
    },
    /// The contents contradict each other.
    #[error("has contents that contradict each other: {0}")]
    Unsound(String),
    /// The header or a view is invalid.
    #[error("would be invalid")]
    Invariant(#[from] InvariantError),
    /// There is no such view.
    #[error("has no view \"{0}\"")]
    NoSuchView(ViewId),
    /// There is such a view already.
    #[error("has a view \"{0}\" already")]
    ViewExists(ViewId),
    /// A view was given curves of one plane twice.
    #[error("was given plane {0} twice by one view")]
    PlaneTwice(PlaneIndex),
    /// Planes are still to be fused, and the call needs their fused curves.
    #[error("has {0} planes that are still to be fused; repeat the run that was interrupted")]
    Pending(u64),
    /// The lines of an export could not be written.
    #[error("could not be exported")]
    Export(#[source] io::Error),
    /// A line of an export is wrong.
    #[error("could not be imported: line {line}: {problem}")]
    Import {
        /// The line, from 1.
        line: usize,
        /// The problem.
        problem: String,
    },
}

/// What to do about a disk without space.
fn advice(error: &io::Error) -> &'static str {
    use io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
    match error.kind() {
        StorageFull | FileTooLarge | QuotaExceeded => {
            "; it keeps what it had. Free space on its disk, which every change needs"
        }
        _ => "",
    }
}

impl StoreProblem {
    pub(crate) fn at(self, path: &Path) -> StoreError {
        StoreError { path: path.to_owned(), problem: self }
    }

    pub(crate) fn value(what: impl std::fmt::Display) -> impl FnOnce(CodecError) -> Self {
        move |source| Self::Value { what: what.to_string(), source }
    }
}

impl From<io::Error> for StoreProblem {
    fn from(error: io::Error) -> Self {
        error.downcast().map_or_else(Self::Io, Self::Damaged)
    }
}

impl From<redb::Error> for StoreProblem {
    fn from(error: redb::Error) -> Self {
        match error {
            redb::Error::Io(error) => error.into(),
            redb::Error::PreviousIo | redb::Error::LockPoisoned(_) => Self::Failed,
            redb::Error::DatabaseAlreadyOpen => Self::InUse,
            redb::Error::TransactionInProgress => Self::Readers,
            other => Self::Inconsistent(other.to_string()),
        }
    }
}

impl From<redb::TransactionError> for StoreProblem {
    fn from(error: redb::TransactionError) -> Self {
        match error {
            redb::TransactionError::WouldBlock => Self::Busy,
            other => redb::Error::from(other).into(),
        }
    }
}

/// The database has an error type for each kind of call.
macro_rules! from_database_error {
    ($($kind:ident),*) => {$(
        impl From<redb::$kind> for StoreProblem {
            fn from(error: redb::$kind) -> Self {
                redb::Error::from(error).into()
            }
        }
    )*};
}

from_database_error!(StorageError, DatabaseError, TableError, CommitError, CompactionError);
