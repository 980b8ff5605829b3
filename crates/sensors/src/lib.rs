//! Device frames of range sensors, one module each, all behind [`transect_device::DeviceFrame`].
//!
//! The one decision of this crate: a backend is **parameters plus equations**. It does not know
//! where a sensor's numbers come from: a file, a calibration or a simulation.
//!
//! The crate knows neither files nor curves, and its modules do not know each other.
//!
//! | module | sensor | `d3` | inverse `F` |
//! |---|---|---|---|
//! | [`imaging_radar`] | two scanning angles and a range: every terrestrial laser scanner | range | yes |
//! | [`light_stripe`] | a laser sheet turned by a mirror, watched by a camera | the stripe's place in its camera row | yes |
//! | [`lookup_table`] | one scanning angle on a linear axis, calibrated by tables | image position of the spot | yes |
//! | [`pinhole`] | depth camera, with or without lens distortion | depth along the optical axis, or ray length | yes |
//! | [`point_grid`] | organised grid of Cartesian points | distance from the ray's start | no |

mod central;
mod error;
pub mod imaging_radar;
pub mod light_stripe;
pub mod lookup_table;
pub mod pinhole;
pub mod point_grid;

pub use error::SensorError;
pub use imaging_radar::{AngularScan, ImagingRadar};
pub use light_stripe::{LaserAngles, LightStripe, LightStripeParameters};
pub use lookup_table::LookupTable;
pub use pinhole::{Intrinsics, Pinhole, RayTable};
pub use point_grid::{CarriedPinhole, PointGrid, RayStarts};

// Frames state it, so it is defined beside their trait.
pub use transect_device::PinholeScale;
