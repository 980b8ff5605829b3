//! What a command that failed says, once: one line and its causes.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

/// Why a command failed.
#[derive(Debug)]
pub enum Failure {
    /// The arguments make no sense together: exit code 2.
    Usage(String),
    /// Something went wrong: exit code 1.
    Failed(Box<dyn Error>),
}

impl Failure {
    /// A failure in one sentence.
    pub fn because(reason: impl Into<String>) -> Self {
        Self::Failed(reason.into().into())
    }

    /// A failure to do something with a file.
    pub fn with_file(path: &Path, error: impl std::fmt::Display) -> Self {
        Self::because(format!("{}: {error}", path.display()))
    }

    /// Prints the failure and its causes, and gives the exit code.
    pub fn report(&self) -> ExitCode {
        match self {
            Self::Usage(reason) => {
                eprintln!("error: {reason}");
                ExitCode::from(2)
            }
            Self::Failed(error) => {
                eprintln!("error: {error}");
                let mut cause = error.source();
                while let Some(error) = cause {
                    eprintln!("  because: {error}");
                    cause = error.source();
                }
                ExitCode::FAILURE
            }
        }
    }
}

impl<E: Error + 'static> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Failed(Box::new(error))
    }
}
