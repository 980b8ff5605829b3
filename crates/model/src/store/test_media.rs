//! Media in memory that tests can damage, fill up and cut the power of.

use super::medium::Medium;
use std::io::{self, ErrorKind};
use std::sync::{Arc, Mutex};

/// A change of a medium.
#[derive(Debug, Clone)]
pub(crate) enum Operation {
    Write(u64, Vec<u8>),
    SetLen(u64),
    Sync,
}

/// Bytes in memory; clones share them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Memory {
    pub bytes: Arc<Mutex<Vec<u8>>>,
    /// Where operations are recorded, if they are.
    pub log: Option<Arc<Mutex<Vec<Operation>>>>,
    /// How many bytes fit, if that is limited.
    pub capacity: Option<Arc<Mutex<u64>>>,
}

impl Memory {
    pub(crate) fn of(bytes: Vec<u8>) -> Self {
        Self { bytes: Arc::new(Mutex::new(bytes)), ..Self::default() }
    }

    pub(crate) fn image(&self) -> Vec<u8> {
        self.bytes.lock().unwrap().clone()
    }

    fn record(&self, operation: impl FnOnce() -> Operation) {
        if let Some(log) = &self.log {
            log.lock().unwrap().push(operation());
        }
    }

    fn check_capacity(&self, length: u64) -> io::Result<()> {
        let full = self.capacity.as_ref().is_some_and(|c| length > *c.lock().unwrap());
        if full { Err(ErrorKind::StorageFull.into()) } else { Ok(()) }
    }
}

pub(crate) fn apply(bytes: &mut Vec<u8>, operation: &Operation) {
    match operation {
        Operation::Write(offset, data) => {
            let (start, end) = (*offset as usize, *offset as usize + data.len());
            bytes.resize(bytes.len().max(end), 0);
            bytes[start..end].copy_from_slice(data);
        }
        Operation::SetLen(length) => bytes.resize(*length as usize, 0),
        Operation::Sync => (),
    }
}

impl Medium for Memory {
    fn len(&self) -> io::Result<u64> {
        Ok(self.bytes.lock().unwrap().len() as u64)
    }

    fn read_at(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        let bytes = self.bytes.lock().unwrap();
        let from = bytes.get(offset as usize..).and_then(|rest| rest.get(..out.len()));
        out.copy_from_slice(from.ok_or(ErrorKind::UnexpectedEof)?);
        Ok(())
    }

    fn write_at(&self, offset: u64, data: &[u8]) -> io::Result<()> {
        self.check_capacity(offset + data.len() as u64)?;
        let operation = Operation::Write(offset, data.to_vec());
        apply(&mut self.bytes.lock().unwrap(), &operation);
        self.record(|| operation);
        Ok(())
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        self.check_capacity(length)?;
        self.bytes.lock().unwrap().resize(length as usize, 0);
        self.record(|| Operation::SetLen(length));
        Ok(())
    }

    fn sync(&self) -> io::Result<()> {
        self.record(|| Operation::Sync);
        Ok(())
    }
}
