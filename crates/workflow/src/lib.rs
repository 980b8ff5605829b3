//! A scan on disk, made into a cross-section model or a model store, with its results on disk.
mod costs;
mod error;
mod model_file;
mod report_file;
mod results;
mod run;
mod score;
mod settings;
pub mod simulation;
mod store_file;
pub mod table;
mod views;

pub use costs::{Costs, StageCost, peak_memory_mib};
pub use error::{WorkflowError, with_causes};
pub use model_file::{ModelFile, OpenStore, is_model};
use report_file::ReportFile;
pub use results::{ResultFolder, default_folder, dxf_frame, find_model};
pub use run::{OpenScan, Run};
pub use score::{Reference, Score, ScoreLimits, score};
pub use settings::{
    GuideSettings, PlaneSettings, Settings, fusion_method, fusion_methods, parse_length,
    partial_method, partial_methods,
};
pub use store_file::{Replaced, Replacement, StoreFile, open_store, setup_of};
pub use views::FileView;
