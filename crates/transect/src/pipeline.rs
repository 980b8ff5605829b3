//! The modeler on one screen: views in, cross-section model out (dissertation, 2.5.3 and 5.2).
//!
//! 1. Each view is loaded, its curves on every plane it involves are found, and it is dropped.
//! 2. Each plane's curves from all views are fused, independent of every other plane.
//!    With [`Refinement`], planes are inserted where neighbours differ.
//! 3. The fused planes make the model; what happened on the way makes the report.
//!
//! Views and planes run in parallel. Results are gathered in the order of views and planes, and no
//! sum crosses them, so the same input gives the same bytes for any number of threads.

use crate::refine::{Observed, Refined, refine};
use crate::report::{FusionReport, Report, Timings, ViewReport};
use crate::{LoadedView, Refinement, SourceError, Stage, ViewSource, Watch};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};
use transect_device::Isometry3;
use transect_fusion::{Agreement, FusedPlane, FusionMethod, fuse_and_compare};
use transect_geometry::{Curve, Guide, GuideError, LengthUnit, PlaneFamily, PlaneIndex};
use transect_model::{Model, ViewRecord};
use transect_partial::{Method, PartialCounts, PartialError, partial_model};

/// What a model is made with.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// The unit of every length.
    pub unit: LengthUnit,
    /// Where the section planes are.
    pub planes: PlaneFamily,
    /// How each view's curves are found.
    pub partial: Method,
    /// How the views' curves are fused.
    pub fusion: FusionMethod,
    /// Where planes are inserted between these; `None` for nowhere.
    pub refinement: Option<Refinement>,
}

impl Setup {
    /// Planes in a unit, with default options.
    pub fn new(unit: LengthUnit, planes: PlaneFamily) -> Self {
        let (partial, fusion) = (Method::default(), FusionMethod::default());
        Self { unit, planes, partial, fusion, refinement: None }
    }
}

/// Why there is no model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReconstructError {
    /// There is nothing to reconstruct.
    #[error("the scan has no views")]
    NoViews,
    /// A view could not be loaded.
    #[error("view {view}")]
    Load {
        /// Its name.
        view: String,
        /// What its source says.
        #[source]
        source: SourceError,
    },
    /// A view could not be modelled.
    #[error("view {view}")]
    Partial {
        /// Its name.
        view: String,
        /// What the partial modeler says.
        #[source]
        source: PartialError,
    },
    /// No plane crosses any view's surface: usually a wrong unit, offset or depth scale.
    #[error(
        "{views} views, but no section plane crosses what they saw; they lie between stations {low} and {high} {unit}"
    )]
    Nothing {
        /// How many views there were.
        views: usize,
        /// Lowest station of the views' points.
        low: f64,
        /// Highest station of the views' points.
        high: f64,
        /// The model's unit.
        unit: LengthUnit,
    },
    /// No plane along a curved guide crosses what the views saw.
    #[error(
        "{views} views, but no section plane along the guide crosses what they saw; {beyond_ends} of their \
         pixels lie beyond its ends, {beyond_reach} too far from it"
    )]
    OffGuide {
        /// How many views there were.
        views: usize,
        /// Pixels beyond the guide's ends.
        beyond_ends: usize,
        /// Pixels beyond its reach.
        beyond_reach: usize,
    },
    /// Planes cross what the views saw, but no view has two crossings beside each other.
    #[error(
        "{views} views cross the section planes {crossings} times, but nowhere twice in a row: \
         images of one row, or too few pixels, make no curves"
    )]
    NoCurves {
        /// How many views there were.
        views: usize,
        /// How many crossings.
        crossings: usize,
    },
    /// The smallest interval that planes are refined to is none.
    #[error("the section planes cannot be refined")]
    Refine(#[source] GuideError),
    /// The watcher asked to stop.
    #[error("cancelled")]
    Cancelled,
}

/// A model and how it came about.
#[derive(Debug)]
pub struct Reconstruction {
    /// The model.
    pub model: Model,
    /// What happened.
    pub report: Report,
}

/// Reconstructs the cross-section model of a set of views.
///
/// # Errors
/// [`ReconstructError`] naming the view, if one cannot be loaded or modelled; there is no model of
/// the remaining views then, since nobody would notice the gap.
pub fn reconstruct<S: ViewSource>(
    sources: &[S],
    setup: &Setup,
    watch: &dyn Watch,
) -> Result<Reconstruction, ReconstructError> {
    let started = Instant::now();
    let setup = &setup.with_least_interval()?;
    let views = model_views(sources, setup, watch)?;
    let views_done = Instant::now();
    let planes = by_plane(&views);
    if planes.is_empty() {
        return Err(nothing(views.iter().map(ModelledView::extent), setup));
    }
    let fuse = |asked: &[PlaneIndex]| fuse(asked, &planes, setup, watch);
    let (fused, refined) = match &setup.refinement {
        None => (fuse(&planes.keys().copied().collect::<Vec<_>>())?, None),
        Some(refinement) => {
            let Refined { fused, selected, report } =
                refine(refinement, &setup.planes, &planes, fuse)?;
            (fused, Some((selected, report)))
        }
    };
    let timings = Timings {
        views: views_done - started,
        reading: views.iter().map(|v| v.reading).sum(),
        modelling: views.iter().map(|v| v.modelling).sum(),
        fusion: views_done.elapsed(),
    };
    let mut report = report(&views, &fused, timings);
    let mut model = assemble(setup, views, fused);
    if let Some((selected, refinement)) = refined {
        model = model.with_selection(selected);
        report.refinement = Some(refinement);
    }
    Ok(Reconstruction { model, report })
}

impl Setup {
    /// The same with the planes of the smallest interval that refinement may come to.
    fn with_least_interval(&self) -> Result<Self, ReconstructError> {
        let planes = match &self.refinement {
            None => self.planes.clone(),
            Some(refinement) => {
                refinement.family(&self.planes).map_err(ReconstructError::Refine)?
            }
        };
        Ok(Self { planes, ..self.clone() })
    }
}

/// What is kept of a view.
pub(crate) struct ModelledView {
    pub name: String,
    pub notes: Vec<String>,
    pub world_from_sensor: Isometry3,
    pub sigma: Option<f64>,
    pixels: usize,
    valid: usize,
    stations: (f64, f64),
    /// The planes it crosses, sorted, each with its curves.
    pub planes: Vec<(PlaneIndex, Vec<Curve>)>,
    pub counts: PartialCounts,
    pub reading: Duration,
    pub modelling: Duration,
}

fn model_views<S: ViewSource>(
    sources: &[S],
    setup: &Setup,
    watch: &dyn Watch,
) -> Result<Vec<ModelledView>, ReconstructError> {
    if sources.is_empty() {
        return Err(ReconstructError::NoViews);
    }
    watch.begin(Stage::Views, sources.len());
    let model = |source: &S| {
        if watch.cancelled() {
            return Err(ReconstructError::Cancelled);
        }
        let modelled = model_view(source, setup);
        watch.step(Stage::Views);
        modelled
    };
    // The first view that fails is named, whichever thread was first.
    let views: Vec<Result<ModelledView, _>> = sources.par_iter().map(model).collect();
    views.into_iter().collect()
}

fn model_view<S: ViewSource>(source: &S, setup: &Setup) -> Result<ModelledView, ReconstructError> {
    let (loaded, reading) = load(source)?;
    model_loaded(source.name(), loaded, reading, setup)
}

/// A view, and how long it took to load it.
pub(crate) fn load<S: ViewSource>(source: &S) -> Result<(LoadedView, Duration), ReconstructError> {
    let started = Instant::now();
    let failed = |e| ReconstructError::Load { view: source.name().to_owned(), source: e };
    let loaded = source.load().map_err(failed)?;
    Ok((loaded, started.elapsed()))
}

pub(crate) fn model_loaded(
    name: &str,
    LoadedView { view, mut notes }: LoadedView,
    reading: Duration,
    setup: &Setup,
) -> Result<ModelledView, ReconstructError> {
    let (name, read) = (name.to_owned(), Instant::now());
    let partial = partial_model(&view, &setup.planes, &setup.partial)
        .map_err(|e| ReconstructError::Partial { view: name.clone(), source: e })?;
    let modelling = read.elapsed();
    notes.extend(partial.notes);
    // Fusion knows oriented curves and nothing else.
    let curves = partial.planes.into_iter().map(|found| {
        let curves = found.curves.into_iter().map(|c| c.curve).collect();
        (found.plane, curves)
    });
    Ok(ModelledView {
        planes: curves.collect(),
        counts: partial.counts,
        notes,
        world_from_sensor: *view.world_from_sensor(),
        sigma: view.sigma(),
        pixels: view.image().size().pixels(),
        valid: view.image().valid_count(),
        stations: stations(&view, &setup.planes),
        reading,
        modelling,
        name,
    })
}

/// Bounds of the stations a view can have points at.
fn stations(view: &transect_device::View, planes: &PlaneFamily) -> (f64, f64) {
    let pose = view.world_from_sensor();
    // Of a curved guide: those of the whole of it, until something better is known.
    let Guide::Straight(guide) = planes.guide() else {
        return (0.0, planes.guide().curved().map_or(0.0, |guide| guide.length()));
    };
    let direction = guide.direction();
    let in_sensor = pose.rotation.inverse_transform_vector(&direction);
    let Some((near, far)) = view.image().extremes() else { return (0.0, 0.0) };
    let (low, high) = view.frame().extent(&in_sensor, f64::from(near), f64::from(far));
    let sensor = direction.dot(&pose.translation.vector);
    (sensor + low, sensor + high)
}

/// Why views without a single curve have none.
pub(crate) fn nothing(
    views: impl ExactSizeIterator<Item = Extent> + Clone,
    setup: &Setup,
) -> ReconstructError {
    let crossings = views.clone().map(|v| v.crossings).sum();
    if crossings > 0 {
        return ReconstructError::NoCurves { views: views.len(), crossings };
    }
    if setup.planes.guide().curved().is_some() {
        let sum = |of: fn(&Extent) -> usize| views.clone().map(|v| of(&v)).sum();
        let (beyond_ends, beyond_reach) = (sum(|v| v.beyond_ends), sum(|v| v.beyond_reach));
        return ReconstructError::OffGuide { views: views.len(), beyond_ends, beyond_reach };
    }
    let low = views.clone().map(|v| v.stations.0).fold(f64::INFINITY, f64::min);
    let high = views.clone().map(|v| v.stations.1).fold(f64::NEG_INFINITY, f64::max);
    ReconstructError::Nothing { views: views.len(), low, high, unit: setup.unit }
}

/// Where a view's points can be, and how often planes cross what it saw.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Extent {
    crossings: usize,
    stations: (f64, f64),
    beyond_ends: usize,
    beyond_reach: usize,
}

impl ModelledView {
    pub(crate) fn extent(&self) -> Extent {
        let PartialCounts { crossings, beyond_ends, beyond_reach, .. } = self.counts;
        Extent { crossings, stations: self.stations, beyond_ends, beyond_reach }
    }

    /// The view's own part of the report; how it agrees with others is not known yet.
    pub(crate) fn report(&self) -> ViewReport {
        ViewReport {
            name: self.name.clone(),
            pixels: self.pixels,
            valid_pixels: self.valid,
            beyond_guide_ends: self.counts.beyond_ends,
            beyond_guide_reach: self.counts.beyond_reach,
            sigma: self.counts.sigma,
            sigma_given: self.sigma.is_some(),
            planes: self.planes.len(),
            curves: self.planes.iter().map(|(_, curves)| curves.len()).sum(),
            crossings: self.counts.crossings,
            range_jumps: self.counts.jumps,
            samples_close_to_other_views: 0,
            samples_abreast_of_other_views: 0,
            contradicted: false,
        }
    }
}

/// The curves that each plane has from each view; empty where a view has none.
fn by_plane(views: &[ModelledView]) -> Observed<'_> {
    let mut planes: Observed<'_> = BTreeMap::new();
    for (k, view) in views.iter().enumerate() {
        for (plane, found) in &view.planes {
            let curves = planes.entry(*plane).or_insert_with(|| vec![&[]; views.len()]);
            curves[k] = found;
        }
    }
    planes
}

/// The fused curves of a plane, and how its views agree.
pub(crate) struct Fused {
    pub index: PlaneIndex,
    pub plane: FusedPlane,
    pub agreement: Vec<Agreement>,
}

/// Fuses those of some planes that views have curves on.
fn fuse(
    asked: &[PlaneIndex],
    planes: &Observed<'_>,
    setup: &Setup,
    watch: &dyn Watch,
) -> Result<Vec<Fused>, ReconstructError> {
    let asked: Vec<_> = asked.iter().filter_map(|k| planes.get_key_value(k)).collect();
    watch.begin(Stage::Planes, asked.len());
    let fuse = |&(index, views): &(&PlaneIndex, &Vec<&[Curve]>)| {
        if watch.cancelled() {
            return Err(ReconstructError::Cancelled);
        }
        let (plane, agreement) = fuse_and_compare(views, &setup.fusion);
        let fused = Fused { index: *index, plane, agreement };
        watch.step(Stage::Planes);
        Ok(fused)
    };
    asked.par_iter().map(fuse).collect()
}

fn report(views: &[ModelledView], fused: &[Fused], timings: Timings) -> Report {
    let mut agreements = vec![Agreement::default(); views.len()];
    for plane in fused {
        agreements.iter_mut().zip(&plane.agreement).for_each(|(sum, a)| sum.add(a));
    }
    let reported = views.iter().zip(&agreements).map(|(view, agreement)| {
        let mut report = view.report();
        report.set_agreement(agreement);
        report
    });
    let reports: Vec<ViewReport> = reported.collect();
    let several = views.len() > 1;
    let alone = reports.iter().filter(|_| several).filter_map(ViewReport::note_if_alone);
    let notes = views.iter().flat_map(|v| v.notes.clone()).chain(alone).collect();
    let fusion = FusionReport::new(fused.iter().map(|f| &f.plane));
    Report { fusion, refinement: None, notes, timings, views: reports }
}

fn assemble(setup: &Setup, views: Vec<ModelledView>, fused: Vec<Fused>) -> Model {
    let mut model = Model::new(setup.unit, setup.planes.clone());
    for view in views {
        model.add_view(ViewRecord {
            source: view.name.clone(),
            name: view.name,
            world_from_sensor: view.world_from_sensor,
            sigma: view.sigma,
            nodes: view.counts.crossings as u64,
        });
    }
    for plane in fused {
        model.set_curves(plane.index, plane.plane.curves);
    }
    model
}
