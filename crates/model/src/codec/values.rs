//! The bytes of the values in a model store: bincode 2, little endian, variable-length integers.
//!
//! Decoding does not trust the bytes: beyond a first 1 MiB, every length is compared with the
//! remaining bytes before memory is reserved. Texts are borrowed, and bytes that remain are an
//! error.

use super::CodecError;
use bincode::error::EncodeError;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::io::Write;
use transect_geometry::{Curve, Isometry3, PlaneIndex};

/// A view, without its id, which is the key. The order of fields is the file layout.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct ViewValue<'a> {
    pub name: &'a str,
    pub sensor: &'a str,
    pub source: &'a str,
    pub source_hash: &'a str,
    pub world_from_sensor: Isometry3,
    pub sigma: Option<f64>,
    pub curves: u64,
    pub nodes: u64,
    pub planes: Vec<PlaneIndex>,
}

/// The fused curves of a plane, with the hash of the partial curves they were made of.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct FusedValue<'a> {
    pub made_of: u64,
    pub curves: Cow<'a, [Curve]>,
}

/// The coarse copy of a view's image, with the hash of that image.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct CopyValue<'a> {
    pub source_hash: &'a str,
    pub bytes: Cow<'a, [u8]>,
}

pub(crate) fn encode(value: &impl Serialize) -> Result<Vec<u8>, CodecError> {
    bincode::serde::encode_to_vec(value, bincode::config::standard()).map_err(CodecError::damaged)
}

pub(crate) fn encode_into(value: &impl Serialize, out: &mut impl Write) -> Result<(), CodecError> {
    let done = bincode::serde::encode_into_std_write(value, out, bincode::config::standard());
    match done {
        Ok(_) => Ok(()),
        Err(EncodeError::Io { inner, .. }) => Err(CodecError::Io(inner)),
        Err(error) => Err(CodecError::damaged(error)),
    }
}

pub(crate) fn decode<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<T, CodecError> {
    let decoded = bincode::serde::borrow_decode_from_slice(bytes, bincode::config::standard());
    let (value, used) = decoded.map_err(CodecError::damaged)?;
    let whole = used == bytes.len();
    whole.then_some(value).ok_or_else(|| CodecError::damaged("bytes are left over"))
}

/// Adds bytes to an FNV-1a hash, beginning with [`super::HASH_OF_NOTHING`].
///
/// Lengths are hashed too, so that moving bytes from one piece to the next changes the hash.
pub(crate) fn hash_piece(hash: u64, piece: &[u8]) -> u64 {
    super::fnv1a_from(super::fnv1a_from(hash, &(piece.len() as u64).to_le_bytes()), piece)
}
