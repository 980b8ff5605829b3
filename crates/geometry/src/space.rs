//! Points, directions and motions, in `f64` and the model's length unit.
//!
//! `transect-device` has the same aliases, because neither crate depends on the other. They name
//! the same types of nalgebra, so a file takes them from the crate whose other types it uses.

/// A point in space, in the model's length unit.
pub type Point3 = nalgebra::Point3<f64>;
/// A direction or displacement in space.
pub type Vector3 = nalgebra::Vector3<f64>;
/// A point in plane coordinates (see [`PlaneFrame`](crate::PlaneFrame)), in the model's length
/// unit.
pub type Point2 = nalgebra::Point2<f64>;
/// A direction or displacement in plane coordinates.
pub type Vector2 = nalgebra::Vector2<f64>;
/// A rigid motion; variables name it target-from-source, as in `world_from_sensor`.
pub type Isometry3 = nalgebra::Isometry3<f64>;
