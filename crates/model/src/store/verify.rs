//! Checking a whole store: checksums, the database's own trees, and all contents.

use super::Store;
use super::error::{StoreError, StoreProblem};
use super::fuse::Fuse;
use super::snapshot::Snapshot;
use super::tables::{decode_curves, decode_fused, encode_fused, read_partials, read_views};
use super::view::{StoredView, node_count};
use super::view_id::ViewId;
use crate::codec::HASH_OF_NOTHING;
use crate::codec::values::hash_piece;
use redb::{ReadableTable, ReadableTableMetadata};
use std::collections::BTreeMap;
use transect_geometry::PlaneIndex;

/// The counts of [`Store::verify`].
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Verification {
    /// Views in the store.
    pub views: u64,
    /// Planes with partial curves.
    pub planes: u64,
    /// Planes among them that are still to be fused.
    pub pending: u64,
    /// Partial curves of all views.
    pub partial_curves: u64,
    /// Nodes of the partial curves.
    pub partial_nodes: u64,
    /// Fused curves.
    pub curves: u64,
    /// Nodes of the fused curves.
    pub nodes: u64,
    /// FNV-1a hash of all contents; equal for stores of equal contents, whatever their history.
    pub hash: u64,
}

impl Store {
    /// Reads the whole store and checks all its promises.
    ///
    /// * Every block in use matches its checksum, and every page of the database matches the
    ///   checksum kept with the reference to it.
    /// * Every value decodes; headers, poses and curves are sound.
    /// * Views and partial curves name each other, with right counts.
    /// * Every plane with partial curves was fused from exactly these curves, or is marked as still
    ///   to be fused.
    ///
    /// [`Snapshot::stale_planes`] checks whether fusing again gives the same curves.
    ///
    /// # Errors
    /// The first problem found, or [`StoreProblem::Readers`] while a snapshot exists.
    pub fn verify(&mut self) -> Result<Verification, StoreError> {
        let sound = self.database.check_integrity().map_err(StoreProblem::from);
        let checked = sound.and_then(|sound| match sound {
            true => self.snapshot()?.verify(),
            false => Err(StoreProblem::Inconsistent("the database had to be repaired".to_owned())),
        });
        checked.map_err(|problem| self.error(problem))
    }
}

impl Snapshot {
    /// The planes whose stored curves differ from those that `fuse` makes of their partial curves,
    /// for example after a change of the program.
    ///
    /// # Errors
    /// If the store is damaged.
    pub fn stale_planes(&self, fuse: &impl Fuse) -> Result<Vec<PlaneIndex>, StoreError> {
        self.find_stale(fuse).map_err(|problem| self.error(problem))
    }

    fn find_stale(&self, fuse: &impl Fuse) -> Result<Vec<PlaneIndex>, StoreProblem> {
        self.check_fused()?;
        let mut stale = Vec::new();
        for entry in ReadableTable::iter(&self.fused)? {
            let (plane, value) = entry?;
            let plane = PlaneIndex(plane.value());
            let found = read_partials(&self.partials, plane)?;
            let again = encode_fused(found.hash, &fuse.fuse(plane, &found.by_view))?;
            if again != value.value() {
                stale.push(plane);
            }
        }
        Ok(stale)
    }

    fn verify(&self) -> Result<Verification, StoreProblem> {
        let views = read_views(&self.views)?;
        let counted = views.iter().map(|v| (v.entry.id.clone(), StoredView::new(v.entry.clone())));
        let mut seen = Seen { by_view: counted.collect(), ..Seen::default() };
        seen.counts.views = views.len() as u64;
        seen.counts.hash = HASH_OF_NOTHING;
        for entry in ReadableTable::iter(&self.views)? {
            let (id, value) = entry?;
            seen.add_hash(id.value().as_bytes(), value.value());
        }
        for entry in ReadableTable::iter(&self.partials)? {
            let (key, value) = entry?;
            let (k, id) = key.value();
            if seen.plane.is_some_and(|plane| plane.0 != k) {
                self.finish_plane(&mut seen)?;
            }
            seen.add_partial(PlaneIndex(k), id, value.value())?;
        }
        self.finish_plane(&mut seen)?;
        if (self.fused.len()?, self.pending.len()?) != (seen.sections, seen.counts.pending) {
            let problem = "there are fused curves or marks on planes without partial curves";
            return Err(StoreProblem::Unsound(problem.to_owned()));
        }
        match views.iter().zip(seen.by_view.values()).find(|(view, counted)| view != counted) {
            Some((view, _)) => {
                let problem =
                    format!("the curves of view {} are not those in its record", view.entry.id);
                Err(StoreProblem::Unsound(problem))
            }
            None => Ok(seen.counts),
        }
    }

    /// Checks the fused curves of the plane whose partial curves were just read.
    fn finish_plane(&self, seen: &mut Seen) -> Result<(), StoreProblem> {
        let Some(plane) = seen.plane.take() else {
            return Ok(());
        };
        seen.counts.planes += 1;
        if self.pending.get(plane.0)?.is_some() {
            return self.finish_pending(plane, seen);
        }
        let unsound = |what: &str| StoreProblem::Unsound(format!("plane {plane} {what}"));
        let value = self.fused.get(plane.0)?.ok_or_else(|| unsound("was not fused"))?;
        let (made_of, curves) = decode_fused(plane, value.value())?;
        if made_of != seen.made_of {
            return Err(unsound("was fused from other curves than those in the store"));
        }
        seen.sections += 1;
        seen.counts.curves += curves.len() as u64;
        seen.counts.nodes += node_count(&curves);
        seen.add_hash(&plane.0.to_le_bytes(), value.value());
        Ok(())
    }
}

impl Snapshot {
    /// A plane that is still to be fused may have old fused curves or none; old ones must be
    /// readable.
    fn finish_pending(&self, plane: PlaneIndex, seen: &mut Seen) -> Result<(), StoreProblem> {
        seen.counts.pending += 1;
        if let Some(value) = self.fused.get(plane.0)? {
            decode_fused(plane, value.value())?;
            seen.sections += 1;
        }
        seen.add_hash(&plane.0.to_le_bytes(), b"pending");
        Ok(())
    }
}

/// The state of the walk through the partial curves.
#[derive(Default)]
struct Seen {
    counts: Verification,
    /// Planes that have fused curves.
    sections: u64,
    /// The plane whose partial curves are being read, and the hash of the curves so far.
    plane: Option<PlaneIndex>,
    made_of: u64,
    /// Every view with the curves that were read so far.
    by_view: BTreeMap<ViewId, StoredView>,
}

impl Seen {
    fn add_hash(&mut self, key: &[u8], value: &[u8]) {
        self.counts.hash = hash_piece(hash_piece(self.counts.hash, key), value);
    }

    fn add_partial(
        &mut self,
        plane: PlaneIndex,
        id: &str,
        value: &[u8],
    ) -> Result<(), StoreProblem> {
        if self.plane.is_none() {
            (self.plane, self.made_of) = (Some(plane), HASH_OF_NOTHING);
        }
        self.made_of = hash_piece(hash_piece(self.made_of, id.as_bytes()), value);
        let curves = decode_curves(plane, id, value)?;
        self.counts.partial_curves += curves.len() as u64;
        self.counts.partial_nodes += node_count(&curves);
        let unknown = || format!("there are curves of a view {id}, which has no record");
        let view = self.by_view.get_mut(&id.into());
        view.ok_or_else(|| StoreProblem::Unsound(unknown()))?.count(plane, &curves);
        self.add_hash(id.as_bytes(), value);
        Ok(())
    }
}
