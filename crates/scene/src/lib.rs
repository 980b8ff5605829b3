//! Simulated scenes: solids, ray casting of any device frame, and exact sections as truth.
//!
//! The one decision of this crate: **a scene is a union of placed solids, and the nearest hit
//! wins**. That is the R-buffer of the dissertation (section 4.5.3): per ray, the smallest range
//! over all surfaces. Its boundary representation (winged-edge solids, a CSG tree, one projection
//! of every polygon into the buffer) is replaced by parry3d's shapes and bounding volume hierarchy:
//! rays look for solids rather than polygons for pixels. Truth is made apart from the rays: the
//! solids' surfaces are sliced by the section planes and overlaps are united in the plane.
//!
//! It refuses to know particular sensors, files and the modeler: it casts whatever implements
//! [`transect_device::DeviceFrame`], and reads scene descriptions as text.
//!
//! * [`Shape`], [`Solid`], [`Scene`], [`Hit`]: what is there, and what a ray meets first;
//! * [`Noise`]: what a real sensor does to it, reproducibly;
//! * [`Mesh`], [`slice_mesh`], [`sections`], [`merge_overlaps`]: truth as oriented curves;
//! * [`Visibility`]: which part of the truth the views could see;
//! * [`Description`], [`Station`]: the scene file (TOML), with [`BUNDLED_ROOM`] as an example.

mod cast;
mod description;
mod mesh;
mod noise;
mod parry;
mod scene;
mod section;
mod solid;
mod visibility;

pub use cast::CastError;
pub use description::{Description, DescriptionError, Problem, SensorParameters, Station};
pub use mesh::{Mesh, MeshError};
pub use noise::Noise;
pub use scene::{Hit, Scene, SceneError};
pub use section::{MAX_PLANES, merge_overlaps, sections, slice_mesh};
pub use solid::{Shape, Solid, SolidError};
pub use visibility::Visibility;

/// The bundled scene description: an indoor scene after section 5.6.1 of the dissertation.
///
/// A room with a table, a chair, a cactus, a lamp and a pillar, seen from its four corners.
pub const BUNDLED_ROOM: &str = include_str!("../../../fixtures/room.scene.toml");
