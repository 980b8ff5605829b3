//! Reading a store: a snapshot has the views that were committed when it was taken.

use super::error::{StoreError, StoreProblem};
use super::tables::{
    FUSED, HEADER, PARTIALS, PENDING, VIEWS, decode_fused, open_copies, read_partials, read_view,
    read_views,
};
use super::view::{StoreHeader, StoredView, ViewDescription};
use super::view_id::ViewId;
use crate::{Model, Section, ViewRecord};
use redb::{ReadOnlyTable, ReadTransaction, ReadableTable, ReadableTableMetadata};
use std::path::{Path, PathBuf};
use transect_geometry::{Curve, PlaneIndex};

/// A store as it was at one moment, for reading, from any thread.
///
/// Later changes are not visible in it. While a snapshot exists, the space of changed data is not
/// reused, and the store cannot be compacted.
pub struct Snapshot {
    path: PathBuf,
    header: StoreHeader,
    pub(super) views: ReadOnlyTable<&'static str, &'static [u8]>,
    pub(super) copies: Option<ReadOnlyTable<&'static str, &'static [u8]>>,
    pub(super) partials: ReadOnlyTable<(i64, &'static str), &'static [u8]>,
    pub(super) fused: ReadOnlyTable<i64, &'static [u8]>,
    pub(super) pending: ReadOnlyTable<i64, ()>,
}

impl std::fmt::Debug for Snapshot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Snapshot").field("path", &self.path).finish_non_exhaustive()
    }
}

impl Snapshot {
    pub(super) fn of(path: &Path, transaction: &ReadTransaction) -> Result<Self, StoreProblem> {
        let header = transaction.open_table(HEADER)?;
        let header = header.get("header")?;
        let missing = || StoreProblem::Unsound("there is no header".to_owned());
        let header = StoreHeader::decode(header.ok_or_else(missing)?.value())?;
        Ok(Self {
            path: path.to_owned(),
            header,
            views: transaction.open_table(VIEWS)?,
            copies: open_copies(transaction)?,
            partials: transaction.open_table(PARTIALS)?,
            fused: transaction.open_table(FUSED)?,
            pending: transaction.open_table(PENDING)?,
        })
    }

    /// The header of the store.
    pub fn header(&self) -> &StoreHeader {
        &self.header
    }

    /// The views in order of their ids.
    ///
    /// # Errors
    /// If the store is damaged, as for everything below.
    pub fn views(&self) -> Result<Vec<StoredView>, StoreError> {
        read_views(&self.views).map_err(|problem| self.error(problem))
    }

    /// One view; `None` if no view has that id.
    ///
    /// # Errors
    /// If the store is damaged.
    pub fn view(&self, id: &ViewId) -> Result<Option<StoredView>, StoreError> {
        read_view(&self.views, id).map_err(|problem| self.error(problem))
    }

    /// Number of planes with partial curves; some of them may have no fused curves.
    ///
    /// # Errors
    /// If the store is damaged, or planes are still to be fused.
    pub fn plane_count(&self) -> Result<u64, StoreError> {
        let count = || self.check_fused().and(self.fused.len().map_err(StoreProblem::from));
        count().map_err(|problem: StoreProblem| self.error(problem))
    }

    /// The fused curves of a plane; `None` if it has none.
    ///
    /// # Errors
    /// If the store is damaged, or planes are still to be fused ([`StoreProblem::Pending`]).
    pub fn plane(&self, plane: PlaneIndex) -> Result<Option<Section>, StoreError> {
        self.read_plane(plane).map_err(|problem| self.error(problem))
    }

    fn read_plane(&self, plane: PlaneIndex) -> Result<Option<Section>, StoreProblem> {
        self.check_fused()?;
        let Some(value) = self.fused.get(plane.0)? else {
            return Ok(None);
        };
        Ok(Section::new(decode_fused(plane, value.value())?.1))
    }

    /// Each view's curves on a plane, in order of view ids.
    ///
    /// # Errors
    /// If the store is damaged.
    pub fn partials(&self, plane: PlaneIndex) -> Result<Vec<(ViewId, Vec<Curve>)>, StoreError> {
        let found = read_partials(&self.partials, plane);
        Ok(found.map_err(|problem| self.error(problem))?.by_view)
    }

    /// The planes that have curves, in order of station, one in memory at a time.
    ///
    /// # Errors
    /// If the store is damaged, or planes are still to be fused; each item may report damage too.
    pub fn planes(
        &self,
    ) -> Result<
        impl DoubleEndedIterator<Item = Result<(PlaneIndex, Section), StoreError>>,
        StoreError,
    > {
        self.check_fused().map_err(|problem| self.error(problem))?;
        let found = ReadableTable::iter(&self.fused);
        let found = found.map_err(|error| self.error(error.into()))?;
        let read = |entry: Result<_, redb::StorageError>| -> Result<_, StoreProblem> {
            let (plane, value): (redb::AccessGuard<'_, i64>, redb::AccessGuard<'_, &[u8]>) = entry?;
            let plane = PlaneIndex(plane.value());
            Ok((plane, Section::new(decode_fused(plane, value.value())?.1)))
        };
        Ok(found.filter_map(move |entry| match read(entry) {
            Ok((plane, section)) => Some(Ok((plane, section?))),
            Err(problem) => Some(Err(self.error(problem))),
        }))
    }

    /// The whole model in memory, with the views in order of their ids.
    ///
    /// # Errors
    /// If the store is damaged.
    pub fn model(&self) -> Result<Model, StoreError> {
        let mut model = Model::new(self.header.unit, self.header.planes.clone());
        for view in self.views()? {
            let ViewDescription { name, source, world_from_sensor, sigma, .. } = view.entry;
            model.add_view(ViewRecord {
                name,
                source,
                world_from_sensor,
                sigma,
                nodes: view.nodes,
            });
        }
        for entry in self.planes()? {
            let (plane, section) = entry?;
            model.set_curves(plane, section.into_curves());
        }
        Ok(model)
    }

    pub(super) fn error(&self, problem: StoreProblem) -> StoreError {
        problem.at(&self.path)
    }
}
