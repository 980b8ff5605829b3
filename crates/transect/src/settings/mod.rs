//! The settings of a store: how a [`Setup`] is written into its header, and compared with it.
//!
//! A store can only grow with the settings it was made with. Its header keeps them as a record of
//! named fields (JSON), for example
//! `{"version":1,"partial":{"one_pass":{"gap":4,…}},"fusion":{"consensus":{…}}}`.
//!
//! * A field that is absent has its default, so a program with a new option opens older stores.
//! * A field that this program does not know is an error that names the field.
//! * Stores that were made before there was a record have their settings in another form, which
//!   `debug_text` reads.

mod debug_text;

use crate::Setup;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use transect_fusion::FusionMethod;
use transect_geometry::{Guide, LengthUnit};
use transect_model::store::StoreHeader;
use transect_partial::Method;

/// Version of the record. A new option needs no new version; a new meaning of an old one does.
const VERSION: u32 = 1;

/// Why the settings in a store cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// A newer program made the store.
    #[error(
        "its settings have version {found}; this program reads version {VERSION}. \
         Use the program that made the store ({tool}), or a newer one"
    )]
    NewerVersion {
        /// Version of the record.
        found: u32,
        /// The program that made the store.
        tool: String,
    },
    /// The record has a field that this program does not know, or a value of the wrong type.
    #[error("its settings, made by {tool}, cannot be used")]
    Record {
        /// The program that made the store.
        tool: String,
        /// The field and the problem.
        source: serde_json::Error,
    },
    /// The settings are no record.
    #[error("its settings, made by {tool}, are not a record of named fields: {text:?}")]
    NoRecord {
        /// The program that made the store.
        tool: String,
        /// The settings as they are in the store.
        text: String,
    },
}

/// The settings of a store, as they are written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Record {
    version: u32,
    #[serde(default)]
    partial: Method,
    #[serde(default)]
    fusion: FusionMethod,
    #[serde(default = "yes")]
    free_space: bool,
}

fn yes() -> bool {
    true
}

impl Record {
    fn of(setup: &Setup) -> Self {
        let Setup { partial, fusion, free_space, .. } = *setup;
        Self { version: VERSION, partial, fusion, free_space }
    }

    fn read(header: &StoreHeader) -> Result<Self, SettingsError> {
        let StoreHeader { options: text, tool, .. } = header;
        let record = serde_json::from_str(text).ok().or_else(|| debug_text::record(text));
        let no_record = || SettingsError::NoRecord { tool: tool.clone(), text: text.clone() };
        let record: Value = record.ok_or_else(no_record)?;
        let version = record.get("version").and_then(Value::as_u64).ok_or_else(no_record)?;
        match u32::try_from(version) {
            Ok(VERSION) => serde_json::from_value(record)
                .map_err(|source| SettingsError::Record { tool: tool.clone(), source }),
            found => Err(SettingsError::NewerVersion {
                found: found.unwrap_or(u32::MAX),
                tool: tool.clone(),
            }),
        }
    }

    /// The named fields. They are numbers and words, which JSON can always hold.
    fn fields(&self) -> Value {
        serde_json::to_value(self).unwrap_or_default()
    }
}

impl Setup {
    /// The header of a store that is made with these settings.
    pub fn store_header(&self) -> StoreHeader {
        StoreHeader {
            unit: self.unit,
            planes: self.planes.clone(),
            options: Record::of(self).fields().to_string(),
            tool: concat!("transect ", env!("CARGO_PKG_VERSION")).to_owned(),
        }
    }

    /// The settings that a store was made with.
    ///
    /// # Errors
    /// [`SettingsError`] if a program with other options made it.
    pub fn of_store(header: &StoreHeader) -> Result<Self, SettingsError> {
        let Record { partial, fusion, free_space, .. } = Record::read(header)?;
        Ok(Self { partial, fusion, free_space, ..Self::new(header.unit, header.planes.clone()) })
    }

    /// How the settings of a store in the same unit differ from these; `None` if they do not.
    ///
    /// # Errors
    /// [`SettingsError`] if a program with other options made the store.
    pub fn difference(&self, header: &StoreHeader) -> Result<Option<String>, SettingsError> {
        let of = |name, value: [&dyn std::fmt::Display; 2]| {
            let [there, here] = value.map(ToString::to_string);
            (there != here).then(|| format!("{name}: the store has {there}, this run {here}"))
        };
        let planes = [&header.planes, &self.planes];
        let [there, here] = planes.map(|planes| planes.guide());
        let unit = self.unit;
        let along = (there != here).then(|| {
            let other_points = || "guide: its points differ from the store's guide".to_owned();
            of("guide", [&along(there, unit), &along(here, unit)]).unwrap_or_else(other_points)
        });
        let length = |name, [there, here]: [f64; 2]| {
            of(name, [&format!("{there} {unit}"), &format!("{here} {unit}")])
        };
        let mut different: Vec<String> = [
            along,
            length("offset", planes.map(|planes| planes.offset())),
            length("interval", planes.map(|planes| planes.interval())),
        ]
        .into_iter()
        .flatten()
        .collect();
        let (there, here) = (Record::read(header)?.fields(), Record::of(self).fields());
        list_differences("settings", &there, &here, &mut different);
        Ok((!different.is_empty()).then(|| different.join("; ")))
    }
}

/// Adds every field of two records that differs to a list.
fn list_differences(name: &str, there: &Value, here: &Value, different: &mut Vec<String>) {
    match (there, here) {
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => {
            for ((name, there), here) in a.iter().zip(b.values()) {
                list_differences(name, there, here, different);
            }
        }
        _ if there == here => {}
        _ => {
            // A method is an object with its name as the only key.
            let [there, here] = [there, here].map(|value| match value {
                Value::Object(method) => method.keys().next().cloned().unwrap_or_default(),
                value => value.to_string(),
            });
            let name = if name == "partial" { "method" } else { name };
            different.push(format!("{name}: the store has {there}, this run {here}"));
        }
    }
}

fn along(guide: &Guide, unit: LengthUnit) -> String {
    match guide {
        Guide::Straight(guide) => format!("the normal {:?}", <[f64; 3]>::from(guide.direction())),
        Guide::Curved(guide) => format!("a curve of {} {unit}", guide.length()),
    }
}

#[cfg(test)]
mod tests;
