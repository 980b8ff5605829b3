//! From the text of a manifest to its content.

use super::entry::{Manifest, ViewEntry};
use super::keys::Keys;
use super::sensor::SensorEntry;
use crate::{Place, PlanesEntry, ReadError};
use serde::Deserialize;
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;
use transect_geometry::{CurvedGuide, LengthUnit};

/// Keys of other programs, at the top and in views. The reader ignores them without a note.
const FOREIGN_KEYS: [&str; 8] =
    ["scene", "size", "truth", "seed", "comment", "pose_true", "description", "tool"];

pub(super) fn manifest(path: &Path, text: &str) -> Result<(Manifest, Vec<String>), ReadError> {
    let value: Value = serde_json::from_str(&without_nan(text))
        .map_err(|source| ReadError::Json { path: path.to_owned(), source })?;
    let keys = Keys::of(path, Place::Whole, "", &value)?;
    keys.informational(&FOREIGN_KEYS);
    let mut notes = Vec::new();
    let mut views = Vec::new();
    let entries = keys.list("views")?.ok_or_else(|| keys.wrong("views", "a list"))?;
    for (number, entry) in entries.iter().enumerate() {
        views.push(view(path, number, entry, &mut notes)?);
    }
    let at_least_zero = |s: &f64| s.is_finite() && *s >= 0.0;
    let sigma = keys.number("sigma")?;
    if sigma.is_some_and(|s| !at_least_zero(&s)) {
        return Err(keys.wrong("sigma", "a length of at least 0"));
    }
    let folder_name = || path.parent().and_then(Path::file_name).map(|n| n.to_string_lossy());
    let name = match keys.text("name")? {
        Some(name) => name.to_owned(),
        None => folder_name().unwrap_or_default().into_owned(),
    };
    let planes = keys.get("planes").map(|v| planes(path, v, &mut notes)).transpose()?;
    // The reader does not use the size, so any value is accepted.
    let size = value.get("size").and_then(Value::as_f64);
    let manifest = Manifest { name, unit: unit(&keys)?, sigma, planes, size, views };
    notes.splice(0..0, keys.unknown());
    Ok((manifest, notes))
}

fn unit(keys: &Keys<'_>) -> Result<Option<LengthUnit>, ReadError> {
    let known = || LengthUnit::ALL.map(LengthUnit::symbol).join(", ");
    let parse = |symbol: &str| {
        let wanted = || format!("one of {}; it is {symbol:?}", known());
        symbol.parse().map_err(|_| keys.wrong("unit", &wanted()))
    };
    keys.text("unit")?.map(parse).transpose()
}

fn planes(path: &Path, value: &Value, notes: &mut Vec<String>) -> Result<PlanesEntry, ReadError> {
    let keys = Keys::of(path, Place::Whole, "planes.", value)?;
    let guide = keys.get("guide").map(|v| CurvedGuide::deserialize(v).map(Arc::new)).transpose();
    let guide = guide.map_err(|e| keys.wrong("guide", &format!("a kind and points: {e}")))?;
    let entry = PlanesEntry {
        // Along a curve there is no single normal, so the key is optional.
        normal: match guide {
            Some(_) => keys.numbers("normal")?.unwrap_or([0.0, 0.0, 1.0]),
            None => keys.required_numbers("normal")?,
        },
        offset: keys.required_number("offset")?,
        interval: keys.required_number("interval")?,
        guide,
    };
    notes.extend(keys.unknown());
    Ok(entry)
}

fn view(
    path: &Path,
    number: usize,
    value: &Value,
    notes: &mut Vec<String>,
) -> Result<ViewEntry, ReadError> {
    let file = value.get("file").and_then(Value::as_str).unwrap_or("no file").to_owned();
    let at = Place::View { number, name: file };
    let keys = Keys::of(path, at, "", value)?;
    keys.informational(&FOREIGN_KEYS);
    let file = keys.text("file")?.ok_or_else(|| keys.wrong("file", "a file name"))?;
    let depth_scale = keys.number("depth_scale")?;
    if depth_scale.is_some_and(|s| !(s.is_finite() && s > 0.0)) {
        return Err(keys.wrong("depth_scale", "a positive length per count"));
    }
    let entry = ViewEntry {
        file: file.to_owned(),
        sensor: SensorEntry::read(&keys, notes)?,
        rows: keys.count("rows")?,
        cols: keys.count("cols")?,
        depth_scale,
        pose: keys.required_numbers("pose")?,
        pose_true: keys.informational_pose("pose_true")?,
    };
    notes.extend(keys.unknown());
    Ok(entry)
}

/// The text with `NaN`, `Infinity` and `-Infinity` outside strings replaced by nulls of the same
/// length. The error can then name the view and the key instead of a place in the text.
fn without_nan(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let (mut rest, mut in_string) = (text, false);
    while let Some(c) = rest.chars().next() {
        let word = ["NaN", "-Infinity", "Infinity"].into_iter().find(|w| rest.starts_with(w));
        let (taken, kept) = match word.filter(|_| !in_string) {
            // "null" is one letter longer than "NaN", so later columns in messages shift by one.
            Some(word) => (word.len(), format!("{:<1$}", "null", word.len())),
            None if in_string && c == '\\' => {
                let escaped = rest.chars().nth(1).map_or(0, char::len_utf8);
                (1 + escaped, rest.get(..1 + escaped).unwrap_or(rest).to_owned())
            }
            None => {
                in_string ^= c == '"';
                out.push(c);
                rest = rest.get(c.len_utf8()..).unwrap_or_default();
                continue;
            }
        };
        out.push_str(&kept);
        rest = rest.get(taken..).unwrap_or_default();
    }
    out
}
