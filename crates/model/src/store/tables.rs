//! The tables of a store, with their values as types of this crate.
//!
//! ```text
//! header    "header"        → unit, planes, options, tool
//! views     id              → name, sensor, source, its hash, pose, sigma, counts, planes
//! copies    id              → hash of the image, coarse copy of it, which the caller reads
//! partials  (plane, id)     → curves of one view on one plane
//! fused     plane           → hash of the partials they were made of, curves
//! pending   plane           → nothing; the plane's fused curves are still to be made
//! ```

use super::error::StoreProblem;
use super::view::StoredView;
use super::view_id::ViewId;
use crate::codec::HASH_OF_NOTHING;
use crate::codec::values::{FusedValue, decode, encode, hash_piece};
use redb::{ReadOnlyTable, ReadTransaction, ReadableTable, TableDefinition, TableError};
use std::borrow::Cow;
use transect_geometry::{Curve, PlaneIndex};

pub(super) const HEADER: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("header");
pub(super) const VIEWS: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("views");
pub(super) const COPIES: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("copies");
pub(super) const PARTIALS: TableDefinition<'_, (i64, &str), &[u8]> =
    TableDefinition::new("partials");
pub(super) const FUSED: TableDefinition<'_, i64, &[u8]> = TableDefinition::new("fused");
pub(super) const PENDING: TableDefinition<'_, i64, ()> = TableDefinition::new("pending");

/// The partial curves of a plane, by view, with the hash of their bytes.
#[derive(Debug, Default)]
pub(super) struct Partials {
    pub by_view: Vec<(ViewId, Vec<Curve>)>,
    pub hash: u64,
    /// Size of their bytes.
    pub size: usize,
}

/// The partial curves of one plane in order of view ids.
pub(super) fn read_partials(
    table: &impl ReadableTable<(i64, &'static str), &'static [u8]>,
    plane: PlaneIndex,
) -> Result<Partials, StoreProblem> {
    let mut found = Partials { hash: HASH_OF_NOTHING, ..Partials::default() };
    for entry in table.range((plane.0, "")..)? {
        let (key, value) = entry?;
        let (k, id) = key.value();
        if k != plane.0 {
            break;
        }
        let bytes = value.value();
        let curves = decode_curves(plane, id, bytes)?;
        found.by_view.push((id.into(), curves));
        found.hash = hash_piece(hash_piece(found.hash, id.as_bytes()), bytes);
        found.size += bytes.len();
    }
    Ok(found)
}

pub(super) fn decode_curves(
    plane: PlaneIndex,
    id: &str,
    bytes: &[u8],
) -> Result<Vec<Curve>, StoreProblem> {
    let what = format_args!("partial model of view {id} on plane {plane}");
    decode(bytes).map_err(StoreProblem::value(what))
}

pub(super) fn encode_curves(curves: &[Curve]) -> Result<Vec<u8>, StoreProblem> {
    encode(&curves).map_err(StoreProblem::value("partial model"))
}

pub(super) fn decode_fused(
    plane: PlaneIndex,
    bytes: &[u8],
) -> Result<(u64, Vec<Curve>), StoreProblem> {
    let value: FusedValue<'_> =
        decode(bytes).map_err(StoreProblem::value(format_args!("section on plane {plane}")))?;
    Ok((value.made_of, value.curves.into_owned()))
}

pub(super) fn encode_fused(made_of: u64, curves: &[Curve]) -> Result<Vec<u8>, StoreProblem> {
    let value = FusedValue { made_of, curves: Cow::Borrowed(curves) };
    encode(&value).map_err(StoreProblem::value("section"))
}

pub(super) fn read_view(
    table: &impl ReadableTable<&'static str, &'static [u8]>,
    id: &ViewId,
) -> Result<Option<StoredView>, StoreProblem> {
    let found = table.get(id.0.as_str())?;
    found.map(|value| StoredView::decode(&id.0, value.value())).transpose()
}

pub(super) fn read_views(
    table: &impl ReadableTable<&'static str, &'static [u8]>,
) -> Result<Vec<StoredView>, StoreProblem> {
    let entries = table.iter()?.map(|entry| {
        let (id, value) = entry?;
        StoredView::decode(id.value(), value.value())
    });
    entries.collect()
}

/// The copies of a store; `None` if a program made it that knows none.
pub(super) fn open_copies(
    transaction: &ReadTransaction,
) -> Result<Option<ReadOnlyTable<&'static str, &'static [u8]>>, StoreProblem> {
    match transaction.open_table(COPIES) {
        Ok(table) => Ok(Some(table)),
        Err(TableError::TableDoesNotExist(_)) => Ok(None),
        Err(error) => Err(error.into()),
    }
}
