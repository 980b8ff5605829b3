//! The program `transect` from end to end, in folders of its own.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "tests and their helpers fail loudly, and say what they skip"
)]

mod align;
mod bad_input;
mod bridges;
mod command_line;
mod common;
mod dissertation;
mod evaluate;
mod explain;
mod full_disk;
mod implausible;
mod launcher;
mod options;
mod outputs;
mod real_scans;
mod register;
mod selection;
mod sensors;
mod settings;
mod store;
