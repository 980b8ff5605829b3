//! The room without noise in files that other programs write: are its sections the same?
//!
//! `xtask/foreign/run.py` writes the files, runs `transect reconstruct`, and compares.

use super::output::Output;
use super::python;
use crate::failure::Failure;
use crate::table::say;
use std::path::PathBuf;

/// Options of `experiments formats`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Python with the modules of xtask/foreign/requirements.txt [default: the one in
    /// target/foreign, else python3].
    #[arg(long, value_name = "PATH")]
    python: Option<PathBuf>,
}

/// Runs the experiment, or tells why it is skipped.
pub fn run(arguments: &Arguments, out: &Output) -> Result<Option<String>, Failure> {
    let python = python::find("foreign", arguments.python.as_ref());
    let modules = "numpy, pye57, imageio, open3d, pypcd4, plyfile";
    let missing = python::missing(&python, modules, "foreign", "");
    if missing.is_none() {
        let table = python::run(&python, "foreign/run.py", &[])?;
        say(&table);
        out.write("table", &table)?;
    }
    Ok(missing)
}
