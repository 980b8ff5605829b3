//! The modeler that grows a model store view by view (dissertation, 2.5.2 and 5.2).
//!
//! Problem: weeks of scanning cannot be reconstructed anew for every view that is added, moved or
//! removed. Every view that was added before a crash must be there after it.
//!
//! Idea: the store keeps every view's own curves, plane by plane. The fused curves of a plane are a
//! pure function of those, and of the space that the same views looked through. It is the same
//! function as in [`reconstruct`](crate::reconstruct). So a view that is added or removed changes
//! its own planes alone. The result is, byte for byte, that of one run over the remaining views, in
//! any order of additions and removals.
//!
//! 1. A view is loaded and its curves are found; a failure leaves the store as it was.
//! 2. Its curves, a coarse copy of its image and the space it looked through are stored at once.
//! 3. Its planes are fused: in the same transaction for a single view, after the last view if
//!    several are added at once. Planes run in parallel.
//! 4. The poses of the store are judged by the copies; see `judged.rs`. They are refined on demand;
//!    see `registration.rs`.
//!
//! Views are fused in order of their ids. The result of `consensus` does not depend on that order.
//! The result of `pairwise` is that of one run over the views in that order.
//!
//! Departure from the dissertation: there a view is merged into the model and not kept (5.2).

mod error;
mod fuser;
mod judged;
mod kept_image;
mod looked_through;
mod registration;

pub use error::GrowError;
pub use looked_through::correct_by_free_space;

use crate::fingerprint::fingerprint;
use crate::modelled_view::{ModelledView, no_curves, surface_sigma};
use crate::repeated::{PlacedImage, repeated_images};
use crate::report::{PlaneSummary, Report, Timings, ViewReport};
use crate::timed_view::TimedView;
use crate::{
    FusionReport, LoadedView, PoseReport, ReconstructError, Setup, Stage, Unwatched, ViewSource,
    Watch,
};
use fuser::Fuser;
use judged::{Judged, judged};
use kept_image::{KeptImage, Registered, SurfaceSigma};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};
use transect_device::{Note, View};
use transect_geometry::{Curve, PlaneIndex};
use transect_model::store::{
    Snapshot, Store, StoreError, StoredView, ViewCopy, ViewDescription, ViewId, ViewReplacement,
};

/// The result of adding views.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Growth {
    /// Names of views that were in the store already.
    pub present: Vec<String>,
    /// The report. Its views are the added ones, its fusion is that of the whole store. Spread,
    /// threshold and dropped nodes are those of the planes that were fused now.
    pub report: Report,
    /// Number of planes that were fused.
    pub fused: usize,
}

/// Adds views to a store, removes and replaces them.
///
/// ```
/// use std::sync::Arc;
/// use transect::device::{DeviceFrame, Pixel, SensorPlane};
/// use transect::geometry::Point3;
/// use transect::model::Location;
/// use transect::model::store::{SpaceQuery, Store};
/// use transect::sensors::{Intrinsics, Pinhole};
/// use transect::{
///     Grower, ImageSize, Isometry3, LengthUnit, PlaneFamily, RangeImage, Setup, StraightGuide,
///     Unwatched, Vector3, View,
/// };
///
/// // A camera sees a floor under 45°, and the same camera half a metre to the side.
/// let size = ImageSize { rows: 48, cols: 64 };
/// let camera = Pinhole::new(size, Intrinsics { fx: 60.0, fy: 60.0, cx: 31.5, cy: 23.5 })?;
/// let floor = SensorPlane { normal: Vector3::new(0.0, 1.0, 1.0).normalize(), offset: 1.0 };
/// let pixels = (0..48).flat_map(|row| (0..64).map(move |col| Pixel::new(row, col)));
/// let depth = |p| camera.plane_value(p, &floor).unwrap_or(f64::NAN) as f32;
/// let image = RangeImage::from_values(size, pixels.map(depth).collect())?;
/// let camera: Arc<dyn DeviceFrame> = Arc::new(camera);
/// let view = |name: &str, x: f64| {
///     let pose = Isometry3::translation(x, 0.0, 0.0);
///     View::new(name, image.clone(), camera.clone(), pose, Some(0.0))
/// };
///
/// let planes = PlaneFamily::new(StraightGuide::along(Vector3::x())?, 0.0, 0.1)?;
/// let setup = Setup::new(LengthUnit::Metre, planes);
/// let folder = tempfile::tempdir()?;
/// let store = Store::create(folder.path().join("floor.transect"), &setup.store_header())?;
/// let grower = Grower::new(&store, &setup)?;
/// grower.add_views(&[view("first", 0.0)?, view("second", 0.5)?], &Unwatched)?;
/// grower.remove_view(&"first".into())?;
/// assert_eq!(store.views()?.len(), 1);
///
/// // One centimetre below the floor, in the middle of the second view.
/// let below = Point3::new(0.52, 0.0, 2_f64.sqrt()) + floor.normal * 0.01;
/// let mut query = SpaceQuery::new(store.read()?, SpaceQuery::DEFAULT_CAPACITY);
/// assert_eq!(query.locate(&below)?.location, Location::Inside);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Grower<'a> {
    store: &'a Store,
    setup: &'a Setup,
}

/// A view that was compared with the store.
enum Looked {
    /// The store has the same view.
    Present,
    New(Box<NewView>),
}

/// A view on its way into the store.
struct NewView {
    entry: ViewDescription,
    /// By which its pose is compared with those of other views.
    copy: Option<ViewCopy>,
    view: ModelledView<Vec<Curve>>,
}

/// A source of which the view takes the place of a stored one.
struct InPlace<'a, S> {
    id: ViewId,
    source: &'a S,
    /// What the view was given, if registration puts it there.
    given: Option<Registered>,
}

/// A view that comes for another one, with the curves of its planes.
type Replacement = ViewReplacement<Vec<(PlaneIndex, Vec<Curve>)>>;

/// The views that were added so far.
#[derive(Default)]
struct Added {
    present: Vec<String>,
    reports: Vec<ViewReport>,
    ids: Vec<ViewId>,
    notes: Vec<Note>,
    reading: Duration,
    modelling: Duration,
}

impl<'a> Grower<'a> {
    /// A grower for a store that was made with the same settings.
    ///
    /// # Errors
    /// * [`GrowError::Refinement`] if the setup asks to refine planes;
    /// * [`GrowError::Poses`] if it asks to refine poses;
    /// * [`GrowError::Option`] if an option is outside its range;
    /// * [`GrowError::Settings`] if the settings of the store cannot be read;
    /// * [`GrowError::OtherUnit`] if the store has another length unit;
    /// * [`GrowError::OtherSettings`] with the settings that differ.
    pub fn new(store: &'a Store, setup: &'a Setup) -> Result<Self, GrowError> {
        if setup.refinement.is_some() {
            return Err(GrowError::Refinement);
        }
        if setup.refine_poses.is_some() {
            return Err(GrowError::Poses);
        }
        setup.check_options()?;
        let read = store.read()?;
        let header = read.header();
        if header.unit != setup.unit {
            return Err(GrowError::OtherUnit { there: header.unit, here: setup.unit });
        }
        match setup.difference(header)? {
            Some(difference) => Err(GrowError::OtherSettings(difference)),
            None => Ok(Self { store, setup }),
        }
    }

    /// Adds one view and fuses the planes it touches, in one transaction. `None` if the store has
    /// the view already. A view that crosses no plane is stored, too, with 0 nodes. Its notes and
    /// the judgement of its pose are left out; [`Grower::add_views`] reports both.
    ///
    /// # Errors
    /// [`GrowError`]; the store is then unchanged.
    pub fn add_view<S: ViewSource>(&self, source: &S) -> Result<Option<StoredView>, GrowError> {
        let Looked::New(new) = self.look_at(source)? else { return Ok(None) };
        let mut transaction = self.store.begin_view(new.entry)?;
        new.copy.map_or(Ok(()), |copy| transaction.set_copy(&copy))?;
        transaction.add_planes(new.view.planes, &Fuser::new(self.setup, &Unwatched))?;
        Ok(Some(transaction.commit()?))
    }

    /// Adds many views, each in one transaction, and fuses their planes in a last transaction.
    /// Views that are in the store already are skipped, so an interrupted run can be repeated.
    ///
    /// # Errors
    /// [`GrowError`] with the first view, in the given order, that fails. The views before it are
    /// then in the store; that view and the later ones are not. The exception is
    /// [`ReconstructError::Nothing`], if the store has no curve in the end: all views are in it.
    pub fn add_views<S: ViewSource>(
        &self,
        sources: &[S],
        watch: &dyn Watch,
    ) -> Result<Growth, GrowError> {
        check_ids(sources)?;
        let (started, mut added) = (Instant::now(), Added::default());
        let taken = self.take_in(sources, watch, &mut added);
        let views = started.elapsed();
        let taken = match taken {
            Err(stop @ (GrowError::View(ReconstructError::Cancelled) | GrowError::Store(_))) => {
                return Err(stop);
            }
            // A view failed. The views before it are in the store, so their planes are fused.
            done => done,
        };
        let fuser = self.fuse_pending_with(Fuser::new(self.setup, watch))?;
        taken?;
        let Added { reading, modelling, .. } = added;
        let timings = Timings {
            poses: Duration::ZERO,
            views,
            reading,
            modelling,
            fusion: started.elapsed() - views,
        };
        self.growth(sources, added, fuser, timings)
    }

    /// Fuses the planes that an interrupted run left; returns their number.
    ///
    /// # Errors
    /// If the store cannot be read or written.
    pub fn fuse_pending(&self, watch: &dyn Watch) -> Result<usize, GrowError> {
        Ok(self.fuse_pending_with(Fuser::new(self.setup, watch))?.summaries().len())
    }

    /// The planes whose stored curves differ from the result of fusing again, for example after a
    /// change of the program.
    ///
    /// # Errors
    /// If the store cannot be read, or planes are still to be fused.
    pub fn stale_planes(&self) -> Result<Vec<PlaneIndex>, GrowError> {
        Ok(self.store.read()?.stale_planes(&Fuser::new(self.setup, &Unwatched))?)
    }

    /// Removes a view. The store is then as if the view had never been added.
    ///
    /// # Errors
    /// If there is no such view, or the store cannot be read or written; it is then unchanged.
    pub fn remove_view(&self, id: &ViewId) -> Result<StoredView, GrowError> {
        Ok(self.store.remove_view(id, &Fuser::new(self.setup, &Unwatched))?)
    }

    /// Replaces views by others, all in one transaction. The store is then as if the old views had
    /// never been added. The report has the new views, with notes and warnings, and no counts of
    /// the fusion.
    ///
    /// # Errors
    /// If there is no view of an id, a new view fails, or its id is that of another view; the store
    /// is then unchanged.
    pub fn replace_views<S: ViewSource>(
        &self,
        replacements: &[(ViewId, S)],
        watch: &dyn Watch,
    ) -> Result<(Vec<StoredView>, Report), GrowError> {
        let in_place = replacements.iter();
        let in_place = in_place.map(|(id, source)| InPlace { id: id.clone(), source, given: None });
        let in_place: Vec<_> = in_place.collect();
        differ(in_place.iter().map(|view| view.id.0.as_str()))?;
        let (stored, mut report) = self.put_in_place(&in_place, watch)?;
        let new = stored.iter().map(|view| view.entry.id.clone()).collect();
        let no_sources: [S; 0] = [];
        let Judged { poses, note } = judged(&self.store.read()?, &new, &no_sources, self.setup)?;
        report.notes.extend(note);
        report.set_poses(poses, self.setup.unit);
        Ok((stored, report))
    }

    /// Judges the poses of the views in the store by coarse copies of their images; `None` if
    /// nothing contradicts. Of more than 60 views, these are the `new` ones and those nearest to
    /// them. For each it reads some 100 kB and takes a few milliseconds. [`Grower::add_views`] and
    /// [`Grower::replace_views`] judge, too.
    ///
    /// # Errors
    /// If the store cannot be read.
    pub fn judge_poses(&self, new: &[ViewId]) -> Result<Option<PoseReport>, GrowError> {
        let (new, no_sources): (_, [View; 0]) = (new.iter().cloned().collect(), []);
        let Judged { poses, .. } = judged(&self.store.read()?, &new, &no_sources, self.setup)?;
        Ok(poses.filter(PoseReport::is_doubtful))
    }

    fn put_in_place<S: ViewSource>(
        &self,
        replacements: &[InPlace<'_, S>],
        watch: &dyn Watch,
    ) -> Result<(Vec<StoredView>, Report), GrowError> {
        watch.begin(Stage::Views, replacements.len());
        let model = |InPlace { id, source, given }: &InPlace<'_, S>| {
            if watch.cancelled() {
                return Err(ReconstructError::Cancelled.into());
            }
            let new = self.model(*source, TimedView::load(*source)?, given.as_ref())?;
            watch.step(Stage::Views);
            Ok((id.clone(), new))
        };
        let modelled: Vec<Result<_, GrowError>> = replacements.par_iter().map(model).collect();
        let (mut new, mut views, mut notes) = (Vec::new(), Vec::new(), Vec::new());
        for modelled in modelled {
            let (id, NewView { entry, copy, view }) = modelled?;
            views.push(view.report);
            notes.extend(view.notes);
            new.push(ViewReplacement { id, entry, copy, planes: view.planes });
        }
        let fuser = Fuser::new(self.setup, watch);
        fuser.begin(self.planes_touched(&new)?);
        let stored = self.store.replace_views(new, &fuser)?;
        let (fusion, timings) = (FusionReport::default(), Timings::default());
        Ok((stored, Report { views, fusion, poses: None, refinement: None, notes, timings }))
    }

    /// The number of planes on which a replaced view or its new one has curves.
    fn planes_touched(&self, new: &[Replacement]) -> Result<usize, GrowError> {
        let snapshot = self.store.read()?;
        let mut planes = BTreeSet::new();
        for ViewReplacement { id, planes: curves, .. } in new {
            planes.extend(snapshot.view(id)?.into_iter().flat_map(|view| view.planes));
            planes.extend(curves.iter().filter(|(_, c)| !c.is_empty()).map(|(plane, _)| *plane));
        }
        Ok(planes.len())
    }

    /// Stores views, as many at a time as there are threads, without fusing their planes.
    fn take_in<S: ViewSource>(
        &self,
        sources: &[S],
        watch: &dyn Watch,
        added: &mut Added,
    ) -> Result<(), GrowError> {
        watch.begin(Stage::Views, sources.len());
        for chunk in sources.chunks(rayon::current_num_threads().max(1)) {
            if watch.cancelled() {
                return Err(ReconstructError::Cancelled.into());
            }
            let looked: Vec<_> = chunk.par_iter().map(|source| self.look_at(source)).collect();
            for (source, looked) in chunk.iter().zip(looked) {
                match looked? {
                    Looked::Present => added.present.push(source.name().to_owned()),
                    Looked::New(new) => self.put_in(*new, added)?,
                }
                watch.step(Stage::Views);
            }
        }
        Ok(())
    }

    fn look_at<S: ViewSource>(&self, source: &S) -> Result<Looked, GrowError> {
        let timed = TimedView::load(source)?;
        let snapshot = self.store.read()?;
        if let Some(there) = snapshot.view(&source.id().into())? {
            return match difference(&snapshot, &there.entry, &timed.loaded, source)? {
                None => Ok(Looked::Present),
                Some(what) => Err(GrowError::OtherView { id: source.id().to_owned(), what }),
            };
        }
        Ok(Looked::New(Box::new(self.model(source, timed, None)?)))
    }

    /// Finds the curves of a view. `given` is what it was given, if registration puts it there.
    fn model<S: ViewSource>(
        &self,
        source: &S,
        timed: TimedView,
        given: Option<&Registered>,
    ) -> Result<NewView, GrowError> {
        let loaded = &timed.loaded;
        let entry = ViewDescription {
            id: source.id().into(),
            name: source.name().to_owned(),
            sensor: loaded.view.frame().kind().to_owned(),
            source: source.origin(),
            source_hash: fingerprint(&loaded.view),
            world_from_sensor: *loaded.view.world_from_sensor(),
            sigma: loaded.view.sigma(),
        };
        let sigma = surface_sigma(source, &loaded.view)?;
        let (pose, sigma) = match given {
            None => (entry.world_from_sensor, SurfaceSigma { stated: sigma, registered: None }),
            Some(Registered { given, surface_sigma: SurfaceSigma { stated, .. } }) => {
                (*given, SurfaceSigma { stated: *stated, registered: sigma })
            }
        };
        let kept = KeptImage::of(&loaded.view, &pose, sigma);
        let copy = ViewCopy::of(&kept).ok();
        let view = timed.model(source.name(), self.setup)?;
        Ok(NewView { entry, copy, view })
    }

    fn put_in(&self, new: NewView, added: &mut Added) -> Result<(), GrowError> {
        let NewView { entry, copy, view } = new;
        added.ids.push(entry.id.clone());
        added.reports.push(view.report);
        added.notes.extend(view.notes);
        added.reading += view.reading;
        added.modelling += view.modelling;
        let mut transaction = self.store.begin_view(entry)?;
        copy.map_or(Ok(()), |copy| transaction.set_copy(&copy))?;
        transaction.defer_planes(view.planes)?;
        transaction.commit()?;
        Ok(())
    }

    fn fuse_pending_with<'w>(&self, fuser: Fuser<'w>) -> Result<Fuser<'w>, GrowError>
    where
        'a: 'w,
    {
        fuser.begin(self.store.read()?.pending()?.len());
        self.store.fuse_pending(&fuser)?;
        Ok(fuser)
    }

    fn growth<S: ViewSource>(
        &self,
        sources: &[S],
        added: Added,
        fuser: Fuser<'_>,
        mut timings: Timings,
    ) -> Result<Growth, GrowError> {
        let snapshot = self.store.read()?;
        if snapshot.plane_count()? == 0 && !added.reports.is_empty() {
            return Err(no_curves(added.reports.iter(), self.setup).into());
        }
        let Added { present, reports, ids, mut notes, .. } = added;
        let views = snapshot.views()?;
        let several = views.len() > 1;
        notes.extend(repeated_images(views.iter().map(PlacedImage::from)));
        let started = Instant::now();
        let Judged { poses, note } =
            judged(&snapshot, &ids.iter().cloned().collect(), sources, self.setup)?;
        timings.poses = if poses.is_some() { started.elapsed() } else { Duration::ZERO };
        notes.extend(note);
        let mut fusion = whole_fusion(&snapshot, &fuser)?;
        if !several {
            fusion.forget_comparisons();
        }
        let fused = fuser.summaries().len();
        let mut report =
            Report { views: reports, fusion, poses: None, refinement: None, notes, timings };
        report.set_poses(poses, self.setup.unit);
        Ok(Growth { present, report, fused })
    }
}

/// The fusion report of all planes, including those that were fused earlier.
fn whole_fusion(snapshot: &Snapshot, fuser: &Fuser<'_>) -> Result<FusionReport, StoreError> {
    let mut summaries = fuser.summaries();
    for entry in snapshot.planes()? {
        let (plane, section) = entry?;
        summaries.entry(plane).or_insert_with(|| PlaneSummary::of_curves(section.curves()));
    }
    let observations = snapshot.views()?.iter().map(|view| view.nodes as usize).sum();
    Ok(FusionReport { observations, ..FusionReport::of(&summaries) })
}

/// The difference between a stored view and a loaded one of the same id. Registration of the store
/// makes none.
fn difference(
    snapshot: &Snapshot,
    there: &ViewDescription,
    here: &LoadedView,
    source: &impl ViewSource,
) -> Result<Option<&'static str>, GrowError> {
    if there.source_hash != fingerprint(&here.view) {
        return Ok(Some("another image, sensor or noise"));
    }
    let pose = *here.view.world_from_sensor();
    let registered = Registered::read(snapshot, there)?;
    if there.world_from_sensor != pose && registered.given != pose {
        return Ok(Some("another pose"));
    }
    let same = surface_sigma(source, &here.view)? == registered.surface_sigma.stated;
    Ok((!same).then_some("another surface_sigma"))
}

fn check_ids<S: ViewSource>(sources: &[S]) -> Result<(), GrowError> {
    differ(sources.iter().map(ViewSource::id))
}

fn differ<'s>(ids: impl Iterator<Item = &'s str>) -> Result<(), GrowError> {
    let mut numbers = BTreeMap::new();
    for (second, id) in ids.enumerate() {
        if let Some(first) = numbers.insert(id, second) {
            return Err(GrowError::SameId { id: id.to_owned(), first, second });
        }
    }
    Ok(())
}
