//! The stage before curves: the poses of all views, compared through coarse copies of the images.
//!
//! **Problem.** Poses can only be compared between all views at once, and the images of all views
//! may not fit into memory.
//!
//! **Steps.**
//! 1. Every view is loaded and dropped; its [`CoarseView`] stays ([`coarse_views`]). Poses that
//!    agree under another convention, images in another order, and pixels that hold another length
//!    are recognised ([`find_reading`]).
//! 2. The poses are refined together ([`refine`]), if that is asked for.
//!    Poses that need another reading even then stay as given.
//! 3. What still contradicts is found ([`judge`]).
//! 4. The pipeline loads every view again and models it at its refined pose.

mod along_faces;
mod messages;
mod regions;

use crate::timed_view::TimedView;
use crate::{Posed, ReconstructError, Setup, Stage, ViewSource, Watch};
use along_faces::along_faces;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeSet;
use transect_device::View;
use transect_geometry::{LengthUnit, PlaneIndex};
use transect_register::{
    CoarseView, Finding, FoundReading, Judgement, PosePrior, PoseRefinement, Reading,
    RefineOptions, RefinedPose, StatedPoses, find_reading, judge, refine,
};

/// The poses of a run: what contradicts, and how they were refined.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PoseReport {
    /// The unit of its lengths.
    pub unit: LengthUnit,
    /// Another reading of the poses or images under which the views agree, where they contradict.
    #[serde(rename = "explanation", skip_serializing_if = "Option::is_none")]
    pub found_reading: Option<FoundReading>,
    /// The contradictions at the refined poses, or at the given ones if they were kept.
    pub judgement: Judgement,
    /// The refined poses; `None` if the given ones were kept, as those are that another convention
    /// explains.
    #[serde(flatten)]
    pub refinement: Option<PoseRefinement>,
    /// How far the poses are wrong by the images, if what was stated of them held them as given.
    #[serde(skip)]
    pub(crate) prior_by_images: Option<PosePrior>,
    /// Whether the views are those of a store, whose images keep the errors of their cameras.
    #[serde(skip)]
    pub(crate) in_store: bool,
    /// Planes along faces of the views, which say nothing of poses; none of refined poses.
    #[serde(skip)]
    pub(crate) along_faces: BTreeSet<PlaneIndex>,
}

/// Coarse copies of all views, in their order; each view is dropped as soon as it is copied.
///
/// # Errors
/// [`ReconstructError`] names the first view, in the given order, that cannot be loaded or whose
/// prior cannot be used.
fn coarse_views<S: ViewSource>(
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
        Ok(copied?.with_prior(source.pose_prior())?)
    };
    let copies: Vec<Result<CoarseView, _>> = sources.par_iter().map(copy).collect();
    copies.into_iter().collect()
}

/// Coarse copies of all views, their images read in another order of pixels, or their pixels as
/// another length; `None` if a view cannot be. Copies that are compared with others are to be of
/// the same kind.
pub(crate) fn reread<S: ViewSource>(
    sources: &[S],
    reading: Reading,
    of_view: fn(&View) -> CoarseView,
) -> Option<Vec<CoarseView>> {
    let copy = |source: &S| match reading {
        Reading::Image(order) => Some(of_view(&source.load_in(order)?.ok()?.view)),
        Reading::PixelsHold(scale) => Some(of_view(&source.load().ok()?.view.reread(scale)?)),
        Reading::Pose(_) | Reading::AsStated | Reading::Distances(_) => None,
    };
    sources.par_iter().map(copy).collect()
}

/// The poses of all views as their files state them; `None` if they were read so.
pub(crate) fn stated<S: ViewSource>(sources: &[S]) -> Option<StatedPoses> {
    let (reading, _) = sources.first()?.stated_pose()?;
    let poses =
        sources.iter().map(|source| Some(source.stated_pose()?.1)).collect::<Option<_>>()?;
    Some(StatedPoses { reading, poses })
}

impl PoseReport {
    /// Judges the poses of views, after refining them if there are options for that.
    ///
    /// # Errors
    /// [`ReconstructError`] names the first view, in the given order, that cannot be loaded or
    /// whose prior cannot be used. It is also an error if the prior in the options cannot be used.
    pub fn new<S: ViewSource>(
        sources: &[S],
        options: Option<&RefineOptions>,
        unit: LengthUnit,
        watch: &dyn Watch,
    ) -> Result<Self, ReconstructError> {
        let mut copies = coarse_views(sources, watch)?;
        let again = |reading| reread(sources, reading, CoarseView::new);
        let stated = stated(sources);
        let mut found_reading = find_reading(&copies, stated.as_ref(), again);
        let options = options.filter(|_| !are_unregistered(&copies));
        let mut refinement = options.map(|options| refine(&copies, options)).transpose()?;
        let prior_by_images = refinement.as_ref().and_then(|r| r.prior_by_images);
        if let Some(refinement) = &refinement {
            let poses = &refinement.poses;
            let refined = |(copy, pose): (CoarseView, &RefinedPose)| {
                let copy = copy.with_pose(pose.world_from_sensor);
                // Errors of a camera hide contradictions between its views.
                match &pose.depth_offsets {
                    Some(offsets) => copy.corrected(offsets),
                    None => copy,
                }
            };
            copies = copies.into_iter().zip(poses).map(refined).collect();
        }
        let mut judgement = judge(&copies);
        if refinement.is_some() && judgement.all_contradict() {
            // Such poses are no beginning for a refinement.
            (refinement, copies) = (None, coarse_views(sources, watch)?);
            judgement = judge(&copies);
        }
        if let (Some(refined), Some(found)) = (&refinement, &found_reading) {
            // Few views that are a little off may look misread: refined, they agree, and need no
            // other reading. Views that were misread are wrong by more than a refinement finds.
            let again = find_reading(&copies, stated.as_ref(), again);
            // An object that moved contradicts at right poses, too.
            let agree = judgement.findings.iter().all(|f| matches!(f, Finding::Region(_)));
            let explained = !refined.bends_poses() && found.is_matched_by(&copies);
            if again.is_none() && agree && explained {
                found_reading = None;
            } else {
                found_reading = again.or(found_reading);
                (refinement, copies) = (None, coarse_views(sources, watch)?);
                judgement = judge(&copies);
            }
        }
        let (in_store, along_faces) = (false, BTreeSet::new());
        Ok(Self {
            unit,
            found_reading,
            judgement,
            refinement,
            prior_by_images,
            in_store,
            along_faces,
        })
    }

    /// Judges the given poses by copies of the views. `reread` makes copies of images that are read
    /// in another way.
    pub(crate) fn of_given(
        copies: Vec<CoarseView>,
        stated: Option<&StatedPoses>,
        reread: impl Fn(Reading) -> Option<Vec<CoarseView>>,
        setup: &Setup,
    ) -> Self {
        Self {
            unit: setup.unit,
            found_reading: find_reading(&copies, stated, reread),
            judgement: judge(&copies),
            refinement: None,
            prior_by_images: None,
            in_store: false,
            along_faces: along_faces(&copies, &setup.planes),
        }
    }

    /// Whether anything contradicts.
    pub fn is_doubtful(&self) -> bool {
        self.found_reading.is_some() || !self.judgement.findings.is_empty()
    }

    /// The views at their refined poses, without the errors of their depth cameras; none if the
    /// given poses were kept.
    pub fn posed<'a, S: ViewSource>(&self, sources: &'a [S]) -> Vec<Posed<'a, S>> {
        self.refinement.iter().flat_map(|refinement| posed(refinement, sources)).collect()
    }
}

/// Whether all views have one pose, and contradict each other at it. Refined all the same, four
/// stations turned by 18 to 27 degrees, to where they still contradicted.
fn are_unregistered(copies: &[CoarseView]) -> bool {
    let poses = copies.iter().map(CoarseView::world_from_sensor);
    poses.clone().zip(poses.skip(1)).all(|(a, b)| a == b) && judge(copies).all_contradict()
}

fn posed<'a, S: ViewSource>(refinement: &PoseRefinement, sources: &'a [S]) -> Vec<Posed<'a, S>> {
    let posed = sources.iter().zip(&refinement.poses).map(|(source, pose)| Posed {
        source,
        pose: pose.world_from_sensor,
        depth_offsets: pose.depth_offsets.clone(),
        surface_sigma: pose.surface_sigma_after(source.surface_sigma()),
    });
    posed.collect()
}
