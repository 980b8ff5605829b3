//! The cross-section model: planes → curves → nodes, with files, a store, and queries of inside and
//! outside.
//!
//! The one decision of this crate: the model is **the tree of dissertation 2.5.2**. Its root holds
//! section planes sorted by station, a plane holds its curves, a curve its nodes, and planes and
//! curves carry their envelopes, which are exact after every change.
//!
//! ```text
//! Model ── unit, plane family, views that were put in
//!  └─ PlaneIndex → Section ── envelope                       sorted by station
//!       └─ CurveRecord ── envelope
//!            └─ Curve ── nodes in curve order, solid on the left
//! ```
//!
//! It does not know how curves were made: it needs no sensors, range images or fusion. Only the
//! modules `file` and `store` use the disk, and only `codec` knows the bytes of values. Lengths are
//! in the model's one length unit; points of a plane in its [`PlaneFrame`], others in the world.
//!
//! * [`Model`], [`Section`], [`CurveRecord`], [`ViewRecord`]: the tree, and walking along it;
//! * [`PlaneSelection`]: the planes that were selected, where they are not all of the family;
//! * [`Location`], [`SectionIndex`], [`ModelIndex`]: inside, outside or unknown;
//! * [`SectionMeasures`], [`ModelVolume`], [`Bracket`]: bounds of areas and volumes, of solid and
//!   of clear space;
//! * [`Model::save`], [`Model::load`], [`FileError`]: a whole model in a plain file;
//! * [`open_regular`]: opening files, for every reader of the workspace;
//! * [`gaps`]: unseen stretches of boundary, and places from which a next view would see most of
//!   them;
//! * [`store`]: a model in a database, which grows view by view and may be larger than memory;
//! * [`Model::check`], [`InvariantError`]: the promises that every model keeps.
//!
//! [`PlaneFrame`]: transect_geometry::PlaneFrame

mod check;
mod codec;
mod file;
pub mod gaps;
mod invariant;
mod loops;
mod measure;
mod model;
mod query;
mod regular_file;
mod section;
mod selection;
pub mod store;
mod text;
mod unit_tree;
mod volume;

#[cfg(test)]
mod samples;

pub use codec::{CodecError, SCHEMA_VERSION};
pub use file::FileError;
pub use invariant::InvariantError;
pub use measure::{Bracket, SectionMeasures};
pub use model::{Model, ViewRecord};
pub use query::{Location, ModelIndex, PlaneAnswer, SectionIndex, SpaceAnswer, locate_in_plane};
pub use regular_file::open_regular;
pub use section::{CurveIndex, CurveRecord, Section};
pub use selection::PlaneSelection;
pub use unit_tree::InTree;
pub use volume::{ModelVolume, Volume, VolumeSum};
