//! The steps of the methods on one view and one plane, as numbered figures with a page around them.
//!
//! [`OpenScan::explain`] runs the methods that the settings choose and draws the result of each
//! step. The first steps are drawn in the range image of one view, the others on the plane with the
//! curves of all views. [`OpenScan::explain_growth`] draws how a plane grows with every view.

mod consensus;
mod dissertation;
mod growth;
mod image;
mod one_pass;
mod page;
mod pairwise;
mod palette;
mod plane_map;
mod rules;
mod seen_through;

pub use page::{Explanation, Step};
pub use rules::rule_figures;

use crate::selection::numbers_of_name;
use crate::views::FileView;
use crate::{OpenScan, Settings, WorkflowError};
use page::Builder;
use rayon::prelude::*;
use std::ops::RangeInclusive;
use transect::{Setup, ViewSource, Witness};
use transect_device::View;
use transect_exchange::svg::Figure;
use transect_fusion::{FusionMethod, PairwiseOptions};
use transect_geometry::{Curve, PlaneFamily, PlaneIndex};
use transect_partial::dissertation::plane_steps;
use transect_partial::one_pass as sweep;
use transect_partial::{Method, PartialError, PlaneCurves, partial_model};

/// Fewest nodes of a curve that tells something. By hand: between 6 and 20 the choice is the same.
const LEAST_NODES: usize = 10;

/// The range image of a view.
pub fn range_image_figure(view: &View, title: &str, caption: &str) -> Figure {
    let size = image::Window::whole(view.image().size()).size();
    let mut figure = Figure::new(title, caption, size);
    image::range_image(&mut figure, view);
    figure
}

/// One plane with the curves that every view has on it.
struct PlaneOfViews<'a> {
    setup: &'a Setup,
    plane: PlaneIndex,
    /// Names of the views, in the order of the scan.
    names: Vec<String>,
    /// The curves of each view.
    curves: Vec<Vec<Curve>>,
    /// The free space of each view; `None` if it cannot tell, or if the model keeps what views
    /// looked through.
    witnesses: Vec<Option<Witness>>,
}

impl OpenScan {
    /// The steps of the chosen methods on a plane, in the range image of one view and between all
    /// views. Without a plane, the one on which the view has most curves.
    ///
    /// # Errors
    /// [`WorkflowError`] if a setting cannot be used, the view cannot be loaded, or the plane does
    /// not cross what it saw.
    pub fn explain(
        &self,
        settings: &Settings,
        view: &str,
        plane: Option<i64>,
    ) -> Result<Explanation, WorkflowError> {
        let setup = straight(settings.setup(self.scan())?, settings.planes.guide.is_some())?;
        let views = self.views("", settings.plausibility(&setup))?;
        let number = number_of(&views, view)?;
        let chosen = load(&views[number])?;
        let crossed = planes_of(&chosen, &setup.planes);
        let plane = match plane {
            Some(plane) => PlaneIndex(plane),
            None => telling_plane(&chosen, &setup).map_err(failed(&views[number]))?,
        };
        if !crossed.contains(&plane.0) {
            return Err(off_plane(plane, views[number].name(), &crossed));
        }
        let mut pages = Builder::new(format!(
            "{}: plane {plane} at {} {} in view {}",
            self.scan().name,
            crate::table::digits(setup.planes.station(plane)),
            setup.unit,
            views[number].name()
        ));
        match &setup.partial {
            Method::Dissertation(options) => {
                let steps = plane_steps(&chosen, &setup.planes, plane, options);
                dissertation::draw(&steps.map_err(failed(&views[number]))?, &setup, &mut pages);
            }
            Method::OnePass(options) => {
                let (view, setup) = (&chosen, &setup);
                let drawn = one_pass::Drawn { view, setup, plane, options };
                one_pass::draw(&drawn, &mut pages).map_err(failed(&views[number]))?;
            }
        }
        let of_views = PlaneOfViews::collect(&views, &setup, plane)?;
        let fused = match &setup.fusion {
            FusionMethod::Pairwise(options) => {
                pairwise::draw(&of_views, number, options, &mut pages)
            }
            FusionMethod::Consensus(options) => consensus::draw(&of_views, options, &mut pages),
        };
        let curves = seen_through::draw(&of_views, fused, &mut pages);
        pages.count("curves of the plane", curves.len());
        Ok(pages.finish())
    }

    /// How a plane grows with every view: the range image and the plane after each view, and a
    /// figure that repeats all of them. Views are fused by `pairwise`. Without a plane, the one on
    /// which the first view has most curves.
    ///
    /// # Errors
    /// As [`OpenScan::explain`]. Also if the settings ask for `consensus`, which fuses all views at
    /// once.
    pub fn explain_growth(
        &self,
        settings: &Settings,
        plane: Option<i64>,
    ) -> Result<Explanation, WorkflowError> {
        let mut settings = settings.clone();
        settings.fusion.get_or_insert(FusionMethod::Pairwise(PairwiseOptions::default()));
        let setup = straight(settings.setup(self.scan())?, settings.planes.guide.is_some())?;
        let options = growth::options(&setup)?;
        let views = self.views("", settings.plausibility(&setup))?;
        let Some(first) = views.first() else {
            return Err(WorkflowError::setting("views", "the scan has no view"));
        };
        let plane = match plane {
            Some(plane) => PlaneIndex(plane),
            None => telling_plane(&load(first)?, &setup).map_err(failed(first))?,
        };
        let of_views = PlaneOfViews::collect(&views, &setup, plane)?;
        let mut pages = Builder::new(format!(
            "{}: how plane {plane} at {} {} grows",
            self.scan().name,
            crate::table::digits(setup.planes.station(plane)),
            setup.unit
        ));
        growth::draw(&of_views, &options, &|number| load(&views[number]), &mut pages)?;
        Ok(pages.finish())
    }
}

impl<'a> PlaneOfViews<'a> {
    /// Models the views, in parallel, and keeps their curves on one plane.
    fn collect(
        views: &[FileView<'_>],
        setup: &'a Setup,
        plane: PlaneIndex,
    ) -> Result<Self, WorkflowError> {
        let model = |view: &FileView<'_>| {
            let loaded = load(view)?;
            let witness = setup.free_space.then(|| Witness::of(&loaded)).flatten();
            Ok((curves_on(&loaded, setup, plane).map_err(failed(view))?, witness))
        };
        let modelled: Vec<Result<_, WorkflowError>> = views.par_iter().map(model).collect();
        let modelled = modelled.into_iter().collect::<Result<Vec<_>, _>>()?;
        let (curves, witnesses) = modelled.into_iter().unzip();
        let names = views.iter().map(|view| view.name().to_owned()).collect();
        Ok(Self { setup, plane, names, curves, witnesses })
    }

    /// The curves in the form that fusion takes.
    fn views(&self) -> Vec<&[Curve]> {
        self.curves.iter().map(Vec::as_slice).collect()
    }
}

/// The curves of a view on one plane.
fn curves_on(view: &View, setup: &Setup, plane: PlaneIndex) -> Result<Vec<Curve>, PartialError> {
    Ok(match &setup.partial {
        Method::Dissertation(options) => {
            let steps = plane_steps(view, &setup.planes, plane, options)?;
            steps.curves.into_iter().filter_map(|c| Some(c.curve?.curve)).collect()
        }
        Method::OnePass(options) => {
            let model = sweep::partial_model(view, &setup.planes, options)?;
            let found = model.planes.into_iter().find(|p| p.plane == plane);
            found.into_iter().flat_map(|p| p.curves).map(|c| c.curve).collect()
        }
    })
}

/// Refuses curved guides: the figures show planes that are parallel. `is_given` tells whether the
/// settings have the guide, and not the scan.
fn straight(setup: Setup, is_given: bool) -> Result<Setup, WorkflowError> {
    if setup.planes.guide().straight().is_some() {
        return Ok(setup);
    }
    let (setting, problem) = if is_given {
        ("guide", "the planes follow a curve; give the setting `normal` in its place")
    } else {
        (
            "normal",
            "the scan's own planes follow a curve; give a normal, such as the setting `normal` \
             0,0,1",
        )
    };
    Err(WorkflowError::setting(setting, format!("the figures show parallel planes, and {problem}")))
}

fn off_plane(plane: PlaneIndex, view: &str, crossed: &RangeInclusive<i64>) -> WorkflowError {
    let (first, last) = (crossed.start(), crossed.end());
    if crossed.is_empty() {
        let problem = format!(
            "no plane crosses the surface that view {view} saw; make the setting `interval` \
             smaller, or change the setting `offset`"
        );
        return WorkflowError::setting("interval", problem);
    }
    let problem = format!(
        "plane {plane} does not cross the surface that view {view} saw; planes {first} to {last} do"
    );
    WorkflowError::setting("plane", problem)
}

/// A view by its name, or by its number from 0.
fn number_of(views: &[FileView<'_>], text: &str) -> Result<usize, WorkflowError> {
    let by_name = numbers_of_name(views.iter().map(|view| view.name()), text);
    let number =
        by_name.first().copied().or_else(|| text.parse().ok().filter(|k| *k < views.len()));
    number.ok_or_else(|| {
        let last = views.len().saturating_sub(1);
        let problem = format!("no view {text}; views have numbers from 0 to {last}, and names");
        WorkflowError::setting("view", problem)
    })
}

fn load(view: &FileView<'_>) -> Result<View, WorkflowError> {
    let loaded = view.load().map_err(|source| {
        let view = view.name().to_owned();
        WorkflowError::Reconstruct(transect::ReconstructError::Load { view, source })
    })?;
    Ok(loaded.view)
}

fn failed(view: &FileView<'_>) -> impl Fn(PartialError) -> WorkflowError + use<> {
    let view = view.name().to_owned();
    move |source| {
        let view = view.clone();
        WorkflowError::Reconstruct(transect::ReconstructError::Partial { view, source })
    }
}

/// The planes that pass between points of a view.
fn planes_of(view: &View, planes: &PlaneFamily) -> RangeInclusive<i64> {
    let points = view.image().size().all_pixels().filter_map(|p| view.point_in_sensor(p));
    let levels = points.map(|p| planes.level(&(view.world_from_sensor() * p)));
    let (low, high) =
        levels.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), l| (low.min(l), high.max(l)));
    low.ceil() as i64..=high.floor() as i64
}

/// The plane with most curves of the chosen method that are no scraps; of equal ones the plane with
/// most nodes.
fn telling_plane(view: &View, setup: &Setup) -> Result<PlaneIndex, PartialError> {
    let model = partial_model(view, &setup.planes, &setup.partial)?;
    let telling = |found: &&PlaneCurves| {
        let nodes = found.curves.iter().map(|c| c.curve.nodes().len());
        let nodes = nodes.filter(|count| *count >= LEAST_NODES);
        (nodes.clone().count(), nodes.sum::<usize>())
    };
    Ok(model.planes.iter().max_by_key(telling).map_or(PlaneIndex(0), |found| found.plane))
}
