//! The cross-section model: planes → curves → nodes, saved, loaded and asked about inside and outside.
//!
//! The one decision of this crate: the model is **the tree of dissertation 2.5.2**. Its root holds
//! section planes sorted by station, a plane holds its curves, a curve its nodes, and planes and
//! curves carry their envelopes, which are right at every moment.
//!
//! ```text
//! Model ── unit, plane family, views that were put in
//!  └─ PlaneIndex → Section ── envelope                       sorted by station
//!       └─ CurveRecord ── envelope
//!            └─ Curve ── nodes in curve order, solid on the left
//! ```
//!
//! It refuses to know how curves were made: no sensors, no range images, no fusion. Only the
//! `file` and `store` modules touch the disk, and only the `codec` module knows the bytes of values. Lengths
//! are in the model's one length unit; points of a plane in its [`PlaneFrame`], others in the world.
//!
//! * [`Model`], [`Section`], [`CurveRecord`], [`ViewRecord`]: the tree, and walking along it;
//! * [`PlaneSelection`]: the planes of the family that the model was asked for, where not all were;
//! * [`EditError`]: splitting and joining curves, inserting and deleting nodes;
//! * [`Location`], [`SectionIndex`], [`ModelIndex`]: inside, outside or unknown;
//! * [`SectionMeasures`], [`ModelVolume`], [`NestedCurve`]: area, volume with a bound, and a check on directions;
//! * [`Model::save`], [`Model::load`], [`FileError`]: a whole model in a plain file;
//! * [`gaps`]: what nobody saw, and where a next view would see most of it;
//! * [`store`]: a model in a database, which grows view by view and need not fit into memory;
//! * [`Model::check`], [`InvariantError`]: what holds of every model.
//!
//! [`PlaneFrame`]: transect_geometry::PlaneFrame

mod check;
mod codec;
mod edit;
mod file;
pub mod gaps;
mod invariant;
mod measure;
mod model;
mod nesting;
mod nodes;
mod query;
mod section;
mod selection;
pub mod store;
mod unit_tree;
mod volume;

#[cfg(test)]
mod samples;

pub use codec::{CodecError, SCHEMA_VERSION};
pub use edit::EditError;
pub use file::FileError;
pub use invariant::InvariantError;
pub use measure::SectionMeasures;
pub use model::{Model, ViewRecord};
pub use nesting::NestedCurve;
pub use query::{Location, ModelIndex, PlaneAnswer, SectionIndex, SpaceAnswer, locate_in_plane};
pub use section::{CurveIndex, CurveRecord, NodeIndex, Section};
pub use selection::PlaneSelection;
pub use unit_tree::InTree;
pub use volume::{ModelVolume, RunVolume, VolumeSum};
