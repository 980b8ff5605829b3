//! Why a measurement failed, or was skipped.

use std::error::Error;
use std::fmt;
use std::path::Path;
use transect_workflow::with_causes;

/// Why a measurement has no result.
#[derive(Debug)]
pub enum Failure {
    /// An input or another program is missing. The sentence tells which one.
    Skipped(String),
    /// It failed: exit code 1.
    Failed(Box<dyn Error>),
}

impl Failure {
    /// A failure in one sentence.
    pub fn because(reason: impl Into<String>) -> Self {
        Self::Failed(reason.into().into())
    }

    /// A failure to do something with a file.
    pub fn with_file(path: &Path, error: impl fmt::Display) -> Self {
        Self::because(format!("{}: {error}", path.display()))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Skipped(reason) => f.write_str(reason),
            Self::Failed(error) => f.write_str(&with_causes(error.as_ref())),
        }
    }
}

impl<E: Error + 'static> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Failed(Box::new(error))
    }
}
