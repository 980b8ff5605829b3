//! Checking a whole store: checksums, the database's own trees, and all contents.

use super::Store;
use super::error::{StoreError, StoreProblem};
use super::fuse::{Fuse, Met};
use super::snapshot::Snapshot;
use super::tables::{Partials, decode_fused, encode_fused, read_partials, read_views};
use super::view::{StoredView, node_count};
use super::view_id::ViewId;
use crate::codec::HASH_OF_NOTHING;
use crate::codec::values::hash_piece;
use redb::{ReadableTable, ReadableTableMetadata};
use std::collections::BTreeMap;
use transect_geometry::{PlaneIndex, crossings};

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
    /// Places where fused curves of a plane cross or touch each other.
    pub crossings: u64,
    /// FNV-1a hash of all contents; equal for stores of equal contents, whatever their history.
    pub hash: u64,
}

impl Store {
    /// Reads the whole store and checks all its promises.
    ///
    /// * Every block in use matches its checksum, and every page of the database matches the
    ///   checksum kept with the reference to it.
    /// * Every value decodes; headers, poses and curves are sound.
    /// * Views and partial curves name each other, with right counts. Copies name views.
    /// * Every plane with partial curves was fused from exactly these curves, or is marked as still
    ///   to be fused.
    ///
    /// [`Snapshot::stale_planes`] checks whether fusing again gives the same curves.
    ///
    /// # Errors
    /// The first problem found, or [`StoreProblem::Readers`] while a snapshot exists.
    pub fn verify(&mut self) -> Result<Verification, StoreError> {
        let sound = self.database.check_integrity();
        self.run(|| match sound? {
            true => self.snapshot()?.verify(),
            false => Err(StoreProblem::Inconsistent("the database had to be repaired".to_owned())),
        })
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
        let (mut stale, mut met) = (Vec::new(), Met::default());
        for entry in ReadableTable::iter(&self.fused)? {
            let (plane, value) = entry?;
            let plane = PlaneIndex(plane.value());
            let found = read_partials(&self.partials, plane)?;
            met.meet(&found, (&self.views, self.copies.as_ref()), None, fuse)?;
            let again = encode_fused(found.hash, &fuse.fuse(plane, &found.by_view))?;
            if again != value.value() {
                stale.push(plane);
            }
        }
        Ok(stale)
    }

    fn verify(&self) -> Result<Verification, StoreProblem> {
        let mut found = Verification { hash: HASH_OF_NOTHING, ..Verification::default() };
        for entry in ReadableTable::iter(&self.views)? {
            let (id, value) = entry?;
            found.add_hash(id.value().as_bytes(), value.value());
        }
        let views = read_views(&self.views)?;
        found.views = views.len() as u64;
        let empty = views.iter().map(|v| (v.entry.id.clone(), StoredView::new(v.entry.clone())));
        let mut counted: BTreeMap<_, _> = empty.collect();
        let (mut sections, mut from) = (0, Some(i64::MIN));
        while let Some(plane) = self.first_plane_with_partials(from)? {
            let partials = read_partials(&self.partials, plane)?;
            count(&partials, plane, &mut counted)?;
            sections += u64::from(self.verify_plane(plane, &partials, &mut found)?);
            from = plane.0.checked_add(1);
        }
        if (self.fused.len()?, self.pending.len()?) != (sections, found.pending) {
            let problem = "there are fused curves or marks on planes without partial curves";
            return Err(StoreProblem::Unsound(problem.to_owned()));
        }
        if let Some(wrong) = views.iter().find(|view| counted.get(&view.entry.id) != Some(view)) {
            let id = &wrong.entry.id;
            let problem = format!("the curves of view {id} are not those in its record");
            return Err(StoreProblem::Unsound(problem));
        }
        self.verify_copies(&views, &mut found)?;
        Ok(found)
    }

    /// Checks that every copy has a view and can be read.
    fn verify_copies(
        &self,
        views: &[StoredView],
        found: &mut Verification,
    ) -> Result<(), StoreProblem> {
        let Some(copies) = &self.copies else { return Ok(()) };
        for entry in ReadableTable::iter(copies)? {
            let (id, value) = entry?;
            let Some(view) = views.iter().find(|view| view.entry.id.0 == id.value()) else {
                let problem =
                    format!("there is a copy of a view {}, which is not there", id.value());
                return Err(StoreProblem::Unsound(problem));
            };
            self.read_copy(&view.entry)?;
            found.add_hash(id.value().as_bytes(), value.value());
        }
        Ok(())
    }

    fn first_plane_with_partials(
        &self,
        from: Option<i64>,
    ) -> Result<Option<PlaneIndex>, StoreProblem> {
        let Some(from) = from else { return Ok(None) };
        let first = self.partials.range((from, "")..)?.next().transpose()?;
        Ok(first.map(|(key, _)| PlaneIndex(key.value().0)))
    }

    /// Checks a plane with partial curves; whether it has fused curves.
    fn verify_plane(
        &self,
        plane: PlaneIndex,
        partials: &Partials,
        found: &mut Verification,
    ) -> Result<bool, StoreProblem> {
        found.planes += 1;
        let curves = || partials.by_view.iter().map(|(_, curves)| curves);
        found.partial_curves += curves().map(|c| c.len() as u64).sum::<u64>();
        found.partial_nodes += curves().map(|c| node_count(c)).sum::<u64>();
        found.add_hash(&plane.0.to_le_bytes(), &partials.hash.to_le_bytes());
        let value = self.fused.get(plane.0)?;
        let fused = value.as_ref().map(|v| decode_fused(plane, v.value())).transpose()?;
        if self.pending.get(plane.0)?.is_some() {
            // The plane may have old fused curves or none; old ones must be readable.
            found.pending += 1;
            return Ok(fused.is_some());
        }
        let unsound = |what: &str| StoreProblem::Unsound(format!("plane {plane} {what}"));
        let (made_of, curves) = fused.ok_or_else(|| unsound("was not fused"))?;
        if made_of != partials.hash {
            return Err(unsound("was fused from other curves than those in the store"));
        }
        found.curves += curves.len() as u64;
        found.nodes += node_count(&curves);
        found.crossings += crossings(&curves).len() as u64;
        found.add_hash(b"fused", value.as_ref().map_or(&[], |v| v.value()));
        Ok(true)
    }
}

impl Verification {
    fn add_hash(&mut self, key: &[u8], value: &[u8]) {
        self.hash = hash_piece(hash_piece(self.hash, key), value);
    }
}

/// Counts the partial curves of a plane for their views.
fn count(
    partials: &Partials,
    plane: PlaneIndex,
    counted: &mut BTreeMap<ViewId, StoredView>,
) -> Result<(), StoreProblem> {
    for (id, curves) in &partials.by_view {
        let unknown = || format!("there are curves of a view {id}, which has no record");
        let view = counted.get_mut(id).ok_or_else(|| StoreProblem::Unsound(unknown()))?;
        view.count(plane, curves);
    }
    Ok(())
}
