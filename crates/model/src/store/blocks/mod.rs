//! The lowest layer of a model store: a file of blocks with checksums.
//!
//! Problem: the database trusts the bytes that it reads. It verifies its own checksums only when it
//! repairs or checks a whole file. A damaged page may stop the program or give a wrong answer.
//!
//! Idea: this layer between database and file keeps a checksum with every block. A wrong checksum
//! becomes an I/O error before the block reaches the database.
//!
//! ```text
//! offset  size  what
//!      0   512  preamble: magic "TRANSECT", schema version (u32), CRC-32 of both (u32), zeros
//!    512   512  head, first copy
//!   2048   512  head, second copy
//!   4096     …  blocks 1, 2, …: 4096 bytes of data, CRC-32 of block number and data (u32), "TSB1"
//!
//! head: CRC-32 of the rest (u32), zeros (u32), sequence number (u64),
//!       length of the database's file (u64), first 384 bytes of that file, zeros
//! ```
//!
//! All numbers are little endian. The database's file is block 0, which is the head's 384 bytes
//! followed by zeros, and then the data of the other blocks.
//!
//! **Crashes.** The database never overwrites a block that its last commit refers to, so a block
//! torn by a crash is never read. Only the head is overwritten in place. Each of its two copies
//! fits into one sector, which disks write completely or not at all. Of two sound copies the later
//! one counts, so one damaged copy loses no data.
//!
//! **Limits.** The checksum finds accidents and does not stop attacks. A change of up to 32
//! neighbouring bits is always found, any other with a probability of 1 − 2⁻³². Space: 8 bytes per
//! 4096.

use super::medium::Medium;
use crate::CodecError;
use redb::StorageBackend;
use std::io::{self, ErrorKind};
use std::sync::{Mutex, MutexGuard, PoisonError};

pub(crate) const MAGIC: [u8; 8] = *b"TRANSECT";
/// The version of a store's layout. Files of whole models (`Model::save`) have other versions.
pub const STORE_VERSION: u32 = 7;

const SECTOR: usize = 512;
const HEAD_PLACES: [u64; 2] = [512, 2048];
/// Data bytes of a block, the page size of the database.
pub(crate) const BLOCK: usize = 4096;
/// A block with its checksum, as it is in the file.
const STORED_BLOCK: usize = BLOCK + 8;
const FIRST_BLOCK: u64 = 4096;
/// Bytes of block 0 that are kept; the database uses 320 of them.
const HEAD_DATA: usize = 384;
/// Marks a written block. A block that was never written is all zeros.
const WRITTEN: [u8; 4] = *b"TSB1";

impl From<CodecError> for io::Error {
    fn from(error: CodecError) -> Self {
        Self::new(ErrorKind::InvalidData, error)
    }
}

/// The error of a reference to a place outside of the database's file.
fn out_of_range(offset: u64) -> CodecError {
    CodecError::damaged(format_args!("a reference points to byte {offset}, outside of the file"))
}

fn damaged_head() -> CodecError {
    CodecError::damaged("neither copy of the head matches its checksum")
}

/// The database's file within a medium.
#[derive(Debug)]
pub(crate) struct Blocks<M> {
    medium: M,
    head: Mutex<Head>,
}

/// The part of the file that is overwritten in place.
#[derive(Debug, Clone)]
struct Head {
    sequence: u64,
    /// Length of the database's file, in bytes.
    length: u64,
    data: [u8; HEAD_DATA],
}

impl<M: Medium> Blocks<M> {
    /// An empty store in an empty medium.
    pub(crate) fn create(medium: M) -> io::Result<Self> {
        let head = Head { sequence: 0, length: 0, data: [0; HEAD_DATA] };
        medium.set_len(FIRST_BLOCK)?;
        medium.write_at(0, &preamble())?;
        let blocks = Self { medium, head: Mutex::new(head.clone()) };
        blocks.write_head(head)?;
        Ok(blocks)
    }

    /// Opens the store in a medium.
    ///
    /// # Errors
    /// [`CodecError`] inside an I/O error, if the medium holds no store or an incomplete one.
    pub(crate) fn open(medium: M) -> io::Result<Self> {
        let found = medium.len()?;
        check_preamble(&medium, found)?;
        if found < FIRST_BLOCK {
            return Err(CodecError::Truncated { expected: FIRST_BLOCK, found }.into());
        }
        let copies = [read_head(&medium, HEAD_PLACES[0])?, read_head(&medium, HEAD_PLACES[1])?];
        let latest = copies.into_iter().flatten().max_by_key(|head| head.sequence);
        let head = latest.ok_or_else(damaged_head)?;
        // After a crash while it grew, the file may be longer than the head says, but never
        // shorter.
        let expected = stored_length(head.length);
        if found < expected {
            return Err(CodecError::Truncated { expected, found }.into());
        }
        Ok(Self { medium, head: Mutex::new(head) })
    }

    fn head(&self) -> MutexGuard<'_, Head> {
        // The head is replaced at once, so it is sound even if another thread panicked.
        self.head.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn write_head(&self, head: Head) -> io::Result<()> {
        let head = Head { sequence: head.sequence + 1, ..head };
        let sector = head.to_sector();
        HEAD_PLACES.iter().try_for_each(|&place| self.medium.write_at(place, &sector))?;
        *self.head() = head;
        Ok(())
    }

    fn read_blocks(&self, first: u64, out: &mut [u8]) -> io::Result<()> {
        let count = out.len() / BLOCK;
        let mut stored = vec![0; count * STORED_BLOCK];
        self.medium.read_at(place_of(first), &mut stored)?;
        for ((number, stored), out) in
            (first..).zip(stored.chunks_exact(STORED_BLOCK)).zip(out.chunks_exact_mut(BLOCK))
        {
            let (data, trailer) = stored.split_at(BLOCK);
            if trailer != trailer_of(number, data) {
                let what = format_args!("block {number} does not match its checksum");
                return Err(CodecError::damaged(what).into());
            }
            out.copy_from_slice(data);
        }
        Ok(())
    }

    /// Refuses places outside of the database's file.
    fn check_range(&self, offset: u64, size: usize) -> io::Result<()> {
        let end = offset.checked_add(size as u64);
        let inside = end.is_some_and(|end| end <= self.head().length);
        if inside { Ok(()) } else { Err(out_of_range(offset).into()) }
    }
}

impl<M: Medium> StorageBackend for Blocks<M> {
    fn len(&self) -> io::Result<u64> {
        Ok(self.head().length)
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        self.check_range(offset, out.len())?;
        if offset > 0 {
            return self.read_blocks(whole_blocks(offset, out.len())?, out);
        }
        if out.len() > BLOCK {
            return Err(out_of_range(BLOCK as u64).into());
        }
        out.fill(0);
        out.iter_mut().zip(self.head().data).for_each(|(out, byte)| *out = byte);
        Ok(())
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        let head = Head { length, ..self.head().clone() };
        let (before, after) = (self.medium.len()?, stored_length(length));
        if after >= before {
            self.medium.set_len(after)?;
            // The head must not announce blocks that a power cut could still remove.
            self.medium.sync()?;
            return self.write_head(head);
        }
        self.write_head(head)?;
        self.medium.sync()?;
        self.medium.set_len(after)
    }

    fn sync_data(&self) -> io::Result<()> {
        self.medium.sync()
    }

    fn write(&self, offset: u64, data: &[u8]) -> io::Result<()> {
        self.check_range(offset, data.len())?;
        if offset == 0 {
            let mut head = self.head().clone();
            let kept = head.data.get_mut(..data.len());
            let kept = kept.ok_or_else(|| out_of_range(HEAD_DATA as u64))?;
            kept.copy_from_slice(data);
            return self.write_head(head);
        }
        let first = whole_blocks(offset, data.len())?;
        let mut stored = Vec::with_capacity(data.len() / BLOCK * STORED_BLOCK);
        for (number, data) in (first..).zip(data.chunks_exact(BLOCK)) {
            stored.extend_from_slice(data);
            stored.extend_from_slice(&trailer_of(number, data));
        }
        self.medium.write_at(place_of(first), &stored)
    }
}

impl Head {
    fn to_sector(&self) -> Vec<u8> {
        let mut fields = vec![0; 4];
        fields.extend_from_slice(&self.sequence.to_le_bytes());
        fields.extend_from_slice(&self.length.to_le_bytes());
        fields.extend_from_slice(&self.data);
        fields.resize(SECTOR - 4, 0);
        [&crc32fast::hash(&fields).to_le_bytes()[..], &fields].concat()
    }

    /// The head of a sector; `None` if it does not match its checksum.
    fn from_sector(sector: &[u8]) -> Option<Self> {
        let (checksum, fields) = sector.split_first_chunk()?;
        if u32::from_le_bytes(*checksum) != crc32fast::hash(fields) {
            return None;
        }
        let (sequence, fields) = fields.get(4..)?.split_first_chunk()?;
        let (length, fields) = fields.split_first_chunk()?;
        Some(Self {
            sequence: u64::from_le_bytes(*sequence),
            length: u64::from_le_bytes(*length),
            data: *fields.first_chunk()?,
        })
    }
}

fn read_head(medium: &impl Medium, place: u64) -> io::Result<Option<Head>> {
    let mut sector = [0; SECTOR];
    medium.read_at(place, &mut sector)?;
    Ok(Head::from_sector(&sector))
}

fn preamble() -> [u8; SECTOR] {
    let mut fields = [&MAGIC[..], &STORE_VERSION.to_le_bytes()].concat();
    fields.extend_from_slice(&crc32fast::hash(&fields).to_le_bytes());
    let mut sector = [0; SECTOR];
    sector.iter_mut().zip(fields).for_each(|(byte, field)| *byte = field);
    sector
}

fn check_preamble(medium: &impl Medium, found: u64) -> io::Result<()> {
    let mut sector = [0; SECTOR];
    let there = usize::try_from(found).unwrap_or(SECTOR).min(SECTOR);
    let begin = sector.get_mut(..there).unwrap_or_default();
    medium.read_at(0, begin)?;
    if !begin.starts_with(&MAGIC) {
        return Err(CodecError::NotAModel.into());
    }
    let version = begin.get(MAGIC.len()..).and_then(|rest| rest.first_chunk());
    match version.map(|bytes| u32::from_le_bytes(*bytes)) {
        None => Err(CodecError::Truncated { expected: FIRST_BLOCK, found }.into()),
        Some(STORE_VERSION) if there < SECTOR || sector == preamble() => Ok(()),
        Some(STORE_VERSION) => Err(damaged_head().into()),
        Some(found) => Err(CodecError::WrongVersion { found, expected: STORE_VERSION }.into()),
    }
}

fn trailer_of(number: u64, data: &[u8]) -> [u8; 8] {
    let mut crc = crc32fast::Hasher::new();
    // The number is part of the sum, so a block in the wrong place counts as damaged.
    crc.update(&number.to_le_bytes());
    crc.update(data);
    let (sum, mark) = (crc.finalize().to_le_bytes(), WRITTEN);
    [sum[0], sum[1], sum[2], sum[3], mark[0], mark[1], mark[2], mark[3]]
}

/// Number of the first block; only whole blocks can be read and written.
fn whole_blocks(offset: u64, size: usize) -> io::Result<u64> {
    let whole = offset.is_multiple_of(BLOCK as u64) && size.is_multiple_of(BLOCK);
    if whole { Ok(offset / BLOCK as u64) } else { Err(out_of_range(offset).into()) }
}

/// Place of a block in the medium, for blocks from 1.
fn place_of(block: u64) -> u64 {
    FIRST_BLOCK.saturating_add((block - 1).saturating_mul(STORED_BLOCK as u64))
}

/// Length of the medium for a length of the database's file.
fn stored_length(length: u64) -> u64 {
    place_of(length.div_ceil(BLOCK as u64).max(1))
}

#[cfg(test)]
mod tests;
