//! Why a measurement failed.

use std::error::Error;
use std::fmt;
use std::path::Path;
use std::process::ExitCode;
use transect_workflow::with_causes;

/// Why a measurement failed: exit code 1.
#[derive(Debug)]
pub struct Failure(Box<dyn Error>);

impl Failure {
    /// A failure in one sentence.
    pub fn because(reason: impl Into<String>) -> Self {
        Self(reason.into().into())
    }

    /// A failure to do something with a file.
    pub fn with_file(path: &Path, error: impl std::fmt::Display) -> Self {
        Self::because(format!("{}: {error}", path.display()))
    }

    /// Prints the failure and its causes, and gives the exit code.
    pub fn report(&self) -> ExitCode {
        eprintln!("error: {self}");
        ExitCode::FAILURE
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&with_causes(self.0.as_ref()))
    }
}

impl<E: Error + 'static> From<E> for Failure {
    fn from(error: E) -> Self {
        Self(Box::new(error))
    }
}
