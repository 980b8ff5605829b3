//! `transect remove-view`: removes a view from a model store.

use super::note_finished;
use crate::failure::Failure;
use crate::table::{Row, print};
use std::path::PathBuf;
use transect_workflow::StoreFile;

/// Options of `remove-view`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model store.
    file: PathBuf,
    /// Name of the view, as list-views prints it.
    name: String,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let store = StoreFile::open(&arguments.file)?;
    note_finished(store.planes_finished());
    let removed = store.remove_view(&arguments.name)?;
    let rows = [
        Row::plain("removed", removed.entry.id),
        Row::plain("planes fused anew", removed.planes.len()),
        Row::plain("views left", store.store().views()?.len()),
    ];
    store.close()?;
    print(&rows);
    Ok(())
}
