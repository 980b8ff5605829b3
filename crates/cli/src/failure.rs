//! The error message and the exit code of a command that failed.

use crate::printable::lines;
use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use transect_workflow::{WorkflowError, as_options, with_causes};

/// Why a command failed.
#[derive(Debug)]
pub enum Failure {
    /// The arguments cannot be used: exit code 2.
    Usage(String),
    /// Something went wrong: exit code 1.
    Failed(Box<dyn Error>),
}

impl Failure {
    /// A failure to do something with a file.
    pub fn with_file(path: &Path, error: impl std::fmt::Display) -> Self {
        Self::Failed(format!("{}: {error}", path.display()).into())
    }

    /// Prints the failure and its causes, and gives the exit code.
    pub fn report(&self) -> ExitCode {
        match self {
            Self::Usage(reason) => {
                eprintln!("error: {}", lines(&as_options(reason)));
                ExitCode::from(2)
            }
            Self::Failed(error) => {
                eprintln!("error: {}", lines(&with_causes(error.as_ref())));
                ExitCode::FAILURE
            }
        }
    }
}

impl<E: Error + 'static> From<E> for Failure {
    fn from(error: E) -> Self {
        let error: Box<dyn Error> = Box::new(error);
        match error.downcast_ref::<WorkflowError>() {
            Some(WorkflowError::Setting { setting, problem }) => {
                Self::Usage(format!("--{}: {problem}", setting.replace('_', "-")))
            }
            Some(WorkflowError::NoInterval) => {
                Self::Usage(format!("{error}; pass --interval, such as --interval 10mm"))
            }
            Some(WorkflowError::Planes(guide)) => Self::Usage(guide.to_string()),
            _ => Self::Failed(error),
        }
    }
}
