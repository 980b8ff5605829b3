//! Model stores on disk: opening one, growing it by a scan, removing and replacing its views.

use crate::results::find_model;
use crate::selection::Limits;
use crate::{Check, FileView, Plausibility, PriorSettings, WorkflowError};
use std::collections::BTreeSet;
use std::collections::btree_map::{BTreeMap, Entry};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect::{
    GrowError, Grower, Growth, ReconstructError, Reconstruction, Report, Setup, Unwatched, Watch,
};
use transect_exchange::{OpenOptions, ReadError, Scan, ScanView};
use transect_geometry::Isometry3;
use transect_model::store::{Store, StoreError, StoreHeader, StoreProblem, StoredView, ViewId};
use transect_model::{CodecError, SCHEMA_VERSION};

/// Names of a scan's views in a message. By hand: they fill two lines.
const NAMES: usize = 20;

/// A store with the settings that it was made with; every plane of it is fused.
#[derive(Debug)]
pub struct StoreFile {
    path: PathBuf,
    store: Store,
    setup: Setup,
    planes_finished: usize,
}

/// The image or the pose that takes the place of a view's own.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Replacement {
    /// Scan to take the view from. Without it, the scan that the view came from.
    pub scan: Option<PathBuf>,
    /// The view's name in that scan. Without it, the name that the view had in its own scan.
    pub view: Option<String>,
    /// Pose in place of the scan's own.
    pub pose: Option<Isometry3>,
    /// Checks of plausibility that are turned off.
    pub accept: Vec<Check>,
}

/// The effect of replacing views.
#[derive(Debug, Clone, PartialEq)]
pub struct Replaced {
    /// The views that were replaced, as they are now.
    pub views: Vec<StoredView>,
    /// Planes that were fused anew: those that an old view or its new one has curves on.
    pub planes_fused: usize,
    /// The new views' report, with notes and warnings.
    pub report: Report,
}

impl StoreFile {
    /// Opens a store, and fuses the planes that an interrupted run left.
    ///
    /// # Errors
    /// [`WorkflowError`] if the file is no store, is damaged or in use, or was made with options
    /// that this program does not have.
    pub fn open(path: &Path) -> Result<Self, WorkflowError> {
        let path = find_model(path)?;
        let store = open_store(&path)?;
        let planes_finished = finish(&path, &store)?;
        let setup = setup_of(&path, store.read()?.header())?;
        Ok(Self { path, store, setup, planes_finished })
    }

    /// The store itself.
    pub fn store(&self) -> &Store {
        &self.store
    }

    /// Planes that an interrupted run had left and opening fused.
    pub fn planes_finished(&self) -> usize {
        self.planes_finished
    }

    /// The view of a name.
    ///
    /// # Errors
    /// [`WorkflowError::File`] with the names most like it if no view has the name.
    fn view_named(&self, name: &str) -> Result<ViewId, WorkflowError> {
        let mut names: Vec<String> =
            self.store.views()?.into_iter().map(|view| view.entry.id.0).collect();
        if names.iter().any(|there| there == name) {
            return Ok(name.into());
        }
        names.sort_by_key(|there| strsim::levenshtein(there, name));
        names.truncate(5);
        let near = if names.is_empty() {
            "none, the store has no views".to_owned()
        } else {
            names.join(", ")
        };
        let problem = format!("no view {name:?}; the names most like it: {near}");
        Err(WorkflowError::file(&self.path, problem))
    }

    /// Removes a view; the store is then as if the view had never been added.
    ///
    /// # Errors
    /// [`WorkflowError`] if no view has the name, or the store cannot be written.
    pub fn remove_view(&self, name: &str) -> Result<StoredView, WorkflowError> {
        let id = self.view_named(name)?;
        Ok(Grower::new(&self.store, &self.setup)?.remove_view(&id)?)
    }

    /// Puts a new image or a new pose in a view's place; the view keeps its name.
    ///
    /// # Errors
    /// [`WorkflowError`] if no view has the name, the scan or the view in it cannot be read, or the
    /// store cannot be written. The store is unchanged then.
    pub fn replace_view(
        &self,
        name: &str,
        replacement: &Replacement,
    ) -> Result<Replaced, WorkflowError> {
        let id = self.view_named(name)?;
        let missing = || WorkflowError::file(&self.path, format!("view {name:?} has been removed"));
        let old = self.store.read()?.view(&id)?.ok_or_else(missing)?;
        let scan_path = replacement.scan.clone().unwrap_or_else(|| old.entry.source.clone().into());
        // The user knows a scan that was named in the command.
        let own = |error| match &replacement.scan {
            Some(_) => error,
            None => self.scan_gone(name, &scan_path, error),
        };
        let scan = self.scan_of(&scan_path).map_err(own)?;
        let in_scan = replacement.view.as_deref().unwrap_or(&old.entry.name);
        let view = self.view_of_scan(&scan, &scan_path, in_scan).map_err(own)?;
        let accepted = replacement.accept.clone();
        let interval = self.setup.planes.interval();
        let unit = self.setup.unit;
        let plausibility = Plausibility { interval, unit, accepted, usual_spacing: None };
        let source = FileView {
            id: id.0.clone(),
            pose: replacement.pose,
            ..origin(view, &scan_path, plausibility)
        };
        let grower = Grower::new(&self.store, &self.setup)?;
        let (views, mut report) = grower.replace_views(&[(id, source)], &Unwatched)?;
        report.notes.splice(0..0, scan.notes.iter().cloned());
        let new = views.iter().flat_map(|view| &view.planes);
        let planes_fused = old.planes.iter().chain(new).collect::<BTreeSet<_>>().len();
        Ok(Replaced { planes_fused, views, report })
    }

    /// Refines the poses of all views together. Views that move, or of which registration tells
    /// another error, are replaced in one transaction. The planes that they touch are fused anew.
    ///
    /// # Errors
    /// [`WorkflowError`] if the store cannot be written. Also if a view cannot be read from its
    /// scan, or has another image than the store. The store is unchanged then.
    pub fn register(
        &self,
        prior: Option<PriorSettings>,
        accept: &[Check],
        watch: &dyn Watch,
    ) -> Result<Replaced, WorkflowError> {
        let unit = self.setup.unit;
        let (options, stored) = (PriorSettings::options(prior, unit), self.store.views()?);
        let scans = self.scans_of(&stored)?;
        let source = |StoredView { entry, .. }: &StoredView| {
            let path = Path::new(&entry.source);
            let view = self.view_of_scan(&scans[entry.source.as_str()], path, &entry.name);
            let view = view.map_err(|error| self.scan_gone(&entry.id.0, path, error))?;
            let plausibility = Plausibility::without_planes(unit, accept);
            Ok(FileView { id: entry.id.0.clone(), ..origin(view, path, plausibility) })
        };
        let sources: Result<Vec<_>, WorkflowError> = stored.iter().map(source).collect();
        let sources = sources?;
        let grower = Grower::new(&self.store, &self.setup)?;
        let (views, report) = grower.refine_poses(&sources, &options, watch)?;
        let old = stored.iter().filter(|old| views.iter().any(|new| new.entry.id == old.entry.id));
        let planes: BTreeSet<_> = old.chain(&views).flat_map(|view| &view.planes).collect();
        let planes_fused = planes.len();
        Ok(Replaced { planes_fused, report, views })
    }

    /// The scans that views came from, by their paths.
    fn scans_of<'v>(
        &self,
        views: &'v [StoredView],
    ) -> Result<BTreeMap<&'v str, Scan>, WorkflowError> {
        let mut scans = BTreeMap::new();
        for StoredView { entry, .. } in views {
            let path = Path::new(&entry.source);
            if let Entry::Vacant(place) = scans.entry(entry.source.as_str()) {
                let scan = self.scan_of(path);
                place.insert(scan.map_err(|error| self.scan_gone(&entry.id.0, path, error))?);
            }
        }
        Ok(scans)
    }

    /// The error of a view whose own scan does not give it any more.
    fn scan_gone(&self, view: &str, scan: &Path, source: WorkflowError) -> WorkflowError {
        let (store, scan) = (self.path.clone(), scan.to_owned());
        WorkflowError::ScanGone { store, view: view.to_owned(), scan, source: Box::new(source) }
    }

    /// The scan at a path, of which views may lack their files. A scan that does not state its unit
    /// is taken to have the store's. One of another unit is refused.
    fn scan_of(&self, path: &Path) -> Result<Scan, WorkflowError> {
        let mut options = OpenOptions::default();
        (options.unit, options.skip_missing) = (Some(self.setup.unit), true);
        Scan::open_with(path, &options).map_err(|error| match error {
            // The unit that is asked for is the store's. The user asked for nothing.
            ReadError::UnitConflict { path, stated, asked } => {
                let problem = "its views cannot be taken into the store";
                let units = GrowError::OtherUnit { there: asked, here: stated };
                WorkflowError::unusable(&path, problem)(units)
            }
            error => error.into(),
        })
    }

    /// The view of a name in a scan of [`Self::scan_of`].
    fn view_of_scan<'s>(
        &self,
        scan: &'s Scan,
        path: &Path,
        name: &str,
    ) -> Result<&'s ScanView, WorkflowError> {
        if let Some(view) = scan.views.iter().find(|view| view.name() == name) {
            return Ok(view);
        }
        // The view may have been left out because its file is missing. This error says so.
        let mut options = OpenOptions::default();
        options.unit = Some(self.setup.unit);
        match Scan::open_with(path, &options) {
            // No command of a store leaves views out.
            Err(ReadError::MissingFiles { count, views, names, .. }) => {
                let problem = format!(
                    "{count} of {views} views have no file: {names}; put the files there, or \
                     correct their names"
                );
                return Err(WorkflowError::file(path, problem));
            }
            other => other?,
        };
        let names: Vec<&str> = scan.views.iter().take(NAMES).map(ScanView::name).collect();
        let others = match scan.views.len() - names.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let problem = format!("no view {name:?}; it has {}{others}", names.join(", "));
        Err(WorkflowError::file(path, problem))
    }

    /// Closes the store; what was changed is on disk then.
    ///
    /// # Errors
    /// [`WorkflowError::Store`] if the file cannot be written.
    pub fn close(self) -> Result<(), WorkflowError> {
        Ok(self.store.close()?)
    }
}

/// Opens a store for changes. The error of a file of another kind says what to do.
///
/// # Errors
/// [`WorkflowError`] if the file is no store, is damaged, or is in use.
pub fn open_store(path: &Path) -> Result<Store, WorkflowError> {
    let path = &find_model(path)?;
    Store::open(path).map_err(|error| store_error(path, error))
}

/// Opens a store for reading; its file is not written ([`Store::open_read_only`]).
///
/// # Errors
/// [`WorkflowError`] if the file is no store, is damaged, or is being changed.
pub fn read_store(path: &Path) -> Result<Store, WorkflowError> {
    let path = &find_model(path)?;
    Store::open_read_only(path).map_err(|error| store_error(path, error))
}

fn store_error(path: &Path, error: StoreError) -> WorkflowError {
    match error.problem {
        StoreProblem::Damaged(CodecError::WrongVersion { found: SCHEMA_VERSION, .. }) => {
            let problem = "a plain model file: its views cannot be listed or changed; make a model \
                           store with reconstruct --store FILE";
            WorkflowError::file(path, problem)
        }
        _ => error.into(),
    }
}

/// Fuses the planes that an interrupted run left; returns their number.
pub(crate) fn finish(path: &Path, store: &Store) -> Result<usize, WorkflowError> {
    let waiting = store.read()?.pending()?.len();
    if waiting > 0 {
        let setup = setup_of(path, store.read()?.header())?;
        Grower::new(store, &setup)?.fuse_pending(&Unwatched)?;
    }
    Ok(waiting)
}

/// The settings that a store was made with.
///
/// # Errors
/// [`WorkflowError::Unusable`] if this program does not have its options.
pub fn setup_of(path: &Path, header: &StoreHeader) -> Result<Setup, WorkflowError> {
    Setup::of_store(header).map_err(WorkflowError::unusable(path, "the store cannot be used"))
}

/// A store that grew by a scan.
pub(crate) struct Grown {
    pub reconstruction: Reconstruction,
    pub views_present: usize,
    pub planes_fused: usize,
}

/// Adds the views of a scan to a store, which is made if it is not there.
pub(crate) fn grow(
    path: &Path,
    views: &[FileView<'_>],
    setup: &Setup,
    watch: &dyn Watch,
) -> Result<Grown, WorkflowError> {
    let is_new = !path.exists();
    let store = if is_new { create(path, setup)? } else { open_store(path)? };
    let grown = Grower::new(&store, setup).and_then(|grower| grower.add_views(views, watch));
    let Growth { present, report, fused, .. } = match grown {
        Ok(grown) => grown,
        Err(error) => {
            let useless = is_new && is_useless(&store, &error);
            let error = grow_error(path, &store, views, error);
            drop(store);
            if useless {
                std::fs::remove_file(path)
                    .map_err(WorkflowError::io("remove the new store", path))?;
            }
            return Err(error);
        }
    };
    let model = store.read()?.model()?;
    store.close()?;
    let reconstruction = Reconstruction { model, report };
    Ok(Grown { reconstruction, views_present: present.len(), planes_fused: fused })
}

/// The error of a run into a store. Views before the one that failed are in the store.
fn grow_error(
    path: &Path,
    store: &Store,
    views: &[FileView<'_>],
    error: GrowError,
) -> WorkflowError {
    match error {
        GrowError::View(
            error @ (ReconstructError::Load { .. } | ReconstructError::Partial { .. }),
        ) => stopped(store, views, error.into()),
        GrowError::View(error) => error.into(),
        GrowError::Store(error) => stopped(store, views, error.into()),
        error @ (GrowError::OtherSettings(_) | GrowError::OtherUnit { .. }) => {
            WorkflowError::unusable(path, "the store cannot grow")(error)
        }
        error => error.into(),
    }
}

/// The error, with the number of the run's views that are in the store.
fn stopped(store: &Store, views: &[FileView<'_>], source: WorkflowError) -> WorkflowError {
    let there = store.views().unwrap_or_default();
    let ids: BTreeSet<&str> = there.iter().map(|view| view.entry.id.0.as_str()).collect();
    match views.iter().filter(|view| ids.contains(view.id.as_str())).count() {
        0 => source,
        stored => WorkflowError::Stopped { stored, all: views.len(), source: Box::new(source) },
    }
}

/// Whether a new store stands in the way of the next attempt: it has no views, or its planes, which
/// are fixed, miss them all.
fn is_useless(store: &Store, error: &GrowError) -> bool {
    use ReconstructError::{NoCurves, Nothing, OffGuide};
    let misses =
        matches!(error, GrowError::View(Nothing { .. } | NoCurves { .. } | OffGuide { .. }));
    misses || store.views().is_ok_and(|views| views.is_empty())
}

fn create(path: &Path, setup: &Setup) -> Result<Store, WorkflowError> {
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(WorkflowError::io("make the folder", folder))?;
    }
    Ok(Store::create(path, &setup.store_header())?)
}

/// A view of the scan at a path, under its own name.
pub(crate) fn origin<'a>(
    view: &'a ScanView,
    scan: &Path,
    plausibility: Plausibility,
) -> FileView<'a> {
    let absolute = std::path::absolute(scan).unwrap_or_else(|_| scan.to_owned());
    let origin = absolute.display().to_string();
    let (id, limits) = (view.name().to_owned(), Limits::default());
    let read = Arc::default();
    FileView { view, id, origin, pose: None, stated_pose: None, read, limits, plausibility }
}
