//! `transect import`: a model store from the JSON lines that `export --lines` wrote.

use crate::failure::Failure;
use crate::table::{Row, print};
use std::io::BufReader;
use std::path::PathBuf;
use transect_model::open_regular;
use transect_model::store::{Store, StoreProblem};

/// Options of `import`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// File of JSON lines.
    lines: PathBuf,
    /// Model store to make; the file must not exist yet.
    file: PathBuf,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let lines = open_regular(&arguments.lines);
    let lines = lines.map_err(|e| Failure::with_file(&arguments.lines, e))?;
    let store = Store::import(&arguments.file, BufReader::new(lines));
    let store = store.map_err(|error| match error.problem {
        StoreProblem::Import { line, problem } => {
            Failure::with_file(&arguments.lines, format!("line {line}: {problem}"))
        }
        _ => error.into(),
    })?;
    let rows = [
        Row::plain("views", store.views()?.len()),
        Row::plain("planes", store.read()?.plane_count()?),
        Row::plain("store", arguments.file.display()),
    ];
    store.close()?;
    print(&rows);
    Ok(())
}
