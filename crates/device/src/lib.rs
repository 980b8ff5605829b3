//! The interface between sensors and the rest of the workspace.
//!
//! The one decision of this crate: a range sensor is a **grid of rays with a monotone scale on
//! each** (dissertation, section 3.3). [`DeviceFrame`] defines the rays and the scale,
//! [`RangeImage`] holds one value per ray, and [`View`] puts both into the world.
//!
//! [`DepthOffsets`], [`ImageOrder`] and [`PinholeScale`] correct whole images. [`Note`],
//! [`median()`] and [`quantile()`] are here because nearly all crates need them. The crate holds
//! the equations of no sensor, reads no file and does not use the images. To add a sensor,
//! implement [`DeviceFrame`]; see `transect-sensors` for examples.
//!
//! Conventions that hold for every sensor: row `i` and column `j` count from 0. A pixel's sample
//! belongs to the pixel's *centre*. Sensor frames are right-handed Cartesian. Lengths are in the
//! model's one length unit, and angles in radians. Transforms are named target-from-source.

mod depth_offsets;
mod frame;
mod image_order;
mod note;
mod pinhole_scale;
mod quantile;
mod range_image;
mod separable;
mod view;

pub use depth_offsets::{DepthOffsets, DepthOffsetsError, Nodes};
pub use frame::{
    DeviceFrame, DevicePoint, Handedness, LinearForm, Neighbour, PairGeometry, Ray, SensorPlane,
};
pub use image_order::ImageOrder;
pub use note::Note;
pub use pinhole_scale::PinholeScale;
pub use quantile::{median, quantile};
pub use range_image::{ImageError, ImageSize, MAX_PIXELS, Pixel, RangeImage};
pub use separable::{RayProduct, RayProducts, SeparableForm};
pub use view::{View, ViewError};

// `transect-geometry` has the same aliases, because neither crate depends on the other. They name
// the same types of nalgebra, so a file takes them from the crate whose other types it uses.

/// A point in a sensor frame or in the world, in the model's length unit.
pub type Point3 = nalgebra::Point3<f64>;
/// The point of a missing sample in a list of points: NaN.
pub const MISSING_POINT: Point3 = Point3::new(f64::NAN, f64::NAN, f64::NAN);
/// A direction or displacement in space.
pub type Vector3 = nalgebra::Vector3<f64>;
/// A rigid motion; variables name it target-from-source, as in `world_from_sensor`.
pub type Isometry3 = nalgebra::Isometry3<f64>;
