//! Fusing the curves of a plane, a function that the caller gives to the store.

use super::copy::{self, ViewCopy};
use super::error::StoreProblem;
use super::tables::{Partials, read_view};
use super::view::ViewDescription;
use super::view_id::ViewId;
use redb::ReadableTable;
use std::collections::BTreeSet;
use transect_geometry::{Curve, PlaneIndex};

/// The partial curves of all views on one plane, in order of view ids.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneInputs {
    /// The plane.
    pub plane: PlaneIndex,
    /// Each view's curves, at least one view.
    pub partials: Vec<(ViewId, Vec<Curve>)>,
}

/// A way to fuse the curves of one plane.
///
/// It must be a pure function of its arguments and of the views that it met. Then the fused planes
/// depend on the set of views alone, not on earlier additions and removals. Closures with the
/// arguments of [`Fuse::fuse`] implement it.
pub trait Fuse {
    /// Meets a view with curves on planes that are fused next. It has the coarse copy of its image,
    /// if the store keeps one.
    fn meet(&self, view: &ViewDescription, copy: Option<ViewCopy>) {
        let _ = (view, copy);
    }

    /// The fused curves of a plane.
    fn fuse(&self, plane: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]) -> Vec<Curve>;

    /// The fused curves of several planes, in the same order. Implementations may work in parallel.
    ///
    /// If there are fewer results than planes, the last planes have no curves.
    fn fuse_planes(&self, planes: &[PlaneInputs]) -> Vec<Vec<Curve>> {
        planes.iter().map(|inputs| self.fuse(inputs.plane, &inputs.partials)).collect()
    }
}

impl<F: Fn(PlaneIndex, &[(ViewId, Vec<Curve>)]) -> Vec<Curve>> Fuse for F {
    fn fuse(&self, plane: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]) -> Vec<Curve> {
        self(plane, partials)
    }
}

/// The views that a [`Fuse`] has met.
#[derive(Default)]
pub(super) struct Met(BTreeSet<ViewId>);

impl Met {
    /// Lets it meet the views of a plane that it has not met.
    pub fn meet<T: ReadableTable<&'static str, &'static [u8]>>(
        &mut self,
        plane: &Partials,
        (views, copies): (&T, Option<&T>),
        new: Option<&ViewDescription>,
        fuse: &impl Fuse,
    ) -> Result<(), StoreProblem> {
        for (id, _) in &plane.by_view {
            if !self.0.insert(id.clone()) {
                continue;
            }
            let entry = match new.filter(|new| new.id == *id) {
                Some(new) => Some(new.clone()),
                None => read_view(views, id)?.map(|view| view.entry),
            };
            let Some(entry) = entry else { continue };
            let copy = copies.map_or(Ok(None), |copies| copy::get(copies, &entry))?;
            fuse.meet(&entry, copy);
        }
        Ok(())
    }
}
