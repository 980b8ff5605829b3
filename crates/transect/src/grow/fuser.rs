//! Fusing the planes of a store as in a run over all views, with counts for the report.

use crate::report::PlaneSummary;
use crate::{Setup, Stage, Watch};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use transect_fusion::fuse_plane;
use transect_geometry::{Curve, PlaneIndex};
use transect_model::store::{Fuse, PlaneInputs, ViewId};

/// Fuses planes in parallel with the setup's method, and keeps the counts.
pub(super) struct Fuser<'a> {
    setup: &'a Setup,
    watch: &'a dyn Watch,
    summaries: Mutex<BTreeMap<PlaneIndex, PlaneSummary>>,
}

impl<'a> Fuser<'a> {
    pub fn new(setup: &'a Setup, watch: &'a dyn Watch) -> Self {
        Self { setup, watch, summaries: Mutex::default() }
    }

    /// Announces the number of planes to the watcher.
    pub fn begin(&self, planes: usize) {
        self.watch.begin(Stage::Planes, planes);
    }

    /// The planes that were fused.
    pub fn summaries(&self) -> BTreeMap<PlaneIndex, PlaneSummary> {
        self.lock().clone()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<PlaneIndex, PlaneSummary>> {
        // Each plane is one entry, so the map is sound even if another thread panicked.
        self.summaries.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Fuse for Fuser<'_> {
    fn fuse(&self, plane: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]) -> Vec<Curve> {
        let views: Vec<&[Curve]> = partials.iter().map(|(_, curves)| curves.as_slice()).collect();
        let fused = fuse_plane(&views, &self.setup.fusion);
        self.lock().insert(plane, PlaneSummary::of_fused(&fused));
        self.watch.step(Stage::Planes);
        fused.curves
    }

    fn fuse_planes(&self, planes: &[PlaneInputs]) -> Vec<Vec<Curve>> {
        planes.par_iter().map(|inputs| self.fuse(inputs.plane, &inputs.partials)).collect()
    }
}
