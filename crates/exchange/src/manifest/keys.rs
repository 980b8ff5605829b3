//! Reading a JSON object key by key, with a record of the keys that were read.

use crate::{Place, ReadError};
use serde::de::{self, Deserialize, DeserializeSeed, Error as _, IntoDeserializer, Visitor};
use serde_json::{Error, Map, Value};
use std::cell::RefCell;
use std::path::Path;
use transect_device::Note;

/// A key that no reader asked for.
pub(super) struct UnknownKey {
    at: Place,
    /// The key, with the text before it in messages.
    key: String,
}

/// A note for every unknown key. A key of several views gets one note, at the first of them.
pub(super) fn unknown_notes(path: &Path, unknown: &[UnknownKey]) -> Vec<Note> {
    let mut groups: Vec<(&UnknownKey, usize)> = Vec::new();
    for one in unknown {
        let of_views = |at: &Place| matches!(at, Place::View { .. });
        let same =
            |first: &UnknownKey| first.key == one.key && of_views(&first.at) && of_views(&one.at);
        match groups.iter_mut().find(|(first, _)| same(first)) {
            Some((_, count)) => *count += 1,
            None => groups.push((one, 1)),
        }
    }
    let path = path.display();
    let note = |(UnknownKey { at, key }, count): (&UnknownKey, usize)| {
        let views = if count > 1 { format!(", in {count} views") } else { String::new() };
        let text = format!("unknown key \"{key}\" ignored{views}");
        Note::about(format_args!("{path}{at}"), text)
    };
    groups.into_iter().map(note).collect()
}

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

    /// The keys that were not read.
    pub(super) fn unknown(&self) -> Vec<UnknownKey> {
        let asked = self.asked.borrow();
        let unknown = self.map.keys().filter(|k| !asked.contains(&k.as_str()));
        let of_key = |key| UnknownKey { at: self.at.clone(), key: format!("{}{key}", self.prefix) };
        unknown.map(of_key).collect()
    }

    pub(super) fn wrong(&self, key: &str, wanted: &str) -> ReadError {
        let prefix = self.prefix;
        let problem = match self.map.get(key) {
            None => format!("no \"{prefix}{key}\"; it must be {wanted}"),
            Some(_) => format!("\"{prefix}{key}\" must be {wanted}"),
        };
        self.damaged(problem)
    }

    fn damaged(&self, problem: String) -> ReadError {
        ReadError::damaged(self.path, self.at.clone(), problem)
    }

    /// The value of a key. A JSON null counts as absent.
    pub(super) fn get(&self, key: &'static str) -> Option<&'a Value> {
        self.asked.borrow_mut().push(key);
        self.map.get(key).filter(|v| !v.is_null())
    }

    pub(super) fn optional<T: Deserialize<'a>>(
        &self,
        key: &'static str,
    ) -> Result<Option<T>, ReadError> {
        let value = self.get(key).map(T::deserialize).transpose();
        value.map_err(|e| self.damaged(format!("\"{}{key}\": {e}", self.prefix)))
    }

    pub(super) fn required<T: Deserialize<'a>>(
        &self,
        key: &'static str,
        wanted: &str,
    ) -> Result<T, ReadError> {
        self.optional(key)?.ok_or_else(|| self.wrong(key, wanted))
    }

    pub(super) fn number(&self, key: &'static str) -> Result<f64, ReadError> {
        self.required(key, "a number")
    }

    /// An object inside this one; `prefix` is the text before its keys in messages.
    pub(super) fn object(
        &self,
        key: &'static str,
        prefix: &'static str,
    ) -> Result<Option<Keys<'a>>, ReadError> {
        self.get(key).map(|value| Keys::of(self.path, self.at.clone(), prefix, value)).transpose()
    }

    /// A structure whose fields are keys of this object. Its other keys stay unread.
    pub(super) fn fields<T: Deserialize<'a>>(&self) -> Result<T, ReadError> {
        T::deserialize(self).map_err(|e| self.damaged(e.to_string()))
    }
}

/// Hands a structure the values of its fields, and records the fields as keys that were read.
impl<'de> de::Deserializer<'de> for &Keys<'de> {
    type Error = Error;

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let entry = |key: &&'static str| Some((*key, self.get(key)?));
        let entries = fields.iter().filter_map(entry).collect::<Vec<_>>().into_iter();
        visitor.visit_map(Entries { prefix: self.prefix, entries, current: None })
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_struct("", &[], visitor)
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option
        unit unit_struct newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}

/// Keys with their values; errors name the key.
struct Entries<'a> {
    prefix: &'static str,
    entries: std::vec::IntoIter<(&'static str, &'a Value)>,
    current: Option<(&'static str, &'a Value)>,
}

impl<'a> de::MapAccess<'a> for Entries<'a> {
    type Error = Error;

    fn next_key_seed<K: DeserializeSeed<'a>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Error> {
        self.current = self.entries.next();
        self.current.map(|(key, _)| seed.deserialize(key.into_deserializer())).transpose()
    }

    fn next_value_seed<V: DeserializeSeed<'a>>(&mut self, seed: V) -> Result<V::Value, Error> {
        let (key, value) = self.current.take().ok_or_else(|| Error::custom("no key was read"))?;
        let named = |e| Error::custom(format!("\"{}{key}\": {e}", self.prefix));
        seed.deserialize(value).map_err(named)
    }
}
