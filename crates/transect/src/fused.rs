//! Fusing the curves of one plane after another.

use crate::{ReconstructError, Setup, Stage, Watch};
use rayon::prelude::*;
use std::collections::BTreeMap;
use transect_fusion::{Agreement, FusedPlane, fuse_and_compare};
use transect_geometry::{Curve, PlaneIndex};

/// The curves that each plane has from each view, in the order of the views.
pub(crate) type Observed<'a> = BTreeMap<PlaneIndex, Vec<&'a [Curve]>>;

/// The fused curves of a plane, and how its views agree.
pub(crate) struct Fused {
    pub index: PlaneIndex,
    pub plane: FusedPlane,
    pub agreement: Vec<Agreement>,
}

/// Fuses the asked planes in parallel; planes without curves are left out.
pub(crate) fn fuse(
    asked: &[PlaneIndex],
    observed: &Observed<'_>,
    setup: &Setup,
    watch: &dyn Watch,
) -> Result<Vec<Fused>, ReconstructError> {
    let asked: Vec<_> = asked.iter().filter_map(|k| observed.get_key_value(k)).collect();
    watch.begin(Stage::Planes, asked.len());
    let fuse = |&(index, views): &(&PlaneIndex, &Vec<&[Curve]>)| {
        if watch.cancelled() {
            return Err(ReconstructError::Cancelled);
        }
        let (plane, agreement) = fuse_and_compare(views, &setup.fusion);
        watch.step(Stage::Planes);
        Ok(Fused { index: *index, plane, agreement })
    };
    asked.par_iter().map(fuse).collect()
}
