//! Changing a store: views are added, removed and replaced, each time in one transaction.

use super::Store;
use super::copy::{self, ViewCopy};
use super::error::{StoreError, StoreProblem};
use super::fuse::{Fuse, Met, PlaneInputs};
use super::tables::{
    COPIES, FUSED, PARTIALS, PENDING, VIEWS, encode_curves, encode_fused, read_partials, read_view,
};
use super::view::{StoredView, ViewDescription};
use super::view_id::ViewId;
use redb::WriteTransaction;
use std::collections::BTreeSet;
use transect_geometry::{Curve, PlaneIndex};

/// Bytes of partial curves in memory at a time while planes are fused. Chosen by hand; doubled,
/// fusing takes twice the memory and larger batches run in parallel.
const BATCH_BYTES: usize = 16 << 20;

/// A view that is being added to a store. [`ViewTransaction::commit`] makes it part of the store.
///
/// If it is dropped, the store is unchanged. Snapshots can be read meanwhile and do not have the
/// view.
#[must_use = "nothing is stored before commit"]
pub struct ViewTransaction<'s> {
    store: &'s Store,
    transaction: WriteTransaction,
    view: StoredView,
    /// True during a step and after a failed one, because half a view must not be committed.
    broken: bool,
}

impl std::fmt::Debug for ViewTransaction<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ViewTransaction").field("view", &self.view).finish_non_exhaustive()
    }
}

/// A view that takes the place of another one.
#[derive(Debug, Clone)]
pub struct ViewReplacement<C> {
    /// The id of the view that leaves.
    pub id: ViewId,
    /// The view that comes.
    pub entry: ViewDescription,
    /// The coarse copy of its image.
    pub copy: Option<ViewCopy>,
    /// The curves of the view that comes, plane by plane.
    pub planes: C,
}

impl Store {
    /// Begins to add a view.
    ///
    /// # Errors
    /// If a view of that id exists, the pose or noise is invalid, or another thread is changing the
    /// store.
    pub fn begin_view(&self, entry: ViewDescription) -> Result<ViewTransaction<'_>, StoreError> {
        self.run(|| {
            entry.check()?;
            let transaction = self.write()?;
            if read_view(&transaction.open_table(VIEWS)?, &entry.id)?.is_some() {
                return Err(StoreProblem::ViewExists(entry.id));
            }
            let view = StoredView::new(entry);
            Ok(ViewTransaction { store: self, transaction, view, broken: false })
        })
    }

    /// Removes a view and fuses its planes again.
    ///
    /// # Errors
    /// If there is no such view, or the store cannot be read or written; it is then unchanged.
    pub fn remove_view(&self, id: &ViewId, fuse: &impl Fuse) -> Result<StoredView, StoreError> {
        self.run(|| {
            let transaction = self.write()?;
            let view = take_out(&transaction, id)?;
            fuse_again(&transaction, view.planes.iter().copied(), None, fuse)?;
            transaction.commit()?;
            Ok(view)
        })
    }

    /// Replaces the curves of views, for example after a better registration, and fuses their old
    /// and new planes again, all in one transaction. Returns the new views in the given order.
    ///
    /// # Errors
    /// As for [`Store::remove_view`] and [`Store::begin_view`]; the store is then unchanged. The id
    /// of a new entry may differ from that of the view it replaces, if no other view has it.
    pub fn replace_views<C: IntoIterator<Item = (PlaneIndex, Vec<Curve>)>>(
        &self,
        replacements: Vec<ViewReplacement<C>>,
        fuse: &impl Fuse,
    ) -> Result<Vec<StoredView>, StoreError> {
        self.run(|| {
            let transaction = self.write()?;
            let mut touched = BTreeSet::new();
            for ViewReplacement { id, entry, .. } in &replacements {
                entry.check()?;
                touched.extend(take_out(&transaction, id)?.planes);
            }
            let mut views = Vec::with_capacity(replacements.len());
            for ViewReplacement { entry, copy, planes, .. } in replacements {
                if read_view(&transaction.open_table(VIEWS)?, &entry.id)?.is_some() {
                    return Err(StoreProblem::ViewExists(entry.id));
                }
                if let Some(copy) = &copy {
                    copy::put(&transaction, &entry, copy)?;
                }
                let mut view = StoredView::new(entry);
                for (plane, curves) in planes {
                    touched
                        .extend(put_in(&transaction, &mut view, plane, &curves)?.then_some(plane));
                }
                views.push(enter(&transaction, view)?);
            }
            fuse_again(&transaction, touched, None, fuse)?;
            transaction.commit()?;
            Ok(views)
        })
    }
}

impl ViewTransaction<'_> {
    /// Adds the coarse copy of the view's image.
    ///
    /// # Errors
    /// If the store cannot be read or written.
    pub fn set_copy(&mut self, copy: &ViewCopy) -> Result<(), StoreError> {
        self.step(|transaction, view| copy::put(transaction, &view.entry, copy))
    }

    /// Adds the view's curves on several planes and fuses those planes again, many at a time
    /// ([`Fuse::fuse_planes`]).
    ///
    /// # Errors
    /// If a plane was already given, or the store cannot be read or written.
    pub fn add_planes(
        &mut self,
        curves: impl IntoIterator<Item = (PlaneIndex, Vec<Curve>)>,
        fuse: &impl Fuse,
    ) -> Result<(), StoreError> {
        self.step(|transaction, view| {
            let mut touched = Vec::new();
            for (plane, curves) in curves {
                touched.extend(put_in(transaction, view, plane, &curves)?.then_some(plane));
            }
            fuse_again(transaction, touched, Some(&view.entry), fuse)
        })
    }

    /// Adds the view's curves on several planes, which [`Store::fuse_pending`] has to fuse later.
    ///
    /// For many views at once: a plane of several views is then fused once.
    ///
    /// # Errors
    /// As for [`ViewTransaction::add_planes`].
    pub fn defer_planes(
        &mut self,
        curves: impl IntoIterator<Item = (PlaneIndex, Vec<Curve>)>,
    ) -> Result<(), StoreError> {
        self.step(|transaction, view| {
            let mut pending = transaction.open_table(PENDING)?;
            for (plane, curves) in curves {
                if put_in(transaction, view, plane, &curves)? {
                    pending.insert(plane.0, ())?;
                }
            }
            Ok(())
        })
    }

    fn step(
        &mut self,
        step: impl FnOnce(&WriteTransaction, &mut StoredView) -> Result<(), StoreProblem>,
    ) -> Result<(), StoreError> {
        if std::mem::replace(&mut self.broken, true) {
            return Err(self.store.error(StoreProblem::Failed));
        }
        let done = step(&self.transaction, &mut self.view);
        self.broken = done.is_err();
        done.map_err(|problem| self.store.error(problem))
    }

    /// Makes the view part of the store. After this returns, the view survives a power cut.
    ///
    /// # Errors
    /// If writing fails, such as on a full disk, or an earlier step failed; the store is then
    /// unchanged.
    pub fn commit(self) -> Result<StoredView, StoreError> {
        let store = self.store;
        if self.broken {
            return Err(store.error(StoreProblem::Failed));
        }
        store.run(|| {
            let view = enter(&self.transaction, self.view)?;
            self.transaction.commit()?;
            Ok(view)
        })
    }
}

/// Enters a view, whose curves are stored, into the list of views.
fn enter(transaction: &WriteTransaction, mut view: StoredView) -> Result<StoredView, StoreProblem> {
    view.planes.sort_unstable();
    let value = view.encode()?;
    transaction.open_table(VIEWS)?.insert(view.entry.id.0.as_str(), value.as_slice())?;
    Ok(view)
}

/// Stores the partial curves of a view on a plane; `false` if the list is empty.
fn put_in(
    transaction: &WriteTransaction,
    view: &mut StoredView,
    plane: PlaneIndex,
    curves: &[Curve],
) -> Result<bool, StoreProblem> {
    if curves.is_empty() {
        return Ok(false);
    }
    let mut table = transaction.open_table(PARTIALS)?;
    let value = encode_curves(curves)?;
    let before = table.insert((plane.0, view.entry.id.0.as_str()), value.as_slice())?;
    if before.is_some() {
        return Err(StoreProblem::PlaneTwice(plane));
    }
    view.count(plane, curves);
    Ok(true)
}

/// Removes a view, its copy and its partial curves. The fused curves are not changed yet.
fn take_out(transaction: &WriteTransaction, id: &ViewId) -> Result<StoredView, StoreProblem> {
    let mut views = transaction.open_table(VIEWS)?;
    let view = read_view(&views, id)?.ok_or_else(|| StoreProblem::NoSuchView(id.clone()))?;
    views.remove(id.0.as_str())?;
    copy::take(transaction, &id.0)?;
    let mut partials = transaction.open_table(PARTIALS)?;
    for plane in &view.planes {
        partials.remove((plane.0, id.0.as_str()))?;
    }
    Ok(view)
}

/// Fuses planes again from their partial curves. The section of a plane without partial curves is
/// removed. `new` is a view that is not yet in the list of views.
pub(super) fn fuse_again(
    transaction: &WriteTransaction,
    planes: impl IntoIterator<Item = PlaneIndex>,
    new: Option<&ViewDescription>,
    fuse: &impl Fuse,
) -> Result<(), StoreProblem> {
    let (mut batch, mut hashes, mut size) = (Vec::new(), Vec::new(), 0);
    let (views, copies) = (transaction.open_table(VIEWS)?, transaction.open_table(COPIES)?);
    let mut met = Met::default();
    for plane in planes {
        let found = read_partials(&transaction.open_table(PARTIALS)?, plane)?;
        transaction.open_table(PENDING)?.remove(plane.0)?;
        if found.by_view.is_empty() {
            transaction.open_table(FUSED)?.remove(plane.0)?;
            continue;
        }
        met.meet(&found, (&views, Some(&copies)), new, fuse)?;
        batch.push(PlaneInputs { plane, partials: found.by_view });
        hashes.push(found.hash);
        size += found.size;
        if size >= BATCH_BYTES {
            fuse_batch(transaction, &batch, &hashes, fuse)?;
            batch.clear();
            hashes.clear();
            size = 0;
        }
    }
    fuse_batch(transaction, &batch, &hashes, fuse)
}

fn fuse_batch(
    transaction: &WriteTransaction,
    batch: &[PlaneInputs],
    hashes: &[u64],
    fuse: &impl Fuse,
) -> Result<(), StoreProblem> {
    let mut table = transaction.open_table(FUSED)?;
    let fused = fuse.fuse_planes(batch).into_iter().chain(std::iter::repeat(Vec::new()));
    for ((inputs, hash), curves) in batch.iter().zip(hashes).zip(fused) {
        table.insert(inputs.plane.0, encode_fused(*hash, &curves)?.as_slice())?;
    }
    Ok(())
}
