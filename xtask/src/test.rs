//! `cargo xtask test`: the tests.

use crate::run::{Failure, cargo, run_command};
use std::ffi::OsString;

/// Runs the tests; `arguments` go to `cargo test`, such as a test's name.
pub fn run(arguments: &[OsString]) -> Result<(), Failure> {
    run_command(cargo().args(["test", "--workspace"]).args(arguments))
}
