//! The report of a run: counts, notes and times.

use crate::evaluate::digits;
use crate::fused::Fused;
use crate::{PoseReport, RefinementReport};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;
use transect_device::{Note, median};
use transect_fusion::pairwise::GrowthCounts;
use transect_geometry::{Curve, LengthUnit, PlaneIndex, Point3};

/// A run's report. Lengths are in the model's length unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Report {
    /// One entry per view, in the order given.
    pub views: Vec<ViewReport>,
    /// Counts and lengths of the fusion.
    pub fusion: FusionReport,
    /// The refined poses, or what contradicts the given ones; `None` if nothing does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poses: Option<PoseReport>,
    /// The inserted planes with the reasons; `None` for runs without refinement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refinement: Option<RefinementReport>,
    /// Assumptions and repairs of the readers, and parts that they ignored.
    pub notes: Vec<Note>,
    /// Times of the stages. Not serialised, so that equal runs make equal reports.
    #[serde(skip)]
    pub timings: Timings,
}

impl Report {
    /// The report of a run. `views` are in the order in which their curves were fused.
    pub(crate) fn new(
        views: Vec<ViewReport>,
        notes: Vec<Note>,
        fused: &[Fused],
        timings: Timings,
    ) -> Self {
        let mut fusion = FusionReport::new(fused.iter());
        if views.len() < 2 {
            fusion.forget_comparisons();
        }
        Self { views, fusion, poses: None, refinement: None, notes, timings }
    }

    /// Adds the poses and their notes. Given poses that nothing contradicts leave only notes.
    pub(crate) fn set_poses(&mut self, poses: Option<PoseReport>, unit: LengthUnit) {
        self.notes.extend(poses.iter().flat_map(PoseReport::notes));
        if poses.iter().all(|poses| poses.refinement.is_none()) {
            let along_faces = poses.as_ref().map(|poses| &poses.along_faces);
            let note = self.fusion.note_if_views_err(along_faces.unwrap_or(&BTreeSet::new()), unit);
            self.notes.extend(note.map(Note::new));
        }
        self.poses = poses.filter(|poses| poses.refinement.is_some() || poses.is_doubtful());
    }

    /// Warnings for the user: views whose poses contradict those of the others.
    pub fn warnings(&self) -> Vec<String> {
        self.poses.iter().flat_map(PoseReport::warnings).collect()
    }
}

/// Counts of curved guides are 0 for straight ones, and spreads of single views. They are not
/// written then.
fn is_zero<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// The counts of one view.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ViewReport {
    /// Its name.
    pub name: String,
    /// Pixels of its image.
    pub pixels: usize,
    /// Pixels that are not missing.
    pub valid_pixels: usize,
    /// Valid pixels that were read: all, or those of every other row and column, where neighbours
    /// share most of their noise.
    pub read_pixels: usize,
    /// Lowest and highest station that its points can have. For a curved guide, the whole guide.
    #[serde(skip)]
    pub stations: [f64; 2],
    /// Lowest and highest coordinates of its points in the world; `None` without a curved guide.
    #[serde(skip)]
    pub corners: Option<[Point3; 2]>,
    /// Pixels that were read beyond the ends of a curved guide, which are left out.
    #[serde(skip_serializing_if = "is_zero")]
    pub beyond_guide_ends: usize,
    /// Pixels that were read so far from a curved guide that its planes may cross there, which are
    /// left out.
    #[serde(skip_serializing_if = "is_zero")]
    pub beyond_guide_reach: usize,
    /// Range noise, given or estimated.
    pub sigma: f64,
    /// Whether the noise was given.
    pub sigma_given: bool,
    /// Number of planes with curves of it; with refinement, among planes of the smallest interval.
    pub planes: usize,
    /// Its curves before fusion.
    pub curves: usize,
    /// Crossings of planes with unbroken pixel pairs: its nodes before fusion, and crossings that
    /// belong to no curve.
    pub crossings: usize,
    /// Pairs of neighbouring pixels, of those that were read, that were separated as range jumps.
    pub range_jumps: usize,
    /// Flying pixels: samples alone between the two surfaces of a range jump, which are left out.
    /// They are looked for where the image is smoothed.
    pub flying_pixels: usize,
    /// Missing pixels and outliers, of the pixels that are read, that took the mean of their
    /// neighbours. Images are filled where they are smoothed.
    pub filled_pixels: usize,
}

/// The fusion of all planes.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FusionReport {
    /// Planes with curves.
    pub planes: usize,
    /// Planes on which every curve is closed.
    pub planes_closed_only: usize,
    /// Curves.
    pub curves: usize,
    /// Closed curves among them.
    pub closed: usize,
    /// Nodes of the curves.
    pub nodes: usize,
    /// Length of all curves.
    pub length: f64,
    /// Nodes of all views before fusion.
    pub observations: usize,
    /// Candidate nodes that were dropped: beside a better curve, or in no curve.
    pub dropped: usize,
    /// Places where fused curves crossed or touched each other, before the last step of fusion
    /// resolved them.
    pub crossings_resolved: usize,
    /// Nodes of fused curves that were left out, as more views looked through them than measured
    /// them.
    pub seen_through: usize,
    /// Median over the planes of the measured spread between views (standard deviation); 0 for a
    /// single view.
    #[serde(skip_serializing_if = "is_zero")]
    pub spread: f64,
    /// Median over the planes of the part of the spread that each view errs by as a whole; 0 where
    /// noise explains the spread, and for a single view.
    #[serde(skip_serializing_if = "is_zero")]
    pub view_error: f64,
    /// Median over the planes of the views' own noise (standard deviation of a node).
    #[serde(skip)]
    pub noise: f64,
    /// Error and noise of the views on each plane that was fused in this run.
    #[serde(skip)]
    pub(crate) compared: BTreeMap<PlaneIndex, [f64; 2]>,
    /// Planes with curves that were fused in this run.
    #[serde(skip)]
    pub(crate) planes_fused: usize,
    /// Those of them whose standard deviations hold the noise of the pixels alone.
    #[serde(skip)]
    pub(crate) planes_noise_alone: usize,
    /// Median over the planes of the overlap threshold; 0 for a single view.
    #[serde(skip_serializing_if = "is_zero")]
    pub threshold: f64,
    /// Growth of the planes that `pairwise` fused in this run; `None` for `consensus`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub growth: Option<GrowthCounts>,
}

/// Error of the views, in their own noise, from which the user is told of it. Theory: noise alone
/// has none. Measured: 0.08 at most on 16 simulated sets with exact poses, 3.5 to 34 on those with
/// wrong poses or depths and on depth cameras. Doubled: drifting poses pass in silence.
const TOLD_NOISES: f64 = 2.0;

impl FusionReport {
    /// Sums up the planes.
    pub(crate) fn new<'a>(planes: impl Iterator<Item = &'a Fused>) -> Self {
        let summary = |fused: &Fused| (fused.index, PlaneSummary::of_fused(fused));
        Self::of(&planes.map(summary).collect())
    }

    pub(crate) fn of(by_plane: &BTreeMap<PlaneIndex, PlaneSummary>) -> Self {
        let planes = || by_plane.values();
        let median =
            |of: fn(&PlaneSummary) -> Option<f64>| median(planes().filter_map(of)).unwrap_or(0.0);
        let used = || planes().filter(|p| p.curves > 0);
        let compared = |(k, p): (&PlaneIndex, &PlaneSummary)| Some((*k, [p.view_error?, p.noise?]));
        Self {
            planes: used().count(),
            planes_closed_only: used().filter(|p| p.curves == p.closed).count(),
            curves: used().map(|p| p.curves).sum(),
            closed: used().map(|p| p.closed).sum(),
            nodes: used().map(|p| p.nodes).sum(),
            length: used().map(|p| p.length).sum(),
            observations: planes().map(|p| p.observations).sum(),
            dropped: planes().map(|p| p.dropped).sum(),
            crossings_resolved: planes().map(|p| p.crossings_resolved).sum(),
            seen_through: planes().map(|p| p.seen_through).sum(),
            spread: median(|p| p.spread),
            view_error: median(|p| p.view_error),
            noise: median(|p| p.noise),
            compared: by_plane.iter().filter_map(compared).collect(),
            planes_fused: used().filter(|p| p.sigma_is_noise_alone.is_some()).count(),
            planes_noise_alone: used().filter(|p| p.sigma_is_noise_alone == Some(true)).count(),
            threshold: median(|p| p.threshold),
            growth: planes().filter_map(|p| p.growth).reduce(|mut sum, plane| {
                sum.add(&plane);
                sum
            }),
        }
    }

    /// Without what only several views tell.
    pub(crate) fn forget_comparisons(&mut self) {
        (self.spread, self.view_error, self.threshold) = (0.0, 0.0, 0.0);
        self.compared.clear();
        self.planes_noise_alone = 0;
    }

    /// The note for views that lie farther from each other than their noise explains. The planes
    /// along faces say nothing of poses; if they alone err, the note says that.
    pub(crate) fn note_if_views_err(
        &self,
        along_faces: &BTreeSet<PlaneIndex>,
        unit: LengthUnit,
    ) -> Option<String> {
        let all = self.error_told(|_| true)?;
        let Some([error, noise]) = self.error_told(|plane| !along_faces.contains(plane)) else {
            return self.note_on_faces(all, along_faces, unit);
        };
        let left_out = match self.planes_noise_alone {
            0 => String::new(),
            planes => format!(
                ". On {planes} of {} planes the sigma of the nodes does not include this error",
                self.planes_fused
            ),
        };
        Some(format!(
            "the views lie {} {unit} off each other (standard deviation) where their own noise is \
             {} {unit}: their poses or their depths err. transect register estimates both, and so \
             does the setting `refine_poses` without a store{left_out}",
            digits(error),
            digits(noise)
        ))
    }

    /// Median error and noise of the views on some planes, if the user is to be told of them.
    fn error_told(&self, is_asked: impl Fn(&PlaneIndex) -> bool) -> Option<[f64; 2]> {
        let asked = || self.compared.iter().filter(|(plane, _)| is_asked(plane));
        let error = median(asked().map(|(_, [error, _])| *error))?;
        let noise = median(asked().map(|(_, [_, noise])| *noise))?;
        (error > TOLD_NOISES * noise && error > 0.0).then_some([error, noise])
    }

    /// The note for views that lie off each other on planes along faces alone.
    fn note_on_faces(
        &self,
        [error, noise]: [f64; 2],
        along_faces: &BTreeSet<PlaneIndex>,
        unit: LengthUnit,
    ) -> Option<String> {
        let mut along = self.compared.keys().filter(|plane| along_faces.contains(plane));
        let (first, others) = (along.next()?, along.count());
        let planes = match others {
            0 => format!("plane {first} runs"),
            others => format!("plane {first} and {others} more run"),
        };
        Some(format!(
            "{planes} along a face, nearer to it than the pixels are apart. \
             Curves cut the corners at its edges there: the views lie {} {unit} off each other \
             (standard deviation) where their own noise is {} {unit}. Move the planes away from \
             the face, by the setting `offset`",
            digits(error),
            digits(noise)
        ))
    }
}

/// The share of one plane in the report.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PlaneSummary {
    curves: usize,
    closed: usize,
    nodes: usize,
    length: f64,
    observations: usize,
    dropped: usize,
    crossings_resolved: usize,
    seen_through: usize,
    /// `None` for a plane that was fused in an earlier run, as the next four.
    spread: Option<f64>,
    view_error: Option<f64>,
    sigma_is_noise_alone: Option<bool>,
    noise: Option<f64>,
    threshold: Option<f64>,
    growth: Option<GrowthCounts>,
}

impl PlaneSummary {
    pub(crate) fn of_fused(fused: &Fused) -> Self {
        let Fused { plane, seen_through, .. } = fused;
        Self {
            observations: plane.counts.observations,
            dropped: plane.counts.dropped,
            crossings_resolved: plane.counts.crossings,
            seen_through: *seen_through,
            spread: Some(plane.spread),
            view_error: Some(plane.view_error),
            sigma_is_noise_alone: Some(plane.sigma_is_noise_alone),
            noise: Some(plane.noise),
            threshold: Some(plane.threshold),
            growth: plane.growth,
            ..Self::of_curves(plane.curves.iter())
        }
    }

    /// Of a plane that was fused earlier.
    pub(crate) fn of_curves<'a>(curves: impl Iterator<Item = &'a Curve>) -> Self {
        curves.fold(Self::default(), |sum, curve| Self {
            curves: sum.curves + 1,
            closed: sum.closed + usize::from(curve.is_closed()),
            nodes: sum.nodes + curve.nodes().len(),
            length: sum.length + curve.length(),
            ..sum
        })
    }
}

/// Times of the stages.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[non_exhaustive]
pub struct Timings {
    /// Reading all views and refining their poses, or judging those of a store, in elapsed time.
    pub poses: Duration,
    /// Reading and modelling all views, in elapsed time.
    pub views: Duration,
    /// Reading, summed over the threads.
    pub reading: Duration,
    /// Finding curves, summed over the threads.
    pub modelling: Duration,
    /// Fusing all planes, in elapsed time.
    pub fusion: Duration,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_whose_sigma_leaves_the_views_errors_out_are_told() {
        let plane = |view_error: f64| PlaneSummary {
            curves: 1,
            view_error: Some(view_error),
            sigma_is_noise_alone: Some(view_error == 0.0),
            noise: Some(0.001),
            ..PlaneSummary::default()
        };
        let earlier = PlaneSummary { curves: 1, ..PlaneSummary::default() };
        let of = |planes: &[PlaneSummary]| {
            FusionReport::of(&(0..).map(PlaneIndex).zip(planes.iter().copied()).collect())
        };
        let note_on = |planes: &[PlaneSummary], along_faces: &[i64]| {
            let along_faces = along_faces.iter().copied().map(PlaneIndex).collect();
            of(planes).note_if_views_err(&along_faces, LengthUnit::Metre).unwrap_or_default()
        };
        let note = |planes: &[PlaneSummary]| note_on(planes, &[]);
        assert!(
            note(&[plane(0.01), plane(0.02)])
                .ends_with("so does the setting `refine_poses` without a store")
        );
        let told = note(&[plane(0.01), plane(0.0), plane(0.02), earlier]);
        assert!(told.contains("On 1 of 3 planes"), "{told}");
        assert_eq!(note(&[plane(0.001), plane(0.0)]), "");
        let mut of_one_view = of(&[plane(0.0)]);
        of_one_view.forget_comparisons();
        assert_eq!(of_one_view.planes_noise_alone, 0);
        let of_face = note_on(&[plane(0.01), plane(0.02), plane(0.001)], &[0, 1]);
        assert!(of_face.starts_with("plane 0 and 1 more run along a face"), "{of_face}");
        let poses = note_on(&[plane(0.01), plane(0.02), plane(0.02)], &[0]);
        assert!(poses.contains("their poses or their depths err"), "{poses}");
        assert_eq!(note_on(&[plane(0.01), plane(0.001), plane(0.001)], &[0]), "");
    }
}
