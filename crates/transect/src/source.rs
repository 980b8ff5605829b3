//! The sources of views.

use transect_device::View;

/// An error of a source; any type, since sources are foreign code.
pub type SourceError = Box<dyn std::error::Error + Send + Sync>;

/// A view that can be loaded. It is dropped as soon as its curves are found.
pub trait ViewSource: Sync {
    /// The name of the view in reports.
    fn name(&self) -> &str;

    /// The id of the view in a model store, which differs from all others; by default its name.
    fn id(&self) -> &str {
        self.name()
    }

    /// The origin of the view, which a model store keeps for information; by default its name.
    fn origin(&self) -> String {
        self.name().to_owned()
    }

    /// Loads the view.
    ///
    /// # Errors
    /// The error of the source, which names the file.
    fn load(&self) -> Result<LoadedView, SourceError>;
}

/// A loaded view with the notes of its reader.
#[derive(Debug, Clone)]
pub struct LoadedView {
    /// The view.
    pub view: View,
    /// Notes for the report.
    pub notes: Vec<String>,
}

impl ViewSource for View {
    fn name(&self) -> &str {
        View::name(self)
    }

    fn load(&self) -> Result<LoadedView, SourceError> {
        Ok(LoadedView { view: self.clone(), notes: Vec::new() })
    }
}
