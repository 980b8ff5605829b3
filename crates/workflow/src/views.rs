//! A scan on disk, and its views in the form that the modeler takes.

use crate::plausible::ReadView;
use crate::selection::Limits;
use crate::{Plausibility, Selection, WorkflowError};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use transect::register::{PosePrior, PoseReading};
use transect::{LoadedView, SourceError, ViewSource};
use transect_device::{ImageOrder, Note};
use transect_exchange::{OpenOptions, PlanesEntry, PoseSigma, Scan, ScanView};
use transect_geometry::Isometry3;

/// A scan on disk. Its small files are read, its images are not.
#[derive(Debug, Clone)]
pub struct OpenScan {
    pub(crate) path: PathBuf,
    pub(crate) scan: Scan,
    pub(crate) selection: Selection,
    pub(crate) limits: Limits,
    pub(crate) options: OpenOptions,
    /// The convention by which the poses were read, if it is not the scan's own.
    pub(crate) reading: Option<PoseReading>,
    /// The poses as the files state them, one for each view, if a convention was asked for.
    stated: Vec<Isometry3>,
}

impl OpenScan {
    /// Opens a scan; see [`Scan::open_with`] for the kinds of scan.
    ///
    /// # Errors
    /// [`WorkflowError::Read`] if the path is no scan, a file is missing or damaged, or the unit is
    /// missing or is not the scan's.
    pub fn open(path: impl Into<PathBuf>, options: &OpenOptions) -> Result<Self, WorkflowError> {
        let path = path.into();
        let scan = Scan::open_with(&path, options)?;
        Ok(Self {
            path,
            scan,
            selection: Selection::default(),
            limits: Limits::default(),
            options: options.clone(),
            reading: None,
            stated: Vec::new(),
        })
    }

    /// The scan with its poses read by another convention. Call it before [`OpenScan::select`].
    pub fn with_reading(mut self, reading: PoseReading) -> Self {
        self.stated = self.scan.views.iter().map(|view| *view.world_from_sensor()).collect();
        let read = |view: ScanView| {
            let pose = reading.apply(view.world_from_sensor());
            view.with_pose(pose)
        };
        self.scan.views = std::mem::take(&mut self.scan.views).into_iter().map(read).collect();
        let text = format!("poses are read as asked for: {}", reading.meaning());
        self.scan.notes.push(Note::new(text));
        self.reading = Some(reading);
        self
    }

    /// Its contents.
    pub fn scan(&self) -> &Scan {
        &self.scan
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The part of the scan that a selection names. Notes tell how many views are left out.
    ///
    /// # Errors
    /// [`WorkflowError`] if the selection names no view, or no view has a point within its limits.
    pub fn select(mut self, selection: &Selection) -> Result<Self, WorkflowError> {
        let numbers = selection.numbers(self.scan())?;
        self.limits = selection.limits(self.scan().unit)?;
        self.selection = selection.clone();
        let all = self.scan.views.len();
        self.scan.views = numbers.iter().map(|&k| self.scan.views[k].clone()).collect();
        self.stated = numbers.iter().filter_map(|&k| self.stated.get(k).copied()).collect();
        if numbers.len() < all {
            let note = format!("{} of {all} views are used, as asked for", numbers.len());
            self.scan.notes.push(Note::new(note));
        }
        if self.limits != Limits::default() {
            self.leave_out_empty_views()?;
        }
        Ok(self)
    }

    /// Leaves out the views without a point within the limits. A view that cannot be read stays:
    /// the run reports it.
    fn leave_out_empty_views(&mut self) -> Result<(), WorkflowError> {
        let limits = self.limits;
        let has_points = |view: &ScanView| match view.load() {
            Ok((view, _)) => limits.apply(view).is_ok(),
            Err(_) => true,
        };
        let kept: Vec<bool> = self.scan.views.par_iter().map(has_points).collect();
        let named = self.scan.views.iter().zip(&kept).filter(|(_, kept)| !**kept);
        let empty: Vec<&str> = named.map(|(view, _)| view.name()).collect();
        if empty.is_empty() {
            return Ok(());
        }
        let (count, names) = (empty.len(), empty.join(", "));
        let note = format!("{count} views left out, without a point within the limits: {names}");
        if count == kept.len() {
            let problem = "no view has a point within the limits; inspect shows the scan's extent \
                           and ranges";
            return Err(WorkflowError::file(&self.path, problem));
        }
        self.scan.notes.push(Note::new(note));
        let mut keep = kept.iter();
        self.stated.retain(|_| keep.next().copied().unwrap_or(true));
        let mut keep = kept.iter();
        self.scan.views.retain(|_| keep.next().copied().unwrap_or(true));
        Ok(())
    }

    /// The pose of a view as its file states it, and the convention by which it was read instead.
    pub(crate) fn stated_pose(&self, view: usize) -> Option<(PoseReading, Isometry3)> {
        self.reading.zip(self.stated.get(view).copied())
    }

    /// Gives the scan planes, as if its files stated them, and tells so.
    pub(crate) fn set_planes(&mut self, planes: PlanesEntry, note: Note) {
        self.scan.planes = Some(planes);
        self.scan.notes.push(note);
    }
}

/// A view in a file.
#[derive(Debug, Clone)]
pub(crate) struct FileView<'a> {
    /// Where its image is.
    pub view: &'a ScanView,
    /// Its name in a model store.
    pub id: String,
    /// The scan that it belongs to.
    pub origin: String,
    /// A pose in place of the scan's own.
    pub pose: Option<Isometry3>,
    /// The convention by which the user had the pose read, and the pose as the file states it.
    pub(crate) stated_pose: Option<(PoseReading, Isometry3)>,
    /// The view, if it has been read already and not been loaded since.
    pub(crate) read: Arc<Mutex<Option<ReadView>>>,
    /// The limits of its points.
    pub(crate) limits: Limits,
    /// The checks that it must pass.
    pub plausibility: Plausibility,
}

impl ViewSource for FileView<'_> {
    fn name(&self) -> &str {
        self.view.name()
    }

    fn id(&self) -> &str {
        &self.id
    }

    fn origin(&self) -> String {
        self.origin.clone()
    }

    fn load(&self) -> Result<LoadedView, SourceError> {
        let read = self.read.lock().ok().and_then(|mut read| read.take());
        self.finish(read.map_or_else(|| self.view.load(), Ok)?)
    }

    fn pose_prior(&self) -> Option<PosePrior> {
        let PoseSigma { rotation, translation } = self.view.pose_sigma()?;
        Some(PosePrior { rotation, translation })
    }

    fn surface_sigma(&self) -> Option<f64> {
        // It is the error of the scan's own pose.
        self.view.surface_sigma().filter(|_| self.pose.is_none())
    }

    fn stated_pose(&self) -> Option<(PoseReading, Isometry3)> {
        self.stated_pose
    }

    fn load_in(&self, order: ImageOrder) -> Option<Result<LoadedView, SourceError>> {
        let view = self.view.in_order(order)?;
        Some(view.load().map_err(SourceError::from).and_then(|read| self.finish(read)))
    }
}

impl FileView<'_> {
    /// The view at its pose, within its limits, if it is plausible.
    fn finish(&self, (view, notes): ReadView) -> Result<LoadedView, SourceError> {
        let view = match &self.pose {
            Some(pose) => view.with_pose(*pose)?,
            None => view,
        };
        self.plausibility.check_valid_pixels(&view)?;
        let view = self.limits.apply(view)?;
        self.plausibility.check_view(&view)?;
        Ok(LoadedView { view, notes })
    }
}
