//! The integration tests of the crate, in one program.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers may fail loudly")]

mod documentation;
mod fuzz;
mod inputs;
