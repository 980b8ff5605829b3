//! A database whose changes stay in memory, so that its file is only read.
//!
//! Problem: redb writes into a file when it opens, repairs, checks and closes it. Readers may have
//! no permission to write, and several of them may read one file.
//!
//! Idea: changed blocks are kept in memory and hide those of the file. A file that a crash left
//! is repaired in memory, and interrupted work can be finished for reading.
//!
//! Cost: memory for the changed blocks, 4 KiB each.

use super::blocks::BLOCK;
use redb::StorageBackend;
use std::collections::BTreeMap;
use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A database's file with changes in memory.
#[derive(Debug)]
pub(crate) struct InMemory<B> {
    file: B,
    changes: Mutex<Changes>,
}

#[derive(Debug)]
struct Changes {
    /// Length of the database's file with the changes, in bytes.
    length: u64,
    /// Changed blocks by number.
    blocks: BTreeMap<u64, Vec<u8>>,
}

impl<B: StorageBackend> InMemory<B> {
    pub(crate) fn over(file: B) -> io::Result<Self> {
        let changes = Changes { length: file.len()?, blocks: BTreeMap::new() };
        Ok(Self { file, changes: Mutex::new(changes) })
    }

    fn changes(&self) -> MutexGuard<'_, Changes> {
        // A block is replaced at once, so all are whole even if another thread panicked.
        self.changes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<B: StorageBackend> StorageBackend for InMemory<B> {
    fn len(&self) -> io::Result<u64> {
        Ok(self.changes().length)
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        let first = offset / BLOCK as u64;
        for (number, out) in (first..).zip(out.chunks_mut(BLOCK)) {
            match self.changes().blocks.get(&number) {
                Some(block) => out.iter_mut().zip(block).for_each(|(out, byte)| *out = *byte),
                None => self.file.read(number * BLOCK as u64, out)?,
            }
        }
        Ok(())
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        self.changes().length = length;
        Ok(())
    }

    fn sync_data(&self) -> io::Result<()> {
        Ok(())
    }

    fn write(&self, offset: u64, data: &[u8]) -> io::Result<()> {
        let first = offset / BLOCK as u64;
        for (number, data) in (first..).zip(data.chunks(BLOCK)) {
            let mut block = vec![0; BLOCK];
            if data.len() < BLOCK {
                // Only the head, block 0, is written in part.
                self.read(number * BLOCK as u64, &mut block)?;
            }
            block.iter_mut().zip(data).for_each(|(byte, data)| *byte = *data);
            self.changes().blocks.insert(number, block);
        }
        Ok(())
    }
}
