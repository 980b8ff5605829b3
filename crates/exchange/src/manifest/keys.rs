//! Reading a JSON object key by key, with a record of the keys that were read.

use super::word::{self, Word};
use crate::{Place, ReadError};
use serde_json::{Map, Value};
use std::cell::RefCell;
use std::path::Path;

/// One object of a manifest. Errors name the file, the view and the key. [`Keys::unknown`] lists
/// the keys that were never read.
pub(super) struct Keys<'a> {
    path: &'a Path,
    at: Place,
    /// The text before a key in messages, such as `planes.`.
    prefix: &'static str,
    map: &'a Map<String, Value>,
    asked: RefCell<Vec<&'static str>>,
}

impl<'a> Keys<'a> {
    pub(super) fn of(
        path: &'a Path,
        at: Place,
        prefix: &'static str,
        value: &'a Value,
    ) -> Result<Self, ReadError> {
        match value {
            Value::Object(map) => Ok(Self { path, at, prefix, map, asked: RefCell::default() }),
            _ => {
                let name = if prefix.is_empty() { "this" } else { prefix.trim_end_matches('.') };
                Err(ReadError::damaged(path, at, format!("{name} must be a JSON object")))
            }
        }
    }

    /// Accepts keys that the reader ignores.
    pub(super) fn informational(&self, keys: &[&'static str]) {
        self.asked.borrow_mut().extend(keys);
    }

    /// A note for every key that was not read.
    pub(super) fn unknown(&self) -> Vec<String> {
        let asked = self.asked.borrow();
        let unknown = self.map.keys().filter(|k| !asked.contains(&k.as_str()));
        let (path, at, prefix) = (self.path.display(), &self.at, self.prefix);
        unknown.map(|k| format!("{path}{at}: unknown key \"{prefix}{k}\" ignored")).collect()
    }

    /// The value of a key. A JSON null counts as absent.
    pub(super) fn get(&self, key: &'static str) -> Option<&'a Value> {
        self.asked.borrow_mut().push(key);
        self.map.get(key).filter(|v| !v.is_null())
    }

    pub(super) fn wrong(&self, key: &str, wanted: &str) -> ReadError {
        let prefix = self.prefix;
        let problem = match self.map.get(key) {
            None => format!("no \"{prefix}{key}\"; it must be {wanted}"),
            Some(_) => format!("\"{prefix}{key}\" must be {wanted}"),
        };
        ReadError::damaged(self.path, self.at.clone(), problem)
    }

    /// The converted value of a key, if the key is there; an error if it cannot be converted.
    fn optional<T>(
        &self,
        key: &'static str,
        wanted: &str,
        convert: impl Fn(&'a Value) -> Option<T>,
    ) -> Result<Option<T>, ReadError> {
        let converted = |v| convert(v).ok_or_else(|| self.wrong(key, wanted));
        self.get(key).map(converted).transpose()
    }

    pub(super) fn text(&self, key: &'static str) -> Result<Option<&'a str>, ReadError> {
        self.optional(key, "a text", Value::as_str)
    }

    pub(super) fn number(&self, key: &'static str) -> Result<Option<f64>, ReadError> {
        self.optional(key, "a number", Value::as_f64)
    }

    /// A choice spelt as a word.
    pub(super) fn word<T: Word>(&self, key: &'static str) -> Result<Option<T>, ReadError> {
        let read = |text| word::read(text).map_err(|wanted| self.wrong(key, &wanted));
        self.text(key)?.map(read).transpose()
    }

    pub(super) fn required_word<T: Word>(&self, key: &'static str) -> Result<T, ReadError> {
        let wanted = || format!("one of {}", word::known::<T>());
        self.word(key)?.ok_or_else(|| self.wrong(key, &wanted()))
    }

    /// An object inside this one; `prefix` is the text before its keys in messages.
    pub(super) fn object(
        &self,
        key: &'static str,
        prefix: &'static str,
    ) -> Result<Option<Keys<'a>>, ReadError> {
        self.get(key).map(|value| Keys::of(self.path, self.at.clone(), prefix, value)).transpose()
    }

    pub(super) fn required_number(&self, key: &'static str) -> Result<f64, ReadError> {
        self.number(key)?.ok_or_else(|| self.wrong(key, "a number"))
    }

    pub(super) fn count(&self, key: &'static str) -> Result<Option<usize>, ReadError> {
        let whole = |v: &Value| usize::try_from(v.as_u64()?).ok();
        self.optional(key, "a whole number", whole)
    }

    pub(super) fn required_count(&self, key: &'static str) -> Result<usize, ReadError> {
        self.count(key)?.ok_or_else(|| self.wrong(key, "a whole number"))
    }

    pub(super) fn list(&self, key: &'static str) -> Result<Option<&'a [Value]>, ReadError> {
        self.optional(key, "a list", |v| v.as_array().map(Vec::as_slice))
    }

    /// A list of numbers; a null in it means a number that is not finite.
    pub(super) fn number_list(&self, key: &'static str) -> Result<Option<Vec<f64>>, ReadError> {
        self.optional(key, "a list of numbers", all_numbers)
    }

    /// A list of exactly `N` numbers; a null in it means a number that is not finite.
    pub(super) fn numbers<const N: usize>(
        &self,
        key: &'static str,
    ) -> Result<Option<[f64; N]>, ReadError> {
        let numbers = |v: &Value| all_numbers(v)?.try_into().ok();
        self.optional(key, &format!("a list of {N} numbers"), numbers)
    }

    /// Sixteen numbers that modelling does not use. Other values than a list of numbers are notes
    /// of other programs and count as absent.
    pub(super) fn informational_pose(
        &self,
        key: &'static str,
    ) -> Result<Option<[f64; 16]>, ReadError> {
        match self.get(key).map(all_numbers) {
            Some(Some(_)) => self.numbers(key),
            _ => Ok(None),
        }
    }

    pub(super) fn required_numbers<const N: usize>(
        &self,
        key: &'static str,
    ) -> Result<[f64; N], ReadError> {
        let wanted = format!("a list of {N} numbers");
        self.numbers(key)?.ok_or_else(|| self.wrong(key, &wanted))
    }
}

fn all_numbers(value: &Value) -> Option<Vec<f64>> {
    let number = |v: &Value| if v.is_null() { Some(f64::NAN) } else { v.as_f64() };
    value.as_array()?.iter().map(number).collect()
}
