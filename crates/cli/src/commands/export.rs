//! `transect export`: the curves of a model as files for others, or a whole store as lines of JSON.

use super::{note_finished, open_model};
use crate::failure::Failure;
use crate::table::{Row, print};
use clap::builder::PossibleValuesParser;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use transect_exchange::write_file;
use transect_workflow::{ResultFolder, StoreFile, dxf_frame};

/// Options of `export`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model store or model file.
    file: PathBuf,
    /// File for everything in a store, views and their own curves included, as lines of JSON.
    #[arg(long, value_name = "FILE", required_unless_present = "out")]
    lines: Option<PathBuf>,
    /// Folder for model.transect, contours.json, model.dxf and the pictures.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Frame of the curves in model.dxf.
    #[arg(long, value_parser = PossibleValuesParser::new(["world", "plane"]), default_value = "world", value_name = "FRAME")]
    dxf: String,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut rows = Vec::new();
    if let Some(lines) = &arguments.lines {
        write_lines(&arguments.file, lines)?;
        rows.push(Row::new("lines", lines.display().to_string(), ""));
    }
    if let Some(out) = &arguments.out {
        let model = open_model(&arguments.file)?.into_model()?;
        let name = arguments.file.file_stem().unwrap_or_default().to_string_lossy();
        ResultFolder::new(out).write_model(&name, &model, dxf_frame(&arguments.dxf)?)?;
        rows.push(Row::new("results", out.display().to_string(), ""));
    }
    print(&rows);
    Ok(())
}

fn write_lines(file: &Path, lines: &Path) -> Result<(), Failure> {
    let store = StoreFile::open(file)?;
    note_finished(store.planes_finished());
    let mut failed = None;
    let written = write_file(lines, |out| {
        store.store().export(BufWriter::new(out)).map_err(|error| {
            failed = Some(error);
            std::io::Error::other("the export stopped")
        })
    });
    // What the store says names the cause.
    match failed {
        Some(error) => Err(error.into()),
        None => Ok(written?),
    }
}
