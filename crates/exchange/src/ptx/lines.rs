//! The lines of a large text file, read one at a time.

use crate::{Place, ReadError, input};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Seek, SeekFrom};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Bytes read from the file at once. Doubled, nothing changes: reading is limited by parsing.
const BUFFER: usize = 1 << 18;

/// A line of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Position {
    /// Bytes before the line.
    offset: u64,
    /// The line's number, from 1.
    number: usize,
}

/// The lines of a file from some line on.
pub(super) struct Lines {
    path: PathBuf,
    reader: BufReader<File>,
    size: u64,
    next: Position,
    line: Vec<u8>,
}

impl Lines {
    /// The lines of a regular file, without its byte order mark.
    pub(super) fn open(path: &Path) -> Result<Self, ReadError> {
        let mut lines = Self::at(path, Position { offset: 0, number: 1 })?;
        let start = lines.reader.fill_buf().map_err(|e| ReadError::io(path, e))?;
        let mark = start.len() - input::without_mark(start).len();
        lines.reader.consume(mark);
        lines.next.offset = mark as u64;
        Ok(lines)
    }

    /// The lines of a regular file from a position on.
    pub(super) fn at(path: &Path, next: Position) -> Result<Self, ReadError> {
        let mut file = input::open(path)?;
        let io = |e| ReadError::io(path, e);
        let size = file.metadata().map_err(io)?.len();
        file.seek(SeekFrom::Start(next.offset)).map_err(io)?;
        let reader = BufReader::with_capacity(BUFFER, file);
        Ok(Self { path: path.to_owned(), reader, size, next, line: Vec::new() })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn position(&self) -> Position {
        self.next
    }

    /// The number of the next line, from 1.
    pub(super) fn number(&self) -> usize {
        self.next.number
    }

    pub(super) fn bytes_left(&self) -> u64 {
        self.size.saturating_sub(self.next.offset)
    }

    /// Goes over blank lines. Returns whether a line follows.
    pub(super) fn skip_blank(&mut self) -> Result<bool, ReadError> {
        loop {
            let ahead = self.reader.fill_buf().map_err(|e| ReadError::io(&self.path, e))?;
            match ahead.first() {
                None => return Ok(false),
                Some(byte) if byte.is_ascii_whitespace() => {
                    self.next.number += usize::from(*byte == b'\n');
                    self.next.offset += 1;
                    self.reader.consume(1);
                }
                Some(_) => return Ok(true),
            }
        }
    }

    /// Goes over some lines. Returns how many there were.
    pub(super) fn skip(&mut self, count: usize) -> Result<usize, ReadError> {
        for skipped in 0..count {
            let length = self.reader.skip_until(b'\n');
            if self.went(length)? == 0 {
                return Ok(skipped);
            }
        }
        Ok(count)
    }

    /// The number of words in the next line; 0 at the end of the file.
    pub(super) fn words(&mut self) -> Result<usize, ReadError> {
        self.line.clear();
        let length = self.reader.read_until(b'\n', &mut self.line);
        self.went(length)?;
        let words = self.line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        Ok(words.count())
    }

    /// The first numbers of the next line, which has one of some counts of words. `at` is the scan
    /// that a message names, and `wanted` the content that it expected.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        at: &Place,
        wanted: &str,
        words: RangeInclusive<usize>,
    ) -> Result<[f64; N], ReadError> {
        self.line.clear();
        let length = self.reader.read_until(b'\n', &mut self.line);
        self.went(length)?;
        let mut numbers = [0.0; N];
        let mut count = 0;
        let text = std::str::from_utf8(&self.line).unwrap_or("?");
        for word in text.split_ascii_whitespace() {
            if let Some(number) = numbers.get_mut(count) {
                let Ok(parsed) = word.parse() else { return Err(self.refused(at, wanted)) };
                *number = parsed;
            }
            count += 1;
        }
        if words.contains(&count) { Ok(numbers) } else { Err(self.refused(at, wanted)) }
    }

    /// The error for the line that was read last.
    fn refused(&self, at: &Place, wanted: &str) -> ReadError {
        let found: String =
            String::from_utf8_lossy(&self.line).trim_end().chars().take(40).collect();
        let found = if self.line.is_empty() { "the end of the file".to_owned() } else { found };
        let problem = format!("found {found:?}; expected {wanted}; correct the line");
        self.problem(at, &problem)
    }

    /// An error about the line that was read last, in a scan.
    pub(super) fn problem(&self, at: &Place, problem: &str) -> ReadError {
        let line = Place::Line(self.next.number.saturating_sub(1).max(1));
        ReadError::damaged(&self.path, line, format!("{}: {problem}", at.words()))
    }

    /// Counts a line of some bytes; there is no line of 0 bytes.
    fn went(&mut self, length: io::Result<usize>) -> Result<usize, ReadError> {
        let length = length.map_err(|e| ReadError::io(&self.path, e))?;
        self.next.offset += length as u64;
        self.next.number += usize::from(length > 0);
        Ok(length)
    }
}
