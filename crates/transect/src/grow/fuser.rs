//! Fusing the planes of a store as in a run over all views, with counts for the report.

use crate::report::PlaneSummary;
use crate::{Setup, Stage, Watch};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use transect_fusion::{Agreement, FusedPlane, fuse_and_compare};
use transect_geometry::{Curve, PlaneIndex};
use transect_model::store::{Fuse, PlaneInputs, ViewId};

/// Fuses planes in parallel with the setup's method, and keeps the counts.
pub(super) struct Fuser<'a> {
    setup: &'a Setup,
    watch: &'a dyn Watch,
    seen: Mutex<Seen>,
}

#[derive(Default)]
struct Seen {
    summaries: BTreeMap<PlaneIndex, PlaneSummary>,
    agreements: BTreeMap<ViewId, Agreement>,
}

impl<'a> Fuser<'a> {
    pub fn new(setup: &'a Setup, watch: &'a dyn Watch) -> Self {
        Self { setup, watch, seen: Mutex::default() }
    }

    /// Announces the number of planes to the watcher.
    pub fn begin(&self, planes: usize) {
        self.watch.begin(Stage::Planes, planes);
    }

    /// How a view agrees with the others on the planes that were fused.
    pub fn agreement(&self, view: &ViewId) -> Agreement {
        self.seen().agreements.get(view).copied().unwrap_or_default()
    }

    /// The planes that were fused.
    pub fn summaries(&self) -> BTreeMap<PlaneIndex, PlaneSummary> {
        self.seen().summaries.clone()
    }

    fn seen(&self) -> MutexGuard<'_, Seen> {
        // Sums are changed under the lock, so they are sound even if another thread panicked.
        self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn remember(
        &self,
        plane: PlaneIndex,
        partials: &[(ViewId, Vec<Curve>)],
        fused: &FusedPlane,
        agreements: &[Agreement],
    ) {
        let mut seen = self.seen();
        seen.summaries.insert(plane, PlaneSummary::of_fused(fused));
        for ((view, _), agreement) in partials.iter().zip(agreements) {
            seen.agreements.entry(view.clone()).or_default().add(agreement);
        }
    }
}

impl Fuse for Fuser<'_> {
    fn fuse(&self, plane: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]) -> Vec<Curve> {
        let views: Vec<&[Curve]> = partials.iter().map(|(_, curves)| curves.as_slice()).collect();
        let (fused, agreement) = fuse_and_compare(&views, &self.setup.fusion);
        self.remember(plane, partials, &fused, &agreement);
        self.watch.step(Stage::Planes);
        fused.curves
    }

    fn fuse_planes(&self, planes: &[PlaneInputs]) -> Vec<Vec<Curve>> {
        planes.par_iter().map(|inputs| self.fuse(inputs.plane, &inputs.partials)).collect()
    }
}
