//! What happened in a run.

use crate::RefinementReport;
use crate::fused::Fused;
use serde::Serialize;
use std::time::Duration;
use transect_fusion::{Agreement, FusedPlane};
use transect_geometry::Curve;

/// A run's report. Lengths are in the model's length unit.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// One entry per view, in the order given.
    pub views: Vec<ViewReport>,
    /// What fusion did.
    pub fusion: FusionReport,
    /// Where planes were inserted and why; `None` if that was not asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refinement: Option<RefinementReport>,
    /// What readers assumed, repaired or ignored.
    pub notes: Vec<String>,
    /// Where the time went. Not serialised, so that equal runs make equal reports.
    #[serde(skip)]
    pub timings: Timings,
}

impl Report {
    /// The report of views in the order of their curves, with how they agree with each other.
    pub(crate) fn new(
        mut views: Vec<ViewReport>,
        mut notes: Vec<String>,
        fused: &[Fused],
        timings: Timings,
    ) -> Self {
        let mut agreements = vec![Agreement::default(); views.len()];
        for plane in fused {
            agreements.iter_mut().zip(&plane.agreement).for_each(|(sum, a)| sum.add(a));
        }
        views.iter_mut().zip(&agreements).for_each(|(view, a)| view.set_agreement(a));
        if views.len() > 1 {
            notes.extend(views.iter().filter_map(ViewReport::note_if_alone));
        }
        let fusion = FusionReport::new(fused.iter().map(|f| &f.plane));
        Self { views, fusion, refinement: None, notes, timings }
    }

    /// What the user should look at: views whose curves contradict those of the others.
    pub fn warnings(&self) -> Vec<String> {
        let contradicted = self.views.iter().filter(|v| v.contradicted);
        let warning = |v: &ViewReport| {
            let total = v.samples_close_to_other_views + v.samples_abreast_of_other_views;
            let share = 100.0 * v.samples_abreast_of_other_views as f64 / total as f64;
            format!(
                "view {} contradicts the others: {share:.0} % of its overlap with them lies apart; \
                 is its pose right, and its convention (sensor to world, quaternion not conjugated)?",
                v.name
            )
        };
        contradicted.map(warning).collect()
    }
}

/// Whether nothing was counted: counts of curved guides are not written for straight ones.
fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// What became of one view.
#[derive(Debug, Clone, Serialize)]
pub struct ViewReport {
    /// Its name.
    pub name: String,
    /// Pixels of its image.
    pub pixels: usize,
    /// Pixels that are not missing.
    pub valid_pixels: usize,
    /// Lowest and highest station that its points can have; along a curved guide those of all of it.
    #[serde(skip)]
    pub stations: [f64; 2],
    /// Of these, pixels beyond the ends of a curved guide, which are left out.
    #[serde(skip_serializing_if = "is_zero")]
    pub beyond_guide_ends: usize,
    /// Pixels so far from a curved guide that its planes may cross there, which are left out.
    #[serde(skip_serializing_if = "is_zero")]
    pub beyond_guide_reach: usize,
    /// Range noise, given or estimated.
    pub sigma: f64,
    /// Whether the noise was given.
    pub sigma_given: bool,
    /// Planes it has curves on; with refinement, of those with the smallest interval.
    pub planes: usize,
    /// Its curves before fusion.
    pub curves: usize,
    /// Planes crossing its unbroken pixel pairs: its nodes before fusion, and those that made no curve.
    pub crossings: usize,
    /// Pairs of neighbouring pixels that were taken apart as range jumps.
    pub range_jumps: usize,
    /// Samples with another view's curve right beside them.
    pub samples_close_to_other_views: u64,
    /// Samples with another view's curve of the same direction a little farther off.
    pub samples_abreast_of_other_views: u64,
    /// Whether the latter outnumber the former.
    pub contradicted: bool,
}

impl ViewReport {
    pub(crate) fn set_agreement(&mut self, agreement: &Agreement) {
        self.samples_close_to_other_views = agreement.close;
        self.samples_abreast_of_other_views = agreement.abreast;
        self.contradicted = agreement.is_contradicted();
    }

    /// What to note on a view that shares no ground with any other, of whose pose nothing can be said.
    pub(crate) fn note_if_alone(&self) -> Option<String> {
        let alone = self.samples_close_to_other_views + self.samples_abreast_of_other_views == 0;
        alone.then(|| {
            let name = &self.name;
            format!("view {name} overlaps no other view: nothing tells whether its pose is right")
        })
    }
}

/// What fusion did over all planes.
#[derive(Debug, Clone, Default, Serialize)]
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
    /// Nodes of all views that went in.
    pub observations: usize,
    /// Candidate nodes that lay beside a better curve or made none.
    pub dropped: usize,
    /// Median over the planes of the measured spread between views (standard deviation).
    pub spread: f64,
    /// Median over the planes of the overlap threshold.
    pub threshold: f64,
}

impl FusionReport {
    /// Sums up the planes.
    pub fn new<'a>(planes: impl Iterator<Item = &'a FusedPlane>) -> Self {
        Self::of(&planes.map(PlaneSummary::of_fused).collect::<Vec<_>>())
    }

    pub(crate) fn of(planes: &[PlaneSummary]) -> Self {
        let used = || planes.iter().filter(|p| p.curves > 0);
        Self {
            planes: used().count(),
            planes_closed_only: used().filter(|p| p.curves == p.closed).count(),
            curves: used().map(|p| p.curves).sum(),
            closed: used().map(|p| p.closed).sum(),
            nodes: used().map(|p| p.nodes).sum(),
            length: used().map(|p| p.length).sum(),
            observations: planes.iter().map(|p| p.observations).sum(),
            dropped: planes.iter().map(|p| p.dropped).sum(),
            spread: median(planes.iter().filter_map(|p| p.spread)),
            threshold: median(planes.iter().filter_map(|p| p.threshold)),
        }
    }
}

/// What a plane adds to the report.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PlaneSummary {
    curves: usize,
    closed: usize,
    nodes: usize,
    length: f64,
    observations: usize,
    dropped: usize,
    /// Unknown of a plane that was fused earlier, as is the threshold.
    spread: Option<f64>,
    threshold: Option<f64>,
}

impl PlaneSummary {
    pub(crate) fn of_fused(plane: &FusedPlane) -> Self {
        Self {
            observations: plane.counts.observations,
            dropped: plane.counts.dropped,
            spread: Some(plane.spread),
            threshold: Some(plane.threshold),
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

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Where the time went.
#[derive(Debug, Clone, Copy, Default)]
pub struct Timings {
    /// Reading and modelling all views, by the clock.
    pub views: Duration,
    /// Reading, summed over the threads.
    pub reading: Duration,
    /// Finding curves, summed over the threads.
    pub modelling: Duration,
    /// Fusing all planes, by the clock.
    pub fusion: Duration,
}
