//! Views in, cross-section model out.
//!
//! The one decision of this crate: the **whole pipeline fits one screen**, see [`reconstruct`]; all
//! else is in the crates it calls. It refuses to know file formats and sensors: views come through
//! [`ViewSource`], progress and cancelling go through [`Watch`].
//!
//! * [`reconstruct`], [`Setup`], [`Report`]: the modeler;
//! * [`Refinement`]: more planes where the curves of neighbouring planes differ;
//! * [`Grower`]: the same, view by view into a model store that survives crashes and lets views leave;
//! * [`evaluate`]: how accurate a model is, against sections that are known.
//!
//! ```
//! use std::sync::Arc;
//! use transect::{Setup, Unwatched, reconstruct};
//! use transect_device::{DeviceFrame, ImageSize, Isometry3, Pixel, RangeImage, SensorPlane, Vector3, View};
//! use transect_geometry::{LengthUnit, PlaneFamily, StraightGuide};
//! use transect_sensors::{Intrinsics, Pinhole};
//!
//! // A camera one metre above a floor that it looks at under 45°.
//! let size = ImageSize { rows: 48, cols: 64 };
//! let camera = Pinhole::new(size, Intrinsics { fx: 60.0, fy: 60.0, cx: 31.5, cy: 23.5 })?;
//! let floor = SensorPlane { normal: Vector3::new(0.0, 1.0, 1.0).normalize(), offset: 1.0 };
//! let pixels = (0..48).flat_map(|row| (0..64).map(move |col| Pixel::new(row, col)));
//! let depths = pixels.map(|p| camera.plane_value(p, &floor).unwrap_or(f64::NAN) as f32).collect();
//! let image = RangeImage::from_values(size, depths)?;
//! let view = View::new("floor", image, Arc::new(camera), Isometry3::identity(), Some(0.0))?;
//!
//! // Sections every 10 cm across the camera's x axis.
//! let guide = StraightGuide::along(Vector3::x())?;
//! let setup = Setup::new(LengthUnit::Metre, PlaneFamily::new(guide, 0.0, 0.1)?);
//! let result = reconstruct(&[view], &setup, &Unwatched)?;
//! assert!(result.model.sections().all(|(_, section)| section.curves().len() == 1));
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
mod pipeline;
mod refine;
mod refinement;
mod report;
mod settings;
mod setup;
mod source;
mod watch;

pub use error::ReconstructError;
pub use grow::{GrowError, Grower, Growth};
pub use pipeline::{Reconstruction, reconstruct};
pub use refine::{DifferenceReason, RefinedGap, RefinementReport};
pub use refinement::{Refinement, RefinementError};
pub use report::{FusionReport, Report, Timings, ViewReport};
pub use settings::SettingsError;
pub use setup::Setup;
pub use source::{LoadedView, SourceError, ViewSource};
pub use watch::{Stage, Unwatched, Watch};
