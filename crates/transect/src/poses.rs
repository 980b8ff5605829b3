//! The stage before curves: the poses of all views, compared through coarse copies of the images.
//!
//! **Problem.** Poses can only be compared between all views at once, and the images of all views
//! may not fit into memory.
//!
//! **Steps.**
//! 1. Every view is loaded and dropped; its [`CoarseView`] stays ([`coarse_views`]).
//! 2. The poses are refined together, see [`transect_register::refine`].
//! 3. The pipeline loads every view again and models it at its refined pose.

use crate::modelled_view::TimedView;
use crate::{Posed, ReconstructError, Stage, ViewSource, Watch};
use rayon::prelude::*;
use serde::Serialize;
use transect_geometry::LengthUnit;
use transect_register::{CoarseView, PoseOutcome, RefineOptions, RefinedPose, Refinement, refine};

/// The refined poses of a run.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct PoseReport {
    /// The poses of all views, in the order given.
    #[serde(flatten)]
    pub refinement: Refinement,
    /// The unit of its lengths.
    pub unit: LengthUnit,
}

/// Coarse copies of all views, in their order; each view is dropped as soon as it is copied.
///
/// # Errors
/// [`ReconstructError`] names the first view, in the given order, that cannot be loaded.
pub fn coarse_views<S: ViewSource>(
    sources: &[S],
    watch: &dyn Watch,
) -> Result<Vec<CoarseView>, ReconstructError> {
    if sources.is_empty() {
        return Err(ReconstructError::NoViews);
    }
    watch.begin(Stage::Poses, sources.len());
    let copy = |source: &S| {
        if watch.cancelled() {
            return Err(ReconstructError::Cancelled);
        }
        let copied = TimedView::load(source).map(|timed| CoarseView::new(&timed.loaded.view));
        watch.step(Stage::Poses);
        copied
    };
    let copies: Vec<Result<CoarseView, _>> = sources.par_iter().map(copy).collect();
    copies.into_iter().collect()
}

impl PoseReport {
    /// Refines the poses of views.
    ///
    /// # Errors
    /// As [`coarse_views`].
    pub fn refined<S: ViewSource>(
        sources: &[S],
        options: &RefineOptions,
        unit: LengthUnit,
        watch: &dyn Watch,
    ) -> Result<Self, ReconstructError> {
        Ok(Self { refinement: refine(&coarse_views(sources, watch)?, options), unit })
    }

    /// The views at their refined poses; `sources` are those whose poses were refined.
    pub fn posed<'a, S: ViewSource>(&self, sources: &'a [S]) -> Vec<Posed<'a, S>> {
        let poses = self.refinement.poses.iter().map(|pose| pose.world_from_sensor);
        sources.iter().zip(poses).map(|(source, pose)| Posed { source, pose }).collect()
    }

    /// Notes: how many views moved, and views whose pose nothing tells.
    pub fn notes(&self) -> Vec<String> {
        let poses = &self.refinement.poses;
        let moved = poses.iter().filter(|pose| pose.has_moved());
        let (count, all, unit) = (moved.clone().count(), poses.len(), self.unit);
        let most = |of: fn(&RefinedPose) -> f64| moved.clone().map(of).fold(0.0, f64::max);
        let (turn, shift) = (most(|p| p.rotation).to_degrees(), most(|p| p.translation));
        let mut notes = vec![match count {
            0 => format!("the poses of all {all} views stay as given"),
            _ => format!(
                "the poses of {count} of {all} views were refined, by up to {turn:.3}° and \
                 {shift:.4} {unit}"
            ),
        }];
        let alone = poses.iter().filter(|pose| pose.outcome == PoseOutcome::Alone);
        notes.extend(alone.map(|pose| {
            let name = &pose.view;
            format!("view {name} keeps its pose: no other view sees enough of the same surfaces")
        }));
        notes
    }

    /// Warnings: views that were far off, and views that agree with the others nowhere near.
    pub fn warnings(&self) -> Vec<String> {
        self.refinement.poses.iter().filter_map(|pose| self.warning(pose)).collect()
    }

    fn warning(&self, pose: &RefinedPose) -> Option<String> {
        let RefinedPose { view, rotation, translation, .. } = pose;
        let (turn, unit) = (rotation.to_degrees(), self.unit);
        match pose.outcome {
            PoseOutcome::BroughtBack => Some(format!(
                "view {view} was {turn:.2}° and {translation:.4} {unit} off, farther than the \
                 other views; it was brought back. Check where its pose comes from"
            )),
            PoseOutcome::Misplaced => Some(format!(
                "view {view} contradicts the others, and no nearby pose agrees with them; it keeps \
                 its pose. Correct the pose, or leave the view out with --views"
            )),
            PoseOutcome::Refined | PoseOutcome::Kept | PoseOutcome::Alone => None,
        }
    }
}
