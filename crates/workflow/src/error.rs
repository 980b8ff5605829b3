//! Why a workflow failed.

use crate::as_options;
use std::error::Error;
use std::path::{Path, PathBuf};
use transect::evaluate::EvaluateError;
use transect::{GrowError, ReconstructError};
use transect_exchange::{ReadError, WriteError};
use transect_geometry::GuideError;
use transect_model::FileError;
use transect_model::store::StoreError;
use transect_scene::{CastError, MeshError, SceneError, StripeError};
use transect_sensors::SensorError;

/// Why a workflow failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WorkflowError {
    /// A setting has a value that cannot be used.
    #[error("{setting}: {problem}")]
    Setting {
        /// The setting, as the field of its struct is called.
        setting: &'static str,
        /// The value found and the value expected.
        problem: String,
    },
    /// Neither the settings nor the scan state the distance between the planes.
    #[error(
        "the scan does not say how far apart the planes are; state their interval in the settings, or \
         take suggested planes"
    )]
    NoInterval,
    /// The settings describe no family of planes.
    #[error(transparent)]
    Planes(#[from] GuideError),
    /// The system refused to read, write or make a file or a folder.
    #[error("{}: cannot {action}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The refused action: a verb and its object.
        action: &'static str,
        /// The system's reason.
        #[source]
        source: std::io::Error,
    },
    /// A file's content does not serve the purpose.
    #[error("{}: {problem}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// The finding, the expectation, and the remedy.
        problem: String,
    },
    /// A file cannot be used, for the reason that another crate states.
    #[error("{}: {problem}", path.display())]
    Unusable {
        /// The file.
        path: PathBuf,
        /// What cannot be done with it.
        problem: &'static str,
        /// The reason.
        #[source]
        source: Box<dyn Error + Send + Sync>,
    },
    /// Valid input that is most likely wrong.
    #[error("{problem} If the input is right, pass the setting `accept` {check}")]
    Implausible {
        /// The finding, the plausible range, and the likely cause.
        problem: String,
        /// The name of the check; see [`Check`](crate::Check).
        check: &'static str,
    },
    /// Fusion kept no curve.
    #[error(
        "the model is empty: none of the {nodes} nodes of {views} views became a curve. Check the \
         interval of the planes, and the noise (\"sigma\") if a scan.json states it"
    )]
    Empty {
        /// Views of the model.
        views: usize,
        /// Nodes of all views before fusion.
        nodes: usize,
    },
    /// A simulated sensor sees its scene, and the image makes no view.
    #[error("view {view}")]
    SimulatedView {
        /// The name of the view.
        view: String,
        /// The reason.
        #[source]
        source: CastError,
    },
    /// A simulation that cannot be made.
    #[error("{0}")]
    Simulation(String),
    /// A scan, a mesh or a guide could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A result could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A model file could not be loaded or saved.
    #[error(transparent)]
    Model(#[from] FileError),
    /// A store could not be opened, read or written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The views make no model.
    #[error(transparent)]
    Reconstruct(#[from] ReconstructError),
    /// A run into a store failed after it had stored views.
    #[error(
        "{stored} of {all} views are in the store, and stay there. The same command goes on once the \
         cause is mended; the setting `views` leaves views out"
    )]
    Stopped {
        /// Views of the run that are in the store.
        stored: usize,
        /// Views of the run.
        all: usize,
        /// Why the run stopped.
        #[source]
        source: Box<WorkflowError>,
    },
    /// A view of a store cannot be read again, because its scan or its file is not there.
    #[error(
        "{}: view {view} came from the scan {}, and cannot be read again from there. If the scan \
         was moved, take the view from its new place: transect replace-view {} {view:?} SCAN",
        store.display(), scan.display(), store.display()
    )]
    ScanGone {
        /// The store.
        store: PathBuf,
        /// The view.
        view: String,
        /// The scan that the view came from.
        scan: PathBuf,
        /// The error of the scan.
        #[source]
        source: Box<WorkflowError>,
    },
    /// The views cannot be added to the store.
    #[error(transparent)]
    Grow(#[from] GrowError),
    /// The model cannot be scored.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    /// A scene has no surface that can be made.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A scene's surface is no usable mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A simulated sensor has parameters that it cannot have.
    #[error(transparent)]
    Sensor(#[from] SensorError),
    /// The images of a simulated light-stripe sensor cannot be made.
    #[error(transparent)]
    Stripe(#[from] StripeError),
}

impl WorkflowError {
    /// A setting with an unusable value.
    pub(crate) fn setting(setting: &'static str, problem: impl std::fmt::Display) -> Self {
        Self::Setting { setting, problem: problem.to_string() }
    }

    /// A file that does not serve the purpose.
    pub(crate) fn file(path: &Path, problem: impl std::fmt::Display) -> Self {
        Self::File { path: path.to_owned(), problem: problem.to_string() }
    }

    /// For `map_err` of a call that refuses the content of a file.
    pub(crate) fn unusable<E: Error + Send + Sync + 'static>(
        path: &Path,
        problem: &'static str,
    ) -> impl Fn(E) -> Self {
        move |source| Self::Unusable { path: path.to_owned(), problem, source: source.into() }
    }

    /// For `map_err` of a call that does something with a file or a folder.
    pub(crate) fn io(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { path, action, source }
    }
}

/// An error and its causes, one per line, with settings as the command line calls them.
pub fn with_causes(error: &dyn Error) -> String {
    let mut text = as_options(&error.to_string());
    let mut cause = error.source();
    while let Some(error) = cause {
        text.push_str(&format!("\n  because: {}", as_options(&error.to_string())));
        cause = error.source();
    }
    text
}
