//! The views of a scan, as the modeler takes them.

use transect::{LoadedView, SourceError, ViewSource};
use transect_exchange::ScanView;
use transect_geometry::Isometry3;

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
        Ok(LoadedView { view, notes })
    }
}
