//! Problems of a description, each with its place and key.

use crate::LARGEST;
use std::fmt;

/// Why a text is not a scene description.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DescriptionError {
    /// Broken TOML, a missing or unknown key, an unknown primitive, or a value of another type.
    #[error(transparent)]
    Syntax(#[from] toml::de::Error),
    /// Impossible values, one problem for every faulty entry.
    #[error("{}", lines(.0))]
    Invalid(Vec<Problem>),
}

fn lines(problems: &[Problem]) -> String {
    problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("\n")
}

/// A problem at a key of a description.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// The table or the entry, such as `solid 3 "leg"`; entries count from 1.
    pub place: String,
    /// The key in it.
    pub key: &'static str,
    /// The problem with its value.
    pub reason: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, key {}: {}", self.place, self.key, self.reason)
    }
}

/// The place of a problem.
pub(super) struct Place(String);

impl Place {
    /// A table.
    pub fn new(table: &str) -> Self {
        Self(table.to_owned())
    }

    /// An entry of an array of tables, by its index from 0 and its name if it has one.
    pub fn entry(table: &str, index: usize, name: Option<&str>) -> Self {
        let named = name.map(|n| format!(" {n:?}")).unwrap_or_default();
        Self(format!("{table} {}{named}", index + 1))
    }

    /// A problem at a key.
    pub fn problem(&self, key: &'static str, reason: impl fmt::Display) -> Problem {
        Problem { place: self.0.clone(), key, reason: reason.to_string() }
    }

    /// A value if it is a number, right, and at most [`LARGEST`] in size.
    pub fn value(
        &self,
        key: &'static str,
        value: f64,
        right: impl Fn(f64) -> bool,
        wanted: &str,
    ) -> Result<f64, Problem> {
        if value.abs() > LARGEST {
            let wanted = format_args!("{value:?} is not a number of at most {LARGEST:e}");
            Err(self.problem(key, wanted))
        } else if right(value) && !value.is_nan() {
            Ok(value)
        } else {
            Err(self.problem(key, format_args!("{value} is not {wanted}")))
        }
    }

    /// A length of at least 0.
    pub fn length(&self, key: &'static str, value: f64) -> Result<f64, Problem> {
        self.value(key, value, |v| v >= 0.0, "a length of at least 0")
    }

    /// Three finite numbers.
    pub fn triple<T: From<[f64; 3]>>(
        &self,
        key: &'static str,
        value: [f64; 3],
    ) -> Result<T, Problem> {
        for component in value {
            self.value(key, component, |_| true, "a finite number")?;
        }
        Ok(T::from(value))
    }

    /// A value that an entry of this kind must have.
    pub fn needed<T>(&self, key: &'static str, value: Option<T>, kind: &str) -> Result<T, Problem> {
        value.ok_or_else(|| self.problem(key, format_args!("it is missing, a {kind} needs it")))
    }

    /// Refuses a key that an entry of this kind does not have.
    pub fn refuse(&self, key: &'static str, given: bool, kind: &str) -> Result<(), Problem> {
        if given {
            Err(self.problem(key, format_args!("it means nothing for a {kind}")))
        } else {
            Ok(())
        }
    }
}
