//! Fusing the curves of a plane, a function that the caller gives to the store.

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
/// It must be a pure function of its arguments. Then the fused planes depend on the set of partial
/// models alone, not on earlier additions and removals. Closures with the arguments of
/// [`Fuse::fuse`] implement it.
pub trait Fuse {
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
