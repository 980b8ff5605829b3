//! The modeler on one screen: views in, cross-section model out (dissertation, 2.5.3 and 5.2).
//!
//! 0. With [`Setup::refine_poses`], the poses of all views are refined together, see
//!    [`PoseReport`].
//! 1. Each view is loaded, its curves on every plane it crosses are found, and it is dropped. A
//!    coarse copy stays, and the poses are judged by the copies.
//! 2. The curves of each plane are fused, independent of every other plane. What more views looked
//!    through than measured is left out. With [`Refinement`](crate::Refinement), planes are
//!    inserted where neighbours differ. Then the nodes learn what registered poses may err by.
//! 3. The fused planes make the model; the counts of all steps make the report.
//!
//! Views and planes run in parallel. Results are gathered in the order of views and planes, and no
//! sum crosses them, so the same input gives the same bytes for any number of threads.

use crate::fused::{Fused, Observed, ViewFacts, fuse};
use crate::modelled_view::{Modelled, ModelledView, Wanted, model_views, no_curves};
use crate::packed::PackedCurves;
use crate::poses::{reread, stated};
use crate::refine::{Refined, refine};
use crate::repeated::{PlacedImage, repeated_images};
use crate::report::{Report, Timings};
use crate::{PoseReport, ReconstructError, RefinementReport, Setup, ViewSource, Watch};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};
use transect_device::Note;
use transect_geometry::PlaneIndex;
use transect_model::{Model, ViewRecord};
use transect_register::CoarseView;

/// A model and the report of the run that made it.
#[derive(Debug, Clone)]
pub struct Reconstruction {
    /// The model.
    pub model: Model,
    /// Counts, notes and times.
    pub report: Report,
}

/// Reconstructs the cross-section model of a set of views.
///
/// ```
/// use std::sync::Arc;
/// use transect::device::{DeviceFrame, Pixel, SensorPlane};
/// use transect::sensors::{Intrinsics, Pinhole};
/// use transect::{
///     ImageSize, Isometry3, LengthUnit, PlaneFamily, RangeImage, Setup, StraightGuide, Unwatched,
///     Vector3, View, reconstruct,
/// };
///
/// // A camera one metre above a floor that it sees under 45°.
/// let size = ImageSize { rows: 48, cols: 64 };
/// let camera = Pinhole::new(size, Intrinsics { fx: 60.0, fy: 60.0, cx: 31.5, cy: 23.5 })?;
/// let floor = SensorPlane { normal: Vector3::new(0.0, 1.0, 1.0).normalize(), offset: 1.0 };
/// let pixels = (0..48).flat_map(|row| (0..64).map(move |col| Pixel::new(row, col)));
/// let depth = |p| camera.plane_value(p, &floor).unwrap_or(f64::NAN) as f32;
/// let image = RangeImage::from_values(size, pixels.map(depth).collect())?;
/// let view = View::new("floor", image, Arc::new(camera), Isometry3::identity(), Some(0.0))?;
///
/// let guide = StraightGuide::along(Vector3::x())?;
/// let setup = Setup::new(LengthUnit::Metre, PlaneFamily::new(guide, 0.0, 0.1)?);
/// let result = reconstruct(&[view], &setup, &Unwatched)?;
/// assert!(result.model.sections().all(|(_, section)| section.curves().len() == 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ReconstructError`] names the option outside its range, or the view that cannot be loaded or
/// modelled. There is no model of the other views then, because its gap would go unnoticed.
pub fn reconstruct<S: ViewSource>(
    sources: &[S],
    setup: &Setup,
    watch: &dyn Watch,
) -> Result<Reconstruction, ReconstructError> {
    let started = Instant::now();
    setup.check_options()?;
    let setup = &setup.with_least_interval().map_err(ReconstructError::Refine)?;
    let refined = |options| PoseReport::new(sources, Some(options), setup.unit, watch);
    let poses = setup.refine_poses.as_ref().map(refined).transpose()?;
    let poses_time = started.elapsed();
    let (copies, free_space) = (poses.is_none(), setup.free_space);
    let wanted = Wanted { copies, free_space }.of_several(sources.len());
    let Modelled { mut views, copies, facts } = match &poses {
        Some(poses) if poses.refinement.is_some() => {
            model_views(&poses.posed(sources), setup, watch, wanted)?
        }
        _ => model_views(sources, setup, watch, wanted)?,
    };
    let facts: Vec<_> = facts.iter().map(Some).collect();
    let again = |reading| reread(sources, reading, CoarseView::quick);
    let stated = stated(sources);
    let judge = |copies| PoseReport::of_given(copies, stated.as_ref(), again, setup);
    let judged = copies.map(judge);
    let views_done = Instant::now();
    let planes = by_plane(&mut views);
    if planes.is_empty() {
        return Err(no_curves(views.iter().map(|view| &view.report), setup));
    }
    let (fused, refined) = fused_planes(planes, setup, watch, &facts)?;
    let fused: Vec<Fused> = fused.into_iter().map(Fused::with_pose_errors).collect();
    let timings = Timings {
        poses: if poses.is_some() { poses_time } else { Duration::ZERO },
        views: views_done - started - poses_time,
        reading: views.iter().map(|v| v.reading).sum(),
        modelling: views.iter().map(|v| v.modelling).sum(),
        fusion: views_done.elapsed(),
    };
    let reports = views.iter().map(|view| view.report.clone()).collect();
    let notes = views.iter().flat_map(|view| view.notes.clone());
    let notes = notes.chain(repeated_images(views.iter().map(PlacedImage::from))).collect();
    let mut report = Report::new(reports, notes, &fused, timings);
    report.set_poses(poses.or(judged), setup.unit);
    let mut model = assemble(setup, views, fused);
    report.notes.extend(nothing_left(&model, &report).map(Note::new));
    if let Some((selected, refinement)) = refined {
        model = model.with_selection(selected);
        report.refinement = Some(refinement);
    }
    Ok(Reconstruction { model, report })
}

/// The planes that refinement selected, and its report.
type Selected = (BTreeSet<PlaneIndex>, RefinementReport);

/// All planes, or those that refinement selects, fused.
fn fused_planes(
    planes: Observed,
    setup: &Setup,
    watch: &dyn Watch,
    facts: &[Option<&ViewFacts>],
) -> Result<(Vec<Fused>, Option<Selected>), ReconstructError> {
    let Some(refinement) = &setup.refinement else {
        return Ok((fuse(planes.into_iter().collect(), setup, watch, facts)?, None));
    };
    let there = |k: &PlaneIndex| Some((*k, planes.get(k)?));
    let fuse =
        |asked: &[PlaneIndex]| fuse(asked.iter().filter_map(there).collect(), setup, watch, facts);
    let Refined { fused, selected, report } = refine(refinement, &setup.planes, &planes, fuse)?;
    Ok((fused, Some((selected, report))))
}

/// The note on a model of which fusion has left nothing.
fn nothing_left(model: &Model, report: &Report) -> Option<String> {
    let nodes = report.fusion.observations;
    model.sections().next().is_none().then(|| {
        format!(
            "the model has no curve: fusion left out all {nodes} nodes of the views, whose curves \
             are too short"
        )
    })
}

/// The curves that each plane has from each view, taken from the views; empty where a view has
/// none.
fn by_plane(views: &mut [ModelledView]) -> Observed {
    let (mut planes, count) = (Observed::new(), views.len());
    for (k, view) in views.iter_mut().enumerate() {
        for (plane, found) in std::mem::take(&mut view.planes) {
            let nothing = || (0..count).map(|_| PackedCurves::default()).collect();
            planes.entry(plane).or_insert_with(nothing)[k] = found;
        }
    }
    planes
}

fn assemble(setup: &Setup, views: Vec<ModelledView>, fused: Vec<Fused>) -> Model {
    let mut model = Model::new(setup.unit, setup.planes.clone());
    for ModelledView { world_from_sensor, sigma, nodes, report, .. } in views {
        let (source, name) = (report.name.clone(), report.name);
        model.add_view(ViewRecord { name, source, world_from_sensor, sigma, nodes });
    }
    for plane in fused {
        model.set_curves(plane.index, plane.plane.curves);
    }
    model
}
