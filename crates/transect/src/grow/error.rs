//! Why a store cannot grow.

use crate::{OptionError, ReconstructError, SettingsError};
use transect_geometry::LengthUnit;
use transect_model::store::StoreError;

/// Why a store could not grow.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GrowError {
    /// A view could not be loaded or modelled, no view has curves, or the run was cancelled.
    #[error(transparent)]
    View(#[from] ReconstructError),
    /// The store could not be read or written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The settings in the store cannot be read.
    #[error("the store cannot grow")]
    Settings(#[from] SettingsError),
    /// The store has another length unit than the scan.
    #[error(
        "the store is in {there} and the scan in {here}: a length in one would be taken for the \
         same number in the other. If the scan's lengths are in {there}, state that as its unit; \
         else make another store"
    )]
    OtherUnit {
        /// The store's unit.
        there: LengthUnit,
        /// The scan's unit.
        here: LengthUnit,
    },
    /// The store was made with other planes or other options.
    #[error(
        "the store was made with other settings, which cannot change: {0}. Leave these options out, \
         or make another store"
    )]
    OtherSettings(String),
    /// The store has another view with the same id.
    #[error(
        "view {id}: the store has a view of that name with {what}. If this is another scan, put \
         a text before the names of its views (the setting `prefix`). Else replace that view, or \
         leave this one out (the setting `views`)"
    )]
    OtherView {
        /// Its id.
        id: String,
        /// The difference.
        what: &'static str,
    },
    /// An option of a method has a value that it cannot have.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// The setup asks for refinement, which stores do not support.
    #[error(
        "a store cannot refine its planes, because all its views need the same ones; choose a \
         smaller interval, or reconstruct without a store"
    )]
    Refinement,
    /// The setup asks for refined poses, which depend on all views at once.
    #[error(
        "a store takes view after view, and poses are refined for all views together; add the \
         views at their given poses, then run transect register on the store"
    )]
    Poses,
    /// The store has no view of an id.
    #[error("the store has no view {0}")]
    NotThere(String),
    /// Two of the given views have the same id.
    #[error(
        "views {first} and {second} (from 0) are both named {id}; give one of them another name"
    )]
    SameId {
        /// The name.
        id: String,
        /// The number of the first view of that name.
        first: usize,
        /// The number of the next one.
        second: usize,
    },
}
