//! A scan on disk, and its views in the form that the modeler takes.

use crate::{Plausibility, WorkflowError};
use std::path::{Path, PathBuf};
use transect::{LoadedView, SourceError, ViewSource};
use transect_exchange::{OpenOptions, Scan, ScanView};
use transect_geometry::Isometry3;

/// A scan on disk. Its small files are read, its images are not.
#[derive(Debug, Clone)]
pub struct OpenScan {
    path: PathBuf,
    scan: Scan,
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
        Ok(Self { path, scan })
    }

    /// Its contents.
    pub fn scan(&self) -> &Scan {
        &self.scan
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
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
        self.plausibility.check_view(&view)?;
        Ok(LoadedView { view, notes })
    }
}
