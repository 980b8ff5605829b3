//! A scan on disk, made into a cross-section model or a model store, with its results on disk.
//!
//! This crate lies between files and the engine: `transect-exchange` reads and writes files,
//! `transect` makes models, and this crate does the one after the other. The command line is built
//! on it, and so can be any other program for users. It knows no terminal: progress goes through
//! [`Watch`](transect::Watch), and every failure is a [`WorkflowError`].
//!
//! * [`OpenScan`], [`Settings`], [`Run`], [`ResultFolder`]: from a scan to results;
//! * [`Selection`]: the part of a scan that is used;
//! * [`ViewSurvey`], [`Suggestion`]: what a scan holds, and section planes that fit it;
//! * [`Registration`]: the poses of a scan, refined;
//! * [`StoreFile`], [`ModelFile`]: models on disk, in a store or in a plain file;
//! * [`score()`]: the accuracy of a model, against a mesh or the truth of a simulated scan;
//! * [`explain`]: the steps of the methods as figures;
//! * [`simulation`]: a simulated scene as a scan folder;
//! * [`table`]: the rows that all of these report.
//!
//! ```
//! use transect::Unwatched;
//! use transect_exchange::OpenOptions;
//! use transect_workflow::simulation::{PreparedScene, SensorPlan, StripeImages};
//! use transect_workflow::{ModelFile, OpenScan, ResultFolder, Settings};
//!
//! // A scan to begin with: a ball, seen by one depth camera.
//! let scene = r#"
//!     name = "ball"
//!     unit = "mm"
//!     planes = { normal = [0, 0, 1], offset = 0.5, interval = 4 }
//!     [[solid]]
//!     shape = "ball"
//!     radius = 20
//!     at = [0, 0, 0]
//!     [[station]]
//!     name = "front"
//!     sensor = "pinhole"
//!     rows = 60
//!     cols = 60
//!     field_of_view = 30
//!     at = [0, -100, 0]
//!     look_at = [0, 0, 0]
//! "#;
//! let folder = tempfile::tempdir()?;
//! let scene = PreparedScene::new(transect_scene::Description::parse(scene)?)?;
//! let simulated = scene.simulate(&SensorPlan::OWN)?;
//! simulated.write(&scene, StripeImages::Extracted, &folder.path().join("scan"))?;
//!
//! // Open it, choose settings, make the model, write everything.
//! let scan = OpenScan::open(folder.path().join("scan"), &OpenOptions::default())?;
//! let mut settings = Settings::default();
//! settings.planes.interval = Some("2mm".parse()?);
//! let results = ResultFolder::new(folder.path().join("out"));
//! let table = scan.reconstruct(&settings, &Unwatched)?.write(&results)?;
//!
//! // Nineteen planes cross the ball; its back was not seen, so their curves are open.
//! let planes = table.iter().find(|row| row.metric == "planes with curves");
//! assert_eq!(planes.map(|row| row.value.as_str()), Some("19"));
//! let model = ModelFile::open(results.path())?.into_model()?;
//! assert!(model.sections().all(|(_, section)| section.open_curve_count() == 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod align;
mod camera;
mod costs;
mod error;
pub mod explain;
mod faces;
mod far_away;
mod method_settings;
mod model_file;
mod outputs;
mod plausible;
mod refine_settings;
mod register;
mod report_file;
mod results;
mod run;
mod samples;
mod score;
mod selection;
mod settings;
pub mod simulation;
mod store_file;
mod suggest;
mod survey;
pub mod table;
mod truth;
mod views;
mod wording;

pub use align::{AlignmentScans, SphereFile};
pub use costs::{Costs, StageCost, peak_memory_mib};
pub use error::{WorkflowError, with_causes};
pub use method_settings::{JumpSetting, MethodSettings};
pub use model_file::{ModelFile, OpenStore};
pub use outputs::{claim_lines, claim_manifest};
pub use plausible::Check;
pub(crate) use plausible::Plausibility;
pub use refine_settings::{PriorSettings, RefineSettings};
pub use register::Registration;
use report_file::ReportFile;
pub use results::{ResultFolder, default_folder, find_model, is_model};
pub use run::Run;
pub use score::{Reference, Score, ScoreLimits, score, simulated_accuracy};
pub use selection::{CropBox, Selection, ViewList};
pub use settings::{GuideSettings, PlaneSettings, Settings};
pub use store_file::{Replaced, Replacement, StoreFile, open_store, read_store, setup_of};
pub use suggest::Suggestion;
pub use survey::{SensorClass, ViewSurvey};
pub use truth::TruthOfResults;
pub(crate) use views::FileView;
pub use views::OpenScan;
pub use wording::as_options;
