//! From a view to its curves on every plane it crosses.

use crate::fingerprint::fingerprint_of_rows;
use crate::fused::ViewFacts;
use crate::packed::PackedCurves;
use crate::report::ViewReport;
use crate::seen_through::Witness;
use crate::timed_view::TimedView;
use crate::{LoadedView, ReconstructError, Setup, Stage, ViewSource, Watch};
use rayon::prelude::*;
use std::time::{Duration, Instant};
use transect_device::{Isometry3, Note, View};
use transect_geometry::{Curve, CurvedGuide, Guide, LengthUnit, PlaneFamily, PlaneIndex, Point3};
use transect_partial::{PartialCounts, partial_model};
use transect_register::CoarseView;

/// The curves of a view and its part of the report. The view itself is dropped.
pub(crate) struct ModelledView<C = PackedCurves> {
    pub world_from_sensor: Isometry3,
    /// A hash of the image; empty where nothing compares it.
    pub fingerprint: String,
    pub sigma: Option<f64>,
    /// The planes it crosses, sorted, each with its curves.
    pub planes: Vec<(PlaneIndex, C)>,
    /// Number of nodes of these curves.
    pub nodes: u64,
    pub notes: Vec<Note>,
    pub report: ViewReport,
    pub reading: Duration,
    pub modelling: Duration,
}

impl TimedView {
    /// Finds the curves of the view, which the report calls `name`.
    pub fn model(
        self,
        name: &str,
        setup: &Setup,
    ) -> Result<ModelledView<Vec<Curve>>, ReconstructError> {
        let started = Instant::now();
        let LoadedView { view, mut notes } = self.loaded;
        let partial = partial_model(&view, &setup.planes, &setup.partial)
            .map_err(|e| ReconstructError::Partial { view: name.to_owned(), source: e })?;
        notes.extend(partial.notes);
        let modelling = started.elapsed();
        let curves = partial.planes.into_iter().map(|found| {
            let curves = found.curves.into_iter().map(|c| c.curve).collect();
            (found.plane, curves)
        });
        let planes: Vec<(PlaneIndex, Vec<Curve>)> = curves.collect();
        let nodes = planes.iter().flat_map(|(_, curves)| curves).map(|c| c.nodes().len() as u64);
        Ok(ModelledView {
            nodes: nodes.sum(),
            world_from_sensor: *view.world_from_sensor(),
            fingerprint: String::new(),
            sigma: view.sigma(),
            report: view_report(name, &view, setup, &partial.counts, &planes),
            planes,
            notes,
            reading: self.reading,
            modelling,
        })
    }
}

impl ModelledView<Vec<Curve>> {
    fn packed(self) -> ModelledView {
        let planes = self.planes.into_iter();
        let planes = planes.map(|(plane, curves)| (plane, PackedCurves::new(&curves))).collect();
        let Self { world_from_sensor, fingerprint, sigma, nodes, .. } = self;
        let Self { notes, report, reading, modelling, .. } = self;
        ModelledView {
            world_from_sensor,
            fingerprint,
            sigma,
            planes,
            nodes,
            notes,
            report,
            reading,
            modelling,
        }
    }
}

/// What is kept of the images of views besides their curves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wanted {
    /// Copies, by which their poses are judged.
    pub copies: bool,
    /// The space that they looked through.
    pub free_space: bool,
}

impl Wanted {
    /// The same of so many views; a single view can be compared with none.
    pub fn of_several(self, views: usize) -> Self {
        let several = views > 1;
        Self { copies: self.copies && several, free_space: self.free_space && several }
    }
}

/// The views of a run: the curves of each, and what is kept of its image.
pub(crate) struct Modelled {
    pub views: Vec<ModelledView>,
    /// `None` if they are not wanted.
    pub copies: Option<Vec<CoarseView>>,
    /// One for each view.
    pub facts: Vec<ViewFacts>,
}

/// Loads and models all views in parallel, with what is wanted of their images. If several fail,
/// the error is that of the first in order, whichever thread was first.
pub(crate) fn model_views<S: ViewSource>(
    sources: &[S],
    setup: &Setup,
    watch: &dyn Watch,
    wanted: Wanted,
) -> Result<Modelled, ReconstructError> {
    if sources.is_empty() {
        return Err(ReconstructError::NoViews);
    }
    watch.begin(Stage::Views, sources.len());
    let model = |source: &S| {
        if watch.cancelled() {
            return Err(ReconstructError::Cancelled);
        }
        let modelled = TimedView::load(source).and_then(|timed| {
            let view = &timed.loaded.view;
            let surface_sigma = surface_sigma(source, view)?;
            let copy = wanted.copies.then(|| CoarseView::quick(view));
            let witness = wanted.free_space.then(|| Witness::of(view)).flatten();
            let facts = ViewFacts { witness, surface_sigma };
            let fingerprint = fingerprint_of_rows(view);
            let modelled = timed.model(source.name(), setup)?.packed();
            Ok((ModelledView { fingerprint, ..modelled }, copy, facts))
        });
        watch.step(Stage::Views);
        modelled
    };
    let modelled: Vec<Result<_, _>> = sources.par_iter().map(model).collect();
    let (mut views, mut copies, mut facts) = (Vec::new(), Vec::new(), Vec::new());
    for modelled in modelled {
        let (view, copy, of_view) = modelled?;
        views.push(view);
        copies.push(copy);
        facts.push(of_view);
    }
    Ok(Modelled { views, copies: copies.into_iter().collect(), facts })
}

/// By how much the surface of a view may be off, over its farthest value, beyond which the number
/// is wrong. No unit. Chosen by hand: a view that nothing holds may be off by ten times that.
/// Doubled, a number in another unit passes more often.
const LARGEST_SIGMA: f64 = 100.0;

/// By how much the surface of a view may be off, if its source states it.
pub(crate) fn surface_sigma<S: ViewSource>(
    source: &S,
    view: &View,
) -> Result<Option<f64>, ReconstructError> {
    let farthest = view.image().extremes().map_or(f64::INFINITY, |(_, far)| f64::from(far.abs()));
    match source.surface_sigma() {
        Some(sigma) if !(0.0..=LARGEST_SIGMA * farthest).contains(&sigma) => {
            let view = source.name().to_owned();
            Err(ReconstructError::SurfaceSigma { view, sigma, farthest })
        }
        stated => Ok(stated),
    }
}

fn view_report(
    name: &str,
    view: &View,
    setup: &Setup,
    counts: &PartialCounts,
    planes: &[(PlaneIndex, Vec<Curve>)],
) -> ViewReport {
    ViewReport {
        name: name.to_owned(),
        pixels: view.image().size().pixels(),
        valid_pixels: view.image().valid_count(),
        read_pixels: counts.read,
        stations: stations(view, &setup.planes),
        corners: setup.planes.guide().curved().and_then(|_| corners(view)),
        beyond_guide_ends: counts.beyond_ends,
        beyond_guide_reach: counts.beyond_reach,
        sigma: counts.sigma,
        sigma_given: view.sigma().is_some(),
        planes: planes.len(),
        curves: planes.iter().map(|(_, curves)| curves.len()).sum(),
        crossings: counts.crossings,
        range_jumps: counts.jumps,
        flying_pixels: counts.flying,
        filled_pixels: counts.filled,
    }
}

/// Lowest and highest station that points of a view can have; for a curved guide, all of it.
fn stations(view: &View, planes: &PlaneFamily) -> [f64; 2] {
    let direction = match planes.guide() {
        Guide::Straight(guide) => guide.direction(),
        Guide::Curved(guide) => return [0.0, guide.length()],
    };
    let pose = view.world_from_sensor();
    let in_sensor = pose.rotation.inverse_transform_vector(&direction);
    let Some((near, far)) = view.image().extremes() else { return [0.0; 2] };
    let (low, high) = view.frame().extent(&in_sensor, f64::from(near), f64::from(far));
    let sensor = direction.dot(&pose.translation.vector);
    [sensor + low, sensor + high]
}

/// Lowest and highest coordinates of a view's points in the world; `None` without points.
fn corners(view: &View) -> Option<[Point3; 2]> {
    let points = view.image().size().all_pixels().filter_map(|pixel| view.point_in_sensor(pixel));
    extent(points.map(|point| view.world_from_sensor() * point).map(|point| [point; 2]))
}

/// Lowest and highest coordinates of some boxes; `None` without one.
fn extent(boxes: impl Iterator<Item = [Point3; 2]>) -> Option<[Point3; 2]> {
    boxes.reduce(|a, b| [a[0].inf(&b[0]), a[1].sup(&b[1])])
}

/// The error of a run in which no view has a curve, from the reports of all views.
pub(crate) fn no_curves<'a>(
    reports: impl ExactSizeIterator<Item = &'a ViewReport> + Clone,
    setup: &Setup,
) -> ReconstructError {
    let views = reports.len();
    let crossings = reports.clone().map(|v| v.crossings).sum();
    if crossings > 0 {
        return ReconstructError::NoCurves { views, crossings };
    }
    if let Some(guide) = setup.planes.guide().curved() {
        return off_guide(reports, guide, setup.unit);
    }
    let low = reports.clone().map(|v| v.stations[0]).fold(f64::INFINITY, f64::min);
    let high = reports.map(|v| v.stations[1]).fold(f64::NEG_INFINITY, f64::max);
    let planes = &setup.planes;
    let has_plane = planes.station(planes.first_at_or_above(low)) <= high;
    ReconstructError::Nothing { views, low, high, has_plane, unit: setup.unit }
}

/// The error of a run in which no plane of a curved guide crosses a view.
fn off_guide<'a>(
    reports: impl ExactSizeIterator<Item = &'a ViewReport> + Clone,
    guide: &CurvedGuide,
    unit: LengthUnit,
) -> ReconstructError {
    let nowhere = [Point3::origin(); 2];
    let of_guide = extent(guide.points().iter().map(|point| [*point; 2])).unwrap_or(nowhere);
    let of_views = extent(reports.clone().filter_map(|v| v.corners)).unwrap_or(nowhere);
    ReconstructError::OffGuide {
        views: reports.len(),
        beyond_ends: reports.clone().map(|v| v.beyond_guide_ends).sum(),
        beyond_reach: reports.map(|v| v.beyond_guide_reach).sum(),
        usable: guide.usable_distance(),
        extents: Box::new([of_guide, of_views]),
        unit,
    }
}
