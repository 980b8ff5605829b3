//! Fusing the planes of a store as in a run over all views, with counts for the report.

use super::kept_image::KeptImage;
use crate::fused::{Fused, ViewFacts};
use crate::report::PlaneSummary;
use crate::seen_through::Witness;
use crate::{Setup, Stage, Watch};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError, RwLock};
use transect_geometry::{Curve, PlaneIndex};
use transect_model::store::{Fuse, PlaneInputs, ViewCopy, ViewDescription, ViewId};

/// Fuses planes in parallel with the setup's method, and keeps the counts.
pub(super) struct Fuser<'a> {
    setup: &'a Setup,
    watch: &'a dyn Watch,
    summaries: Mutex<BTreeMap<PlaneIndex, PlaneSummary>>,
    facts: RwLock<BTreeMap<ViewId, ViewFacts>>,
}

// Planes and facts are one entry each, so both maps are sound even if a thread panicked.
impl<'a> Fuser<'a> {
    pub fn new(setup: &'a Setup, watch: &'a dyn Watch) -> Self {
        Self { setup, watch, summaries: Mutex::default(), facts: RwLock::default() }
    }

    /// Announces the number of planes to the watcher.
    pub fn begin(&self, planes: usize) {
        self.watch.begin(Stage::Planes, planes);
    }

    /// The planes that were fused.
    pub fn summaries(&self) -> BTreeMap<PlaneIndex, PlaneSummary> {
        self.summaries.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Fuse for Fuser<'_> {
    fn meet(&self, view: &ViewDescription, copy: Option<ViewCopy>) {
        let kept = copy.as_ref().and_then(KeptImage::read);
        let surface_sigma = kept.as_ref().and_then(|kept| kept.surface_sigma().now());
        let free = kept.filter(|_| self.setup.free_space).and_then(KeptImage::free_space);
        let witness = free.map(|free| Witness::new(&view.world_from_sensor, free));
        let mut facts = self.facts.write().unwrap_or_else(PoisonError::into_inner);
        facts.insert(view.id.clone(), ViewFacts { witness, surface_sigma });
    }

    fn fuse(&self, plane: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]) -> Vec<Curve> {
        let views: Vec<&[Curve]> = partials.iter().map(|(_, curves)| curves.as_slice()).collect();
        let met = self.facts.read().unwrap_or_else(PoisonError::into_inner);
        let facts: Vec<_> = partials.iter().map(|(id, _)| met.get(id)).collect();
        let fused = Fused::of(plane, &views, &facts, self.setup).with_pose_errors();
        let summary = PlaneSummary::of_fused(&fused);
        self.summaries.lock().unwrap_or_else(PoisonError::into_inner).insert(plane, summary);
        self.watch.step(Stage::Planes);
        fused.plane.curves
    }

    fn fuse_planes(&self, planes: &[PlaneInputs]) -> Vec<Vec<Curve>> {
        planes.par_iter().map(|inputs| self.fuse(inputs.plane, &inputs.partials)).collect()
    }
}
