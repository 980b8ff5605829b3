//! The room without noise in files that other programs write: are its sections the same?
//!
//! `xtask/foreign/run.py` writes the files, runs `transect reconstruct`, and compares.

use super::lab::Lab;
use super::python;
use crate::failure::Failure;
use crate::table::say;

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    let modules = "numpy, pye57, imageio, open3d, pypcd4, plyfile";
    let python = lab.python("foreign", modules, "")?;
    let table = python::run(&python, "foreign/run.py", &[])?;
    say(&table);
    lab.write("table", &table)
}
