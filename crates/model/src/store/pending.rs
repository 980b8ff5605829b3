//! Planes that are still to be fused, because many views were added at once.
//!
//! Idea: a view is stored in its own transaction, with a mark on each of its planes. The marked
//! planes are fused in one transaction after the last view. As long as a mark exists, calls that
//! need fused curves return [`StoreProblem::Pending`]. After a crash the marks are still there.

use super::Store;
use super::change::fuse_again;
use super::error::{StoreError, StoreProblem};
use super::fuse::Fuse;
use super::snapshot::Snapshot;
use super::tables::PENDING;
use redb::{ReadableTable, ReadableTableMetadata};
use transect_geometry::PlaneIndex;

impl Store {
    /// Fuses all marked planes in one transaction and returns their number.
    ///
    /// # Errors
    /// If the store cannot be read or written; the marks are then unchanged.
    pub fn fuse_pending(&self, fuse: &impl Fuse) -> Result<u64, StoreError> {
        self.run(|| {
            let transaction = self.write()?;
            let marked = planes(&transaction.open_table(PENDING)?)?;
            if !marked.is_empty() {
                fuse_again(&transaction, marked.iter().copied(), None, fuse)?;
                transaction.commit()?;
            }
            Ok(marked.len() as u64)
        })
    }
}

impl Snapshot {
    /// The planes that are still to be fused, in order of station.
    ///
    /// # Errors
    /// If the store is damaged.
    pub fn pending(&self) -> Result<Vec<PlaneIndex>, StoreError> {
        planes(&self.pending).map_err(|problem| self.error(problem))
    }

    /// Refuses if planes are still to be fused.
    pub(super) fn check_fused(&self) -> Result<(), StoreProblem> {
        match self.pending.len()? {
            0 => Ok(()),
            waiting => Err(StoreProblem::Pending(waiting)),
        }
    }
}

fn planes(table: &impl ReadableTable<i64, ()>) -> Result<Vec<PlaneIndex>, StoreProblem> {
    let planes = table.iter()?.map(|entry| Ok(PlaneIndex(entry?.0.value())));
    planes.collect()
}
