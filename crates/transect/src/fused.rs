//! Fusing the curves of one plane after another.

use crate::packed::PackedCurves;
use crate::pose_error::with_pose_errors;
use crate::seen_through::{Seen, Witness, without_seen_through};
use crate::{ReconstructError, Setup, Stage, Watch};
use rayon::prelude::*;
use std::borrow::Borrow;
use std::collections::BTreeMap;
use transect_fusion::{FusedPlane, fuse_plane};
use transect_geometry::{Curve, PlaneIndex};

/// The curves that each plane has from each view, in the order of the views.
pub(crate) type Observed = BTreeMap<PlaneIndex, Vec<PackedCurves>>;

/// What is known of a view besides its curves.
#[derive(Debug, Clone, Default)]
pub(crate) struct ViewFacts {
    /// The space that it looked through; `None` if it cannot tell, or nobody asks.
    pub witness: Option<Witness>,
    /// By how much its surface may be off, in the length unit, if registration told.
    pub surface_sigma: Option<f64>,
}

/// The fused curves of a plane.
pub(crate) struct Fused {
    pub index: PlaneIndex,
    pub plane: FusedPlane,
    /// Nodes that were left out, as more views looked through them than measured them.
    pub seen_through: usize,
    /// By how much the surfaces of its views may be off.
    pub surface_sigmas: Vec<Option<f64>>,
}

impl Fused {
    /// Fuses the curves of a plane. `facts` are those of each view.
    pub fn of(
        index: PlaneIndex,
        views: &[&[Curve]],
        facts: &[Option<&ViewFacts>],
        setup: &Setup,
    ) -> Self {
        let mut plane = fuse_plane(views, &setup.fusion);
        // A view that comes twice measured nothing new, so it has one vote, as in fusion.
        let counts = |k: &usize| !views[*k].is_empty() && !views[..*k].contains(&views[*k]);
        let places = (0..views.len()).filter(counts);
        let facts: Vec<Option<&ViewFacts>> = places.filter_map(|k| facts.get(k).copied()).collect();
        let witnesses: Vec<&Witness> =
            facts.iter().flatten().filter_map(|facts| facts.witness.as_ref()).collect();
        let frame = setup.planes.frame(index);
        let Seen { curves, left_out } = without_seen_through(plane.curves, &frame, &witnesses);
        let surface_sigmas: Vec<_> =
            facts.iter().map(|facts| facts.as_ref()?.surface_sigma).collect();
        plane.curves = curves;
        Self { index, plane, seen_through: left_out, surface_sigmas }
    }

    /// The plane with the errors of poses in its nodes. Neighbouring planes share these errors, so
    /// planes are compared without them.
    pub fn with_pose_errors(mut self) -> Self {
        let curves = std::mem::take(&mut self.plane.curves);
        self.plane.curves = with_pose_errors(curves, &self.surface_sigmas);
        self
    }
}

/// Fuses planes in parallel, with the facts of each view. The curves of a plane that is given
/// away are freed with its fusion.
pub(crate) fn fuse<V: Borrow<Vec<PackedCurves>> + Send>(
    planes: Vec<(PlaneIndex, V)>,
    setup: &Setup,
    watch: &dyn Watch,
    facts: &[Option<&ViewFacts>],
) -> Result<Vec<Fused>, ReconstructError> {
    watch.begin(Stage::Planes, planes.len());
    let fuse = |(index, views): (PlaneIndex, V)| {
        if watch.cancelled() {
            return Err(ReconstructError::Cancelled);
        }
        let curves: Vec<Vec<Curve>> = views.borrow().iter().map(PackedCurves::curves).collect();
        drop(views);
        let curves: Vec<&[Curve]> = curves.iter().map(Vec::as_slice).collect();
        let fused = Fused::of(index, &curves, facts, setup);
        watch.step(Stage::Planes);
        Ok(fused)
    };
    planes.into_par_iter().map(fuse).collect()
}
