//! The numbers after a PLY header.

use super::header::{Encoding, Kind, Property};
use crate::scalar::Scalar;

/// Reads the numbers of a file one by one, without copying the file.
pub(super) struct Body<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl<'a> Body<'a> {
    pub(super) fn new(bytes: &'a [u8], start: usize, encoding: Encoding) -> Self {
        Self { bytes, at: start, encoding }
    }

    pub(super) fn remaining(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    /// Whether only white space is left.
    pub(super) fn is_spent(&self) -> bool {
        self.rest().iter().all(u8::is_ascii_whitespace)
    }

    /// The current line, from 1; `None` in binary files. It is counted on demand, for messages.
    pub(super) fn line(&self) -> Option<usize> {
        let read = self.bytes.get(..self.at).unwrap_or(self.bytes);
        let count = || 1 + read.iter().filter(|&&b| b == b'\n').count();
        (self.encoding == Encoding::Ascii).then(count)
    }

    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    pub(super) fn number(&mut self, scalar: Scalar) -> Result<f64, String> {
        match self.encoding {
            Encoding::Ascii => {
                let word = self.word()?;
                let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
                number.ok_or_else(|| not_a_number(word))
            }
            _ => self.binary(scalar),
        }
    }

    pub(super) fn integer(&mut self, scalar: Scalar) -> Result<i64, String> {
        match self.encoding {
            Encoding::Ascii => {
                let word = self.word()?;
                whole_number(word).ok_or_else(|| not_a_number(word))
            }
            _ => self.binary(scalar).map(|v| v as i64),
        }
    }

    /// The length of a list, after a check that the file is long enough for it.
    pub(super) fn list_length(&mut self, count: Scalar, item: Scalar) -> Result<usize, String> {
        let announced = self.integer(count)?;
        let each = if self.encoding == Encoding::Ascii { 2 } else { item.size() };
        let length = usize::try_from(announced).ok().filter(|&n| {
            // The last number of a text file needs no separator.
            n.checked_mul(each).is_some_and(|bytes| bytes <= self.remaining() + 1)
        });
        length.ok_or_else(|| format!("a list of {announced} numbers does not fit into the file"))
    }

    pub(super) fn skip(&mut self, property: &Property) -> Result<(), String> {
        match property.kind {
            Kind::One(scalar) => self.number(scalar).map(drop),
            Kind::List { count, item } => {
                let length = self.list_length(count, item)?;
                (0..length).try_for_each(|_| self.number(item).map(drop))
            }
        }
    }

    fn word(&mut self) -> Result<&'a [u8], String> {
        let rest = self.rest();
        let start = rest.iter().position(|b| !b.is_ascii_whitespace());
        let rest = start.and_then(|s| rest.get(s..)).ok_or("truncated: the file ends here")?;
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += start.unwrap_or(0) + end;
        Ok(rest.get(..end).unwrap_or(rest))
    }

    fn binary(&mut self, scalar: Scalar) -> Result<f64, String> {
        let number = scalar.read(self.rest(), self.encoding == Encoding::BigEndian);
        self.at += scalar.size();
        number.ok_or_else(|| "truncated: the file ends here".to_owned())
    }
}

fn not_a_number(word: &[u8]) -> String {
    let start: String = String::from_utf8_lossy(word).chars().take(20).collect();
    format!("{start:?} is not a number here")
}

/// A whole number with an optional sign. Most numbers of a range grid are whole, and this is faster
/// than `str::parse`.
fn whole_number(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word.strip_prefix(b"-") {
        Some(digits) => (true, digits),
        None => (false, word.strip_prefix(b"+").unwrap_or(word)),
    };
    let step = |value: i64, &digit: &u8| {
        let digit = digit.wrapping_sub(b'0');
        (digit < 10).then(|| value.checked_mul(10)?.checked_add(i64::from(digit)))?
    };
    let value = digits.iter().try_fold(0, step).filter(|_| !digits.is_empty())?;
    Some(if negative { -value } else { value })
}
