//! How a store has the curves of a plane fused: by whoever opened it.

use super::view_id::ViewId;
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
/// It must be a pure function of what it is given: then the fused planes are a pure function of the
/// set of partial models, whatever was added, removed and replaced before. Closures of
/// [`Fuse::fuse`]'s form are ways to fuse.
pub trait Fuse {
    /// The fused curves of a plane.
    fn fuse(&self, plane: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]) -> Vec<Curve>;

    /// The fused curves of several planes, in the same order; the place for parallel work.
    ///
    /// Fewer results than planes leave the last planes without curves.
    fn fuse_planes(&self, planes: &[PlaneInputs]) -> Vec<Vec<Curve>> {
        planes.iter().map(|inputs| self.fuse(inputs.plane, &inputs.partials)).collect()
    }
}

impl<F: Fn(PlaneIndex, &[(ViewId, Vec<Curve>)]) -> Vec<Curve>> Fuse for F {
    fn fuse(&self, plane: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]) -> Vec<Curve> {
        self(plane, partials)
    }
}
