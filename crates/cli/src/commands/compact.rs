//! `transect compact`: gives the space of removed and replaced views back to the disk.

use crate::failure::Failure;
use crate::table::{Row, digits, print};
use std::path::PathBuf;
use transect_workflow::{find_model, open_store};

/// Options of `compact`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model store.
    file: PathBuf,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = &find_model(&arguments.file)?;
    let size = || std::fs::metadata(path).map(|m| m.len()).map_err(|e| Failure::with_file(path, e));
    let mut store = open_store(path)?;
    let before = size()?;
    store.compact()?;
    store.close()?;
    let mib = |bytes: u64| digits(bytes as f64 / f64::from(1 << 20));
    print(&[Row::new("before", mib(before), "MiB"), Row::new("after", mib(size()?), "MiB")]);
    Ok(())
}
