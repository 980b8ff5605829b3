//! `cargo xtask test`: the tests.

use super::{cargo, run_command};
use crate::failure::Failure;

/// Options of `test`.
#[derive(Debug, Default, clap::Args)]
pub struct Arguments {
    /// Passed on to `cargo test`, such as a test's name.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    rest: Vec<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    run_command(cargo().args(["test", "--workspace"]).args(&arguments.rest))
}
