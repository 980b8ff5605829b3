//! A scan on disk, and its views in the form that the modeler takes.

use crate::selection::Limits;
use crate::{Plausibility, Selection, WorkflowError};
use std::path::{Path, PathBuf};
use transect::{LoadedView, SourceError, ViewSource};
use transect_exchange::{OpenOptions, PlanesEntry, Scan, ScanView};
use transect_geometry::Isometry3;

/// A scan on disk. Its small files are read, its images are not.
#[derive(Debug, Clone)]
pub struct OpenScan {
    pub(crate) path: PathBuf,
    pub(crate) scan: Scan,
    pub(crate) selection: Selection,
    pub(crate) limits: Limits,
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
        Ok(Self { path, scan, selection: Selection::default(), limits: Limits::default() })
    }

    /// Its contents.
    pub fn scan(&self) -> &Scan {
        &self.scan
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the scan planes, as if its files stated them, and tells so.
    pub(crate) fn set_planes(&mut self, planes: PlanesEntry, note: String) {
        self.scan.planes = Some(planes);
        self.scan.notes.push(note);
    }
}

/// A view in a file.
#[derive(Debug, Clone)]
pub struct FileView<'a> {
    /// Where its image is.
    pub view: &'a ScanView,
    /// Its name in a model store.
    pub id: String,
    /// The scan that it belongs to.
    pub origin: String,
    /// A pose in place of the scan's own.
    pub pose: Option<Isometry3>,
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
        let (view, notes) = self.view.load()?;
        let view = match &self.pose {
            Some(pose) => view.with_pose(*pose)?,
            None => view,
        };
        let view = self.limits.apply(view)?;
        self.plausibility.check_view(&view)?;
        Ok(LoadedView { view, notes })
    }
}
