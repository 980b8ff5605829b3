//! Where views come from.

use transect_device::View;

/// What can go wrong in somebody else's code.
pub type SourceError = Box<dyn std::error::Error + Send + Sync>;

/// A view that waits to be loaded; it is dropped again as soon as its curves are found.
pub trait ViewSource: Sync {
    /// What reports call the view.
    fn name(&self) -> &str;

    /// What tells the view from all others in a model store; its name, unless said otherwise.
    fn id(&self) -> &str {
        self.name()
    }

    /// Where the view comes from, for whoever asks a model store later; its name, unless said otherwise.
    fn origin(&self) -> String {
        self.name().to_owned()
    }

    /// Loads the view.
    ///
    /// # Errors
    /// Whatever the source finds wrong; it names the file itself.
    fn load(&self) -> Result<LoadedView, SourceError>;
}

/// A loaded view with what its reader found odd.
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
