//! `transect export`: the curves of a model as files for other programs, or a store as JSON lines.

use super::{DxfArguments, open_model};
use crate::failure::Failure;
use crate::table::{Row, print};
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use transect_exchange::write_file;
use transect_workflow::{ModelFile, ResultFolder, claim_lines, find_model};

/// Options of `export`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model store, model file, or folder that `reconstruct` wrote.
    file: PathBuf,
    /// File for the whole content of a store as JSON lines: planes, views and the views' own
    /// curves.
    #[arg(long, value_name = "FILE")]
    lines: Option<PathBuf>,
    /// Folder for model.transect, contours.json, model.dxf and the pictures.
    #[arg(long, value_name = "DIR", required_unless_present = "lines")]
    out: Option<PathBuf>,
    #[command(flatten)]
    dxf: DxfArguments,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.out.is_none() && arguments.dxf.dxf.is_some() {
        let problem = "--dxf: the option is about model.dxf, and --lines without --out writes no \
                       model.dxf; pass --out DIR, or leave out --dxf";
        return Err(Failure::Usage(problem.to_owned()));
    }
    let (inputs, mut rows) = ([find_model(&arguments.file)?], Vec::new());
    let folder = arguments.out.as_ref().map(ResultFolder::new);
    folder.iter().try_for_each(|folder| folder.claim(&inputs))?;
    arguments.lines.iter().try_for_each(|lines| claim_lines(lines, &inputs))?;
    if let Some(lines) = &arguments.lines {
        write_lines(&arguments.file, lines)?;
        rows.push(Row::plain("lines", lines.display()));
    }
    if let Some(folder) = folder {
        let model = open_model(&arguments.file)?.into_model()?;
        if model.sections().len() == 0 {
            let problem = "the model has no curves, so there are no results to write";
            return Err(Failure::with_file(&arguments.file, problem));
        }
        let name = arguments.file.file_stem().unwrap_or_default().to_string_lossy();
        folder.write_model(&name, &model, arguments.dxf.frame())?;
        rows.push(Row::plain("results", folder.path().display()));
    }
    print(&rows);
    Ok(())
}

fn write_lines(file: &Path, lines: &Path) -> Result<(), Failure> {
    let ModelFile::Store(store) = open_model(file)? else {
        return Err(Failure::with_file(file, "a plain model file has no views to export as lines"));
    };
    let mut failed = None;
    let written = write_file(lines, |out| {
        store.snapshot.export(BufWriter::new(out)).map_err(|error| {
            failed = Some(error);
            std::io::Error::other("the export stopped")
        })
    });
    // The store's error names the cause, the file's error does not.
    match failed {
        Some(error) => Err(error.into()),
        None => Ok(written?),
    }
}
