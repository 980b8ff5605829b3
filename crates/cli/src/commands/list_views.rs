//! `transect list-views`: the views of a model store.

use crate::failure::Failure;
use crate::table::{Lengths, length, print_grid};
use std::path::PathBuf;
use transect_geometry::{LengthUnit, Point3};
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
    let store = read_store(&arguments.file)?;
    let (views, unit) = (store.views()?, store.read()?.header().unit);
    let place = |view: &StoredView| Point3::from(view.entry.world_from_sensor.translation.vector);
    let farthest = views.iter().map(|view| place(view).coords.amax()).fold(0.0, f64::max);
    let places = Lengths::new(unit, farthest);
    let position = format!("position, {}", places.unit);
    let heads = ["view", "sensor", "planes", "curves", "nodes", "noise", &position, "hash", "scan"];
    let line = |view: &StoredView| line(view, unit, places.place(&place(view)));
    print_grid(&heads, &views.iter().map(line).collect::<Vec<_>>());
    Ok(())
}

fn line(view: &StoredView, unit: LengthUnit, position: String) -> Vec<String> {
    let entry = &view.entry;
    vec![
        entry.id.to_string(),
        entry.sensor.clone(),
        view.planes.len().to_string(),
        view.curves.to_string(),
        view.nodes.to_string(),
        entry.sigma.map_or("unknown".to_owned(), |sigma| length(sigma, unit)),
        position,
        entry.source_hash.clone(),
        entry.source.clone(),
    ]
}
