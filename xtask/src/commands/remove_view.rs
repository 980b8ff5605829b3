//! `cargo xtask remove-view`: takes a view out of a model store.

use super::model_file::{open_finished, setup_of, view_named};
use crate::failure::Failure;
use crate::table::{Row, print};
use std::path::PathBuf;
use transect::Grower;

/// Options of `remove-view`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model store.
    file: PathBuf,
    /// The view, as list-views names it.
    name: String,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = &arguments.file;
    let store = open_finished(path)?;
    let setup = setup_of(path, store.read()?.header())?;
    let id = view_named(&store, path, &arguments.name)?;
    let removed = Grower::new(&store, &setup)?.remove_view(&id)?;
    let rows = [
        Row::new("removed", id.to_string(), ""),
        Row::count("planes fused anew", removed.planes.len()),
        Row::count("views left", store.views()?.len()),
    ];
    store.close()?;
    print(&rows);
    Ok(())
}
