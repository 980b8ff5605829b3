//! Simulated scenes: solids, ray casting of any device frame, and exact sections as truth.
//!
//! The one decision of this crate: **a scene is a union of placed solids, and the nearest hit
//! wins**. That is the R-buffer of the dissertation (section 4.5.3): per ray, the smallest range
//! over all surfaces. Its boundary representation (winged-edge solids, a CSG tree, one projection
//! of every polygon into the buffer) is replaced by parry3d's shapes and bounding volume hierarchy.
//! Rays search for solids instead of polygons for pixels. The truth does not come from rays: the
//! section planes slice the solids' surfaces, and overlaps are united in the plane.
//!
//! The crate knows no files and no modeler. It casts every [`transect_device::DeviceFrame`], and
//! reads scene descriptions as text. Only descriptions name particular sensors.
//!
//! * [`Shape`], [`Solid`], [`Scene`], [`Hit`]: the solids, and the first hit of a ray;
//! * [`Noise`], [`DepthCamera`], [`PoseNoise`]: reproducible errors of a real sensor;
//! * [`StripeCamera`], [`StripeImages`]: the images of a light-stripe sensor's camera;
//! * [`Mesh`], [`sections`], [`merge_overlaps`]: truth as oriented curves;
//! * [`Visibility`]: the part of the truth that the views could see;
//! * [`Description`], [`Station`]: the scene file (TOML), with [`BUNDLED_SCENES`] as examples,
//!   whose free-form surfaces are made by [`fixtures`].
//!
//! A small scan for a property test takes a millisecond: a few solids before a wall, which throw
//! shadows, and dropouts, which leave holes.
//!
//! ```
//! use std::sync::Arc;
//! use transect_geometry::{Isometry3, Vector3};
//! use transect_scene::{Noise, Scene, Shape, Solid};
//! use transect_sensors::{Intrinsics, Pinhole};
//!
//! let (x, radius, seed) = (0.2, 0.4, 7); // drawn by the test
//! let at = |shape, x, z| Solid::new(shape, Isometry3::translation(x, 0.0, z));
//! let wall = at(Shape::cuboid(Vector3::new(9.0, 9.0, 1.0))?, 0.0, 4.0)?;
//! let scene = Scene::new(vec![wall, at(Shape::ball(radius)?, x, 2.0)?]);
//! let size = transect_device::ImageSize { rows: 48, cols: 64 };
//! let camera = Pinhole::new(size, Intrinsics { fx: 60.0, fy: 60.0, cx: 31.5, cy: 23.5 })?;
//! let noise = Noise { sigma: 0.002, dropout: 0.05, seed, ..Noise::NONE };
//! let view = scene.view("small", Arc::new(camera), Isometry3::identity(), &noise, 0)?;
//! assert!((2500..3072).contains(&view.image().valid_count()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cast;
mod description;
pub mod fixtures;
mod mesh;
mod noise;
mod parry;
mod scene;
mod section;
mod solid;
mod stripe;
#[cfg(test)]
mod test_frames;
mod visibility;

pub use cast::CastError;
pub use description::{Description, DescriptionError, Problem, SensorParameters, Station, Visitor};
pub use mesh::{LARGEST, Mesh, MeshError};
pub use noise::{DepthCamera, Noise, PoseNoise};
pub use scene::{Hit, Scene, SceneError};
pub use section::{MAX_PLANES, MergeError, merge_overlaps, sections};
pub use solid::{Shape, Solid, SolidError};
pub use stripe::{BitDepth, Counts, StripeCamera, StripeError, StripeImages};
pub use visibility::Visibility;

/// The bundled scene description: an indoor scene after section 5.6.1 of the dissertation.
///
/// A room with a table, a chair, a cactus, a lamp and a pillar, seen from its four corners.
pub const BUNDLED_ROOM: &str = include_str!("../fixtures/room.scene.toml");

/// A free-form face ([`fixtures::face_mask`]) on a board, seen by depth cameras in front of it.
pub const BUNDLED_FACE_MASK: &str = include_str!("../fixtures/face_mask.scene.toml");

/// A flange with hub, bore, keyway and chamfers ([`fixtures::flange`]), seen from all around.
pub const BUNDLED_MACHINED_PART: &str = include_str!("../fixtures/machined_part.scene.toml");

/// A sheet as thin as a few standard deviations of the noise, seen from both sides.
pub const BUNDLED_THIN_SHEET: &str = include_str!("../fixtures/thin_sheet.scene.toml");

/// A straight tunnel ([`fixtures::tunnel`]) with a walkway and pipes, scanned from inside.
pub const BUNDLED_TUNNEL: &str = include_str!("../fixtures/tunnel.scene.toml");

/// A tunnel along a bend ([`fixtures::bend_tunnel`]) with a curved guide, scanned from inside.
pub const BUNDLED_BEND_TUNNEL: &str = include_str!("../fixtures/bend_tunnel.scene.toml");

/// A cluttered kitchen, seen by a depth camera with all of its errors ([`DepthCamera`]).
pub const BUNDLED_KITCHEN: &str = include_str!("../fixtures/kitchen.scene.toml");

/// The face mask before the dissertation's line scanner at its true size, from eight places
/// (5.6.2).
pub const BUNDLED_HYSCAN_MASK: &str = include_str!("../fixtures/hyscan_mask.scene.toml");

/// A small jug before the dissertation's light-stripe range finder at its true size (4.6).
pub const BUNDLED_SMART_EYE_JUG: &str = include_str!("../fixtures/smart_eye_jug.scene.toml");

/// All bundled descriptions with their names.
pub const BUNDLED_SCENES: [(&str, &str); 9] = [
    ("room", BUNDLED_ROOM),
    ("face_mask", BUNDLED_FACE_MASK),
    ("machined_part", BUNDLED_MACHINED_PART),
    ("thin_sheet", BUNDLED_THIN_SHEET),
    ("tunnel", BUNDLED_TUNNEL),
    ("bend_tunnel", BUNDLED_BEND_TUNNEL),
    ("kitchen", BUNDLED_KITCHEN),
    ("hyscan_mask", BUNDLED_HYSCAN_MASK),
    ("smart_eye_jug", BUNDLED_SMART_EYE_JUG),
];
