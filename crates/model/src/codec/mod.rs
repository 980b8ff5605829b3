//! The bytes of a model file and, in [`values`], of the values in a store.
//!
//! ```text
//! offset  size  what
//!      0     8  magic "TRANSECT"
//!      8     4  schema version, little endian
//!     12     8  length of the payload in bytes, little endian
//!     20     8  FNV-1a hash of the payload, little endian
//!     28     …  payload: bincode 2, little endian, variable-length integers
//! ```
//!
//! The hash finds accidents (a damaged disk, an edited file, a broken copy). It does not stop
//! attacks, because anyone can compute it. So the payload is checked too: every length is compared
//! with the remaining bytes before memory is reserved, and the decoded model must pass
//! [`Model::check`].

use crate::{InvariantError, Model, Section, ViewRecord};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::io::{Read, Write};
use transect_geometry::{LengthUnit, PlaneFamily, PlaneIndex};

pub(crate) mod values;

const MAGIC: [u8; 8] = *b"TRANSECT";
const HEADER_SIZE: usize = 28;

/// Version of the layout of a model file; other versions are refused. A store has version 7.
pub const SCHEMA_VERSION: u32 = 6;

/// Why bytes are not a model or a store, or could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CodecError {
    /// Reading or writing failed.
    #[error("reading or writing failed")]
    Io(#[from] std::io::Error),
    /// The first bytes are not those of a model file or a store.
    #[error("not a Transect model file")]
    NotAModel,
    /// The file has another layout than the expected one.
    #[error(
        "the file has format version {found}; version {expected} is read here. {}",
        other_version(*found, *expected)
    )]
    WrongVersion {
        /// Version in the file.
        found: u32,
        /// Version that the reader reads.
        expected: u32,
    },
    /// The file ends too early.
    #[error("truncated: {expected} bytes expected, {found} found")]
    Truncated {
        /// Expected number of bytes, from the beginning of the file.
        expected: u64,
        /// Number of bytes found.
        found: u64,
    },
    /// The bytes are not those that were written, or do not follow the layout.
    #[error("damaged: {0}")]
    Damaged(String),
    /// The parts do not make a model.
    #[error("the contents break a promise of every model")]
    Invariant(#[from] InvariantError),
}

/// What to do about a file of another version.
fn other_version(found: u32, expected: u32) -> &'static str {
    if found > expected {
        "Open it with the program that wrote it, or with a newer version of this one"
    } else {
        "Make the model anew from its scan, or open it with the program that wrote it"
    }
}

impl CodecError {
    pub(crate) fn damaged(what: impl std::fmt::Display) -> Self {
        Self::Damaged(what.to_string())
    }
}

/// The payload. Its field order is the file layout; a change needs a new [`SCHEMA_VERSION`].
#[derive(Serialize, Deserialize)]
struct Payload<'a> {
    unit: LengthUnit,
    planes: PlaneFamily,
    /// The selected planes, in order, if they are not all of the family.
    selected: Option<Vec<PlaneIndex>>,
    views: Cow<'a, [ViewRecord]>,
    sections: Vec<(PlaneIndex, Cow<'a, Section>)>,
}

/// Writes a model: header, then payload.
///
/// # Errors
/// [`CodecError::Invariant`] if the model would not be accepted when read, or an I/O error.
pub(crate) fn write(model: &Model, mut out: impl Write) -> Result<(), CodecError> {
    model.check()?;
    let (payload, mut header) = (Payload::of(model), Header { length: 0, hash: HASH_OF_NOTHING });
    // The header goes first, so the payload is made twice: it may be too large to be kept.
    values::encode_into(&payload, &mut header)?;
    out.write_all(&MAGIC)?;
    out.write_all(&SCHEMA_VERSION.to_le_bytes())?;
    out.write_all(&header.length.to_le_bytes())?;
    out.write_all(&header.hash.to_le_bytes())?;
    values::encode_into(&payload, &mut out)?;
    Ok(out.flush()?)
}

/// Reads what [`write`] wrote, to the end of the input.
///
/// # Errors
/// [`CodecError`] with the problem.
pub(crate) fn read(mut input: impl Read) -> Result<Model, CodecError> {
    let (length, hash) = read_header(&mut input)?;
    // `take` returns at most the bytes that exist, so a wrong length reserves no memory.
    let mut payload = Vec::new();
    let found = input.by_ref().take(length).read_to_end(&mut payload)? as u64;
    if found < length {
        let header = HEADER_SIZE as u64;
        let expected = header.saturating_add(length);
        return Err(CodecError::Truncated { expected, found: header + found });
    }
    if input.take(1).read_to_end(&mut Vec::new())? > 0 {
        return Err(CodecError::damaged("there are bytes after the end of the model"));
    }
    if fnv1a(&payload) != hash {
        return Err(CodecError::damaged("the contents do not match their checksum"));
    }
    decode(&payload)
}

/// Length and hash of the payload.
fn read_header(input: &mut impl Read) -> Result<(u64, u64), CodecError> {
    let mut header = Vec::with_capacity(HEADER_SIZE);
    input.by_ref().take(HEADER_SIZE as u64).read_to_end(&mut header)?;
    let begins_right = header.iter().zip(&MAGIC).all(|(a, b)| a == b);
    if !begins_right || header.is_empty() {
        return Err(CodecError::NotAModel);
    }
    let found = header.len() as u64;
    let truncated = || CodecError::Truncated { expected: HEADER_SIZE as u64, found };
    let fields = header.get(MAGIC.len()..).ok_or_else(truncated)?;
    let (version, fields) = fields.split_first_chunk().ok_or_else(truncated)?;
    match u32::from_le_bytes(*version) {
        SCHEMA_VERSION => (),
        found => return Err(CodecError::WrongVersion { found, expected: SCHEMA_VERSION }),
    }
    let (length, fields) = fields.split_first_chunk().ok_or_else(truncated)?;
    let hash = fields.first_chunk().ok_or_else(truncated)?;
    Ok((u64::from_le_bytes(*length), u64::from_le_bytes(*hash)))
}

impl<'a> Payload<'a> {
    fn of(model: &'a Model) -> Self {
        Self {
            unit: model.unit(),
            planes: model.planes().clone(),
            selected: model.selected().map(|planes| planes.iter().copied().collect()),
            views: Cow::Borrowed(model.views()),
            sections: model.sections().map(|(k, section)| (k, Cow::Borrowed(section))).collect(),
        }
    }
}

/// Length and hash of the bytes that were written to it.
struct Header {
    length: u64,
    hash: u64,
}

impl Write for Header {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.length += bytes.len() as u64;
        self.hash = fnv1a_from(self.hash, bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// The decoder reads from the slice and so knows its end. A list may announce any length, but
/// memory beyond a first 1 MiB is reserved only as items are read (serde).
fn decode(bytes: &[u8]) -> Result<Model, CodecError> {
    let payload: Payload<'_> = values::decode(bytes)?;
    let views = payload.views.into_owned();
    let sections = payload.sections.into_iter().map(|(k, s)| (k, s.into_owned())).collect();
    Ok(Model::from_parts(payload.unit, payload.planes, payload.selected, views, sections)?)
}

/// The 64-bit Fowler–Noll–Vo hash 1a (<http://www.isthe.com/chongo/tech/comp/fnv/>).
///
/// Each step is invertible in the hash so far, so a change of a single byte is always found.
fn fnv1a(bytes: &[u8]) -> u64 {
    fnv1a_from(HASH_OF_NOTHING, bytes)
}

/// The start value of FNV-1a.
pub(crate) const HASH_OF_NOTHING: u64 = 0xcbf2_9ce4_8422_2325;

pub(crate) fn fnv1a_from(hash: u64, bytes: &[u8]) -> u64 {
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    bytes.iter().fold(hash, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME))
}

#[cfg(test)]
mod tests;
