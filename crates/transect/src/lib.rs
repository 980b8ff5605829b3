//! Registered range images in, cross-section model out.
//!
//! The one decision of this crate: the **whole pipeline fits one screen**, see [`reconstruct`]; the
//! steps are in the crates it calls. It knows neither file formats nor sensors: views come through
//! [`ViewSource`], progress and cancelling go through [`Watch`].
//!
//! * [`reconstruct`], [`Setup`], [`Report`]: the modeler;
//! * [`Refinement`]: more planes where the curves of neighbouring planes differ;
//! * [`Grower`]: the same, view by view into a model store that survives crashes and lets views
//!   leave;
//! * [`evaluate`]: how accurate a model is, against sections that are known.
//!
//! One line in `Cargo.toml` is enough. The crates below are modules here: [`device`] (images and
//! views), [`geometry`] (planes and curves), [`model`] (the result and its store), [`image`] (noise
//! and smoothing), and [`register`] (poses). So are [`partial`] and [`fusion`] (the two steps and
//! their options), and [`nalgebra`], whose vectors and poses they share. Three more are features:
//!
//! | feature | module | contents |
//! |---|---|---|
//! | `sensors` (default) | `sensors` | pinhole camera, spherical scanner, light stripe, and others |
//! | `files` | `files` | scans from disk; curves, drawings and pictures to disk |
//! | `scene` | `scene` | simulated scans of scenes whose sections are known exactly |
//!
//! ```
//! use std::sync::Arc;
//! use transect::sensors::{Intrinsics, Pinhole};
//! use transect::{
//!     ImageSize, Isometry3, LengthUnit, PlaneFamily, RangeImage, Setup, StraightGuide, Unwatched,
//!     Vector3, View, reconstruct,
//! };
//!
//! // A depth camera looks straight down on a floor, 2 m away.
//! let size = ImageSize { rows: 48, cols: 64 };
//! let camera = Pinhole::new(size, Intrinsics { fx: 60.0, fy: 60.0, cx: 31.5, cy: 23.5 })?;
//! let image = RangeImage::from_values(size, vec![2.0; size.pixels()])?;
//! let world_from_sensor = Isometry3::translation(0.0, 0.0, 5.0);
//! let view = View::new("floor", image, Arc::new(camera), world_from_sensor, None)?;
//!
//! // Sections every 10 cm across the camera's x axis.
//! let guide = StraightGuide::along(Vector3::x())?;
//! let setup = Setup::new(LengthUnit::Metre, PlaneFamily::new(guide, 0.0, 0.1)?);
//! let result = reconstruct(&[view], &setup, &Unwatched)?;
//!
//! // Each section is one straight curve at z = 5 m + 2 m.
//! assert_eq!(result.report.fusion.planes, 21);
//! for (plane, section) in result.model.sections() {
//!     let frame = result.model.planes().frame(plane);
//!     let curve = section.curves().next().ok_or("a section without a curve")?;
//!     for node in curve.nodes() {
//!         assert!((frame.world_from_plane(&node.position).z - 7.0).abs() < 1e-6);
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(doctest)]
mod doc_tests;
mod error;
pub mod evaluate;
mod fingerprint;
mod fused;
mod grow;
mod modelled_view;
mod options;
mod packed;
mod pipeline;
mod pose_error;
mod poses;
mod refine;
mod refinement;
mod repeated;
mod report;
mod seen_through;
mod settings;
mod setup;
mod source;
mod timed_view;
mod watch;

pub use error::ReconstructError;
pub use grow::{GrowError, Grower, Growth, correct_by_free_space};
pub use options::OptionError;
pub use pipeline::{Reconstruction, reconstruct};
pub use poses::PoseReport;
pub use refine::{DifferenceReason, RefinedGap, RefinementReport};
pub use refinement::{Refinement, RefinementError};
pub use report::{FusionReport, Report, Timings, ViewReport};
pub use seen_through::{Seen, Witness, without_seen_through};
pub use settings::SettingsError;
pub use setup::Setup;
pub use source::{LoadedView, Posed, SourceError, ViewSource};
pub use watch::{Stage, Unwatched, Watch};

pub use nalgebra;
pub use transect_device as device;
#[cfg(feature = "files")]
pub use transect_exchange as files;
pub use transect_fusion as fusion;
pub use transect_geometry as geometry;
pub use transect_image as image;
pub use transect_model as model;
pub use transect_partial as partial;
pub use transect_register as register;
#[cfg(feature = "scene")]
pub use transect_scene as scene;
#[cfg(feature = "sensors")]
pub use transect_sensors as sensors;

pub use device::{ImageSize, Isometry3, RangeImage, Vector3, View};
pub use geometry::{Curve, LengthUnit, PlaneFamily, PlaneIndex, StraightGuide};
pub use model::Model;
