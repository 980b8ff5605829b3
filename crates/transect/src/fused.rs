//! Fusing the curves of one plane after another.

use crate::packed::PackedCurves;
use crate::{ReconstructError, Setup, Stage, Watch};
use rayon::prelude::*;
use std::borrow::Borrow;
use std::collections::BTreeMap;
use transect_fusion::{FusedPlane, fuse_plane};
use transect_geometry::{Curve, PlaneIndex};

/// The curves that each plane has from each view, in the order of the views.
pub(crate) type Observed = BTreeMap<PlaneIndex, Vec<PackedCurves>>;

/// The fused curves of a plane.
pub(crate) struct Fused {
    pub index: PlaneIndex,
    pub plane: FusedPlane,
}

/// Fuses planes in parallel. The curves of a plane that is given away are freed with its fusion.
pub(crate) fn fuse<V: Borrow<Vec<PackedCurves>> + Send>(
    planes: Vec<(PlaneIndex, V)>,
    setup: &Setup,
    watch: &dyn Watch,
) -> Result<Vec<Fused>, ReconstructError> {
    watch.begin(Stage::Planes, planes.len());
    let fuse = |(index, views): (PlaneIndex, V)| {
        if watch.cancelled() {
            return Err(ReconstructError::Cancelled);
        }
        let curves: Vec<Vec<Curve>> = views.borrow().iter().map(PackedCurves::curves).collect();
        drop(views);
        let curves: Vec<&[Curve]> = curves.iter().map(Vec::as_slice).collect();
        let plane = fuse_plane(&curves, &setup.fusion);
        watch.step(Stage::Planes);
        Ok(Fused { index, plane })
    };
    planes.into_par_iter().map(fuse).collect()
}
