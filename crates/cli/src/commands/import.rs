//! `transect import`: a model store of the lines that `export --lines` wrote.

use crate::failure::Failure;
use crate::table::{Row, print};
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;
use transect_model::store::Store;

/// Options of `import`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Lines of JSON.
    lines: PathBuf,
    /// Model store to make; must not be there yet.
    file: PathBuf,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let lines = File::open(&arguments.lines);
    let lines = lines.map_err(|e| Failure::with_file(&arguments.lines, e))?;
    let store = Store::import(&arguments.file, BufReader::new(lines))?;
    let rows = [
        Row::count("views", store.views()?.len()),
        Row::new("planes", store.read()?.plane_count()?.to_string(), ""),
        Row::new("store", arguments.file.display().to_string(), ""),
    ];
    store.close()?;
    print(&rows);
    Ok(())
}
