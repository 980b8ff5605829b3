//! The coarse copy of a view's image that a store keeps, by which poses are compared.
//!
//! The store does not read it. It comes, is replaced and leaves with its view. Stores of programs
//! that made no copies have no table of them.

use super::error::{StoreError, StoreProblem};
use super::snapshot::Snapshot;
use super::tables::COPIES;
use super::view::ViewDescription;
use crate::CodecError;
use crate::codec::values::{CopyValue, decode, encode};
use redb::{ReadableTable, WriteTransaction};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::borrow::Cow;

/// The bytes of a copy, as its caller made them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ViewCopy(pub(super) Vec<u8>);

impl ViewCopy {
    /// The bytes of a value.
    ///
    /// # Errors
    /// If the value cannot be serialised.
    pub fn of(value: &impl Serialize) -> Result<Self, CodecError> {
        encode(value).map(Self)
    }

    /// The value; `None` if the bytes are of another layout, as those of another program may be.
    pub fn value<T: DeserializeOwned>(&self) -> Option<T> {
        decode(&self.0).ok()
    }
}

impl Snapshot {
    /// The copy of a view's image; `None` if there is none of this image.
    ///
    /// # Errors
    /// If the store is damaged.
    pub fn copy(&self, entry: &ViewDescription) -> Result<Option<ViewCopy>, StoreError> {
        self.read_copy(entry).map_err(|problem| self.error(problem))
    }

    pub(super) fn read_copy(
        &self,
        entry: &ViewDescription,
    ) -> Result<Option<ViewCopy>, StoreProblem> {
        let Some(copies) = &self.copies else { return Ok(None) };
        get(copies, entry)
    }
}

/// The copy of a view's image; `None` if there is none of this image.
pub(super) fn get(
    copies: &impl ReadableTable<&'static str, &'static [u8]>,
    entry: &ViewDescription,
) -> Result<Option<ViewCopy>, StoreProblem> {
    let Some(found) = copies.get(entry.id.0.as_str())? else { return Ok(None) };
    let value: CopyValue<'_> = decode(found.value())
        .map_err(StoreProblem::value(format_args!("copy of view {}", entry.id)))?;
    // A program that knows no copies may have replaced the view.
    let same = value.source_hash == entry.source_hash;
    Ok(same.then(|| ViewCopy(value.bytes.into_owned())))
}

/// Stores the copy of a view's image.
pub(super) fn put(
    transaction: &WriteTransaction,
    entry: &ViewDescription,
    copy: &ViewCopy,
) -> Result<(), StoreProblem> {
    let value = CopyValue { source_hash: &entry.source_hash, bytes: Cow::Borrowed(&copy.0) };
    let value =
        encode(&value).map_err(StoreProblem::value(format_args!("copy of view {}", entry.id)))?;
    transaction.open_table(COPIES)?.insert(entry.id.0.as_str(), value.as_slice())?;
    Ok(())
}

/// Removes the copy of a view, if there is one.
pub(super) fn take(transaction: &WriteTransaction, id: &str) -> Result<(), StoreProblem> {
    transaction.open_table(COPIES)?.remove(id)?;
    Ok(())
}
