//! From the text of a manifest to its content.

use super::entry::{Manifest, ViewEntry};
use super::keys::{Keys, UnknownKey, unknown_notes};
use super::sensor::SensorEntry;
use super::unique::Unique;
use crate::missing::MissingValue;
use crate::scan::{SURFACE_SIGMA, is_surface_sigma};
use crate::{Place, PlanesEntry, PoseSigma, ReadError};
use serde::Deserialize;
use serde_json::Value;
use std::path::Path;
use transect_device::Note;
use transect_geometry::LengthUnit;

/// Keys of other programs, at the top and in views. The reader ignores them without a note.
const FOREIGN_KEYS: [&str; 8] =
    ["scene", "size", "truth", "seed", "comment", "pose_true", "description", "tool"];

pub(super) fn manifest(path: &Path, text: &str) -> Result<(Manifest, Vec<Note>), ReadError> {
    let Unique(value) = serde_json::from_str(&with_quoted_nan(text))
        .map_err(|source| ReadError::Json { path: path.to_owned(), source })?;
    let keys = Keys::of(path, Place::Whole, "", &value)?;
    keys.informational(&FOREIGN_KEYS);
    let mut unknown = Vec::new();
    let mut views = Vec::new();
    let entries = keys.get("views").and_then(Value::as_array);
    let missing = missing(&keys)?;
    for (number, entry) in entries.ok_or_else(|| keys.wrong("views", "a list"))?.iter().enumerate()
    {
        views.push(view(path, (number, entry), missing, &mut unknown)?);
    }
    let sigma: Option<f64> = keys.optional("sigma")?;
    if sigma.is_some_and(|s| !(s.is_finite() && s >= 0.0)) {
        return Err(keys.wrong("sigma", "a length of at least 0"));
    }
    let folder = path.parent().and_then(Path::file_name).unwrap_or_default();
    let name = keys.optional("name")?.unwrap_or_else(|| folder.to_string_lossy().into_owned());
    let planes = keys.object("planes", "planes.")?.map(|k| planes(&k, &mut unknown)).transpose()?;
    // The reader does not use the size, so any value is accepted.
    let size = value.get("size").and_then(Value::as_f64);
    let manifest = Manifest { name, unit: unit(&keys)?, sigma, planes, size, views };
    unknown.splice(0..0, keys.unknown());
    Ok((manifest, unknown_notes(path, &unknown)))
}

fn unit(keys: &Keys<'_>) -> Result<Option<LengthUnit>, ReadError> {
    let parse = |symbol: &str| {
        let known = LengthUnit::ALL.map(LengthUnit::symbol).join(", ");
        let wanted = format!("one of {known}; it is {symbol:?}");
        symbol.parse().map_err(|_| keys.wrong("unit", &wanted))
    };
    keys.optional("unit")?.map(parse).transpose()
}

fn planes(keys: &Keys<'_>, unknown: &mut Vec<UnknownKey>) -> Result<PlanesEntry, ReadError> {
    let entry: PlanesEntry = keys.fields()?;
    // Along a curve there is no single normal, so the key is optional there.
    if entry.guide.is_none() {
        keys.required::<[f64; 3]>("normal", "[x, y, z]")?;
    }
    unknown.extend(keys.unknown());
    Ok(entry)
}

fn view(
    path: &Path,
    (number, value): (usize, &Value),
    missing: Option<MissingValue>,
    unknown: &mut Vec<UnknownKey>,
) -> Result<ViewEntry, ReadError> {
    let file = value.get("file").and_then(Value::as_str).unwrap_or("no file").to_owned();
    let at = Place::View { number, name: file };
    let keys = Keys::of(path, at, "", value)?;
    keys.informational(&FOREIGN_KEYS);
    // The second name is the older one.
    let [scale, older]: [Option<f64>; 2] = [keys.optional("scale")?, keys.optional("depth_scale")?];
    if let (Some(a), Some(b)) = (scale, older)
        && a != b
    {
        let wanted = format!("the same as depth_scale, its older name, which is {b}; it is {a}");
        return Err(keys.wrong("scale", &wanted));
    }
    let scale = scale.or(older);
    if scale.is_some_and(|s| !(s.is_finite() && s > 0.0)) {
        return Err(keys.wrong("scale", "a positive length per count"));
    }
    let entry = ViewEntry {
        file: keys.required("file", "a file name")?,
        name: keys.optional("name")?,
        sensor: SensorEntry::read(&keys, unknown)?,
        rows: keys.optional("rows")?,
        cols: keys.optional("cols")?,
        scale,
        missing: self::missing(&keys)?.or(missing),
        image_order: keys.optional("image_order")?,
        pose: keys.required::<PoseText>("pose", POSE)?.matrix(&keys, "pose")?,
        pose_sigma: pose_sigma(&keys)?,
        surface_sigma: surface_sigma(&keys)?,
        pose_true: pose_true(&keys)?,
    };
    unknown.extend(keys.unknown());
    Ok(entry)
}

/// The stated value of missing pixels. A number that is not finite is missing in every image, so
/// there is nothing to state.
fn missing(keys: &Keys<'_>) -> Result<Option<MissingValue>, ReadError> {
    let stated = keys.get("missing");
    if stated.is_some_and(|value| NotFinite::deserialize(value).is_ok()) {
        return Ok(None);
    }
    keys.optional("missing")
}

/// The expected form of a pose.
const POSE: &str = "16 numbers, or 4 rows of 4";

/// A pose as files hold it.
#[derive(Deserialize)]
#[serde(untagged, expecting = "16 numbers, or 4 rows of 4")]
enum PoseText {
    Flat(Vec<PoseNumber>),
    Rows(Vec<[PoseNumber; 4]>),
}

/// A number of a pose. A null stands for one that is not finite.
#[derive(Deserialize, Clone, Copy)]
#[serde(untagged)]
enum PoseNumber {
    Finite(f64),
    Other(Option<NotFinite>),
}

/// The names of numbers that are not finite, as [`with_quoted_nan`] leaves them.
#[derive(Deserialize, Clone, Copy)]
enum NotFinite {
    #[serde(alias = "Infinity", alias = "-Infinity")]
    NaN,
}

impl PoseText {
    fn matrix(self, keys: &Keys<'_>, key: &str) -> Result<[f64; 16], ReadError> {
        let numbers = match self {
            Self::Flat(numbers) => numbers,
            Self::Rows(rows) => rows.concat(),
        };
        let number = |number| match number {
            PoseNumber::Finite(number) => number,
            PoseNumber::Other(None | Some(NotFinite::NaN)) => f64::NAN,
        };
        let numbers: Vec<f64> = numbers.into_iter().map(number).collect();
        let found = numbers.len();
        let wrong = |_| keys.wrong(key, &format!("{POSE}; it has {found} numbers"));
        numbers.try_into().map_err(wrong)
    }
}

fn pose_sigma(keys: &Keys<'_>) -> Result<Option<PoseSigma>, ReadError> {
    let sigma: Option<PoseSigma> = keys.optional("pose_sigma")?;
    let positive = |n: f64| n.is_finite() && n > 0.0;
    if sigma.is_some_and(|s| !(positive(s.rotation) && positive(s.translation))) {
        let wanted = "{\"rotation\": radians, \"translation\": length}, both positive";
        return Err(keys.wrong("pose_sigma", wanted));
    }
    Ok(sigma)
}

fn surface_sigma(keys: &Keys<'_>) -> Result<Option<f64>, ReadError> {
    let sigma = keys.optional("surface_sigma")?;
    match sigma {
        Some(sigma) if !is_surface_sigma(sigma) => Err(keys.wrong("surface_sigma", SURFACE_SIGMA)),
        _ => Ok(sigma),
    }
}

/// The true pose, which modelling does not use. Text and objects are notes of other programs and
/// count as absent.
fn pose_true(keys: &Keys<'_>) -> Result<Option<[f64; 16]>, ReadError> {
    let key = "pose_true";
    let text = keys.get(key).and_then(|value| PoseText::deserialize(value).ok());
    text.map(|text| text.matrix(keys, key)).transpose()
}

/// The text with `NaN`, `Infinity` and `-Infinity` in quotes. The error can then name the view and
/// the key instead of a place in the text, and a key with such a value differs from an absent one.
fn with_quoted_nan(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let (mut rest, mut in_string) = (text, false);
    while let Some(c) = rest.chars().next() {
        let word = ["NaN", "-Infinity", "Infinity"].into_iter().find(|w| rest.starts_with(w));
        let (taken, kept) = match word.filter(|_| !in_string) {
            // Later columns in messages shift by two.
            Some(word) => (word.len(), format!("\"{word}\"")),
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

#[cfg(test)]
mod tests {
    use super::*;

    /// What the reader says of a manifest with a view and a sigma.
    fn read(sigma: &str, view: &str) -> Result<Manifest, String> {
        let text = format!(
            r#"{{"unit": "m", {sigma} "views": [{{"file": "a.npy", "sensor": "spherical",
                "theta0": 0, "dtheta": 1, "phi0": 0, "dphi": 1, {view}
                "pose": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}}]}}"#
        );
        let read = manifest(Path::new("scan.json"), &text);
        read.map(|(manifest, _)| manifest).map_err(|e| e.to_string())
    }

    #[test]
    fn a_number_that_is_not_finite_differs_from_an_absent_key() {
        for word in ["NaN", "Infinity", "-Infinity"] {
            let error = read(&format!(r#""sigma": {word},"#), "").unwrap_err();
            let found = format!("invalid type: string \"{word}\", expected f64");
            assert_eq!(error, format!("scan.json: \"sigma\": {found}"));
            let error = read("", &format!(r#""scale": {word},"#)).unwrap_err();
            assert_eq!(error, format!("scan.json, view 0 (a.npy): \"scale\": {found}"));
        }
        assert_eq!(read(r#""sigma": null,"#, "").unwrap().sigma, None);
    }

    /// Such pixels are missing in any case. Poses of other programs are notes.
    #[test]
    fn missing_pixels_and_true_poses_may_be_no_numbers() {
        let read = read(r#""missing": NaN, "size": NaN,"#, r#""missing": 9, "pose_true": NaN,"#);
        let view = &read.unwrap().views[0];
        assert_eq!((view.missing, view.pose_true), (Some(MissingValue::Number(9.0)), None));
        let flat = vec!["NaN"; 16].join(",");
        let view = &self::read("", &format!("\"pose_true\": [{flat}],")).unwrap().views[0];
        assert!(view.pose_true.unwrap()[0].is_nan());
    }
}
