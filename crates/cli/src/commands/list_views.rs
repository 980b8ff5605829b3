//! `transect list-views`: the views of a model store.

use crate::failure::Failure;
use crate::table::{digits, print_grid};
use std::path::PathBuf;
use transect_model::store::StoredView;
use transect_workflow::read_store;

/// Options of `list-views`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model store.
    file: PathBuf,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let views = read_store(&arguments.file)?.views()?;
    let heads =
        ["view", "sensor", "planes", "curves", "nodes", "noise", "position", "hash", "scan"];
    print_grid(&heads, &views.iter().map(line).collect::<Vec<_>>());
    Ok(())
}

fn line(view: &StoredView) -> Vec<String> {
    let entry = &view.entry;
    let position: [f64; 3] = entry.world_from_sensor.translation.vector.into();
    vec![
        entry.id.to_string(),
        entry.sensor.clone(),
        view.planes.len().to_string(),
        view.curves.to_string(),
        view.nodes.to_string(),
        entry.sigma.map_or("unknown".to_owned(), digits),
        position.map(digits).join(", "),
        entry.source_hash.clone(),
        entry.source.clone(),
    ]
}
