//! One file per command.

use crate::failure::Failure;
use transect_workflow::ModelFile;

pub mod compact;
pub mod evaluate;
pub mod export;
pub mod gaps;
pub mod import;
pub mod inspect;
pub mod list_views;
pub mod manifest;
pub mod measure;
pub mod query;
pub mod reconstruct;
pub mod remove_view;
pub mod replace_view;
pub mod simulate;
pub mod verify;

mod inspect_model;
mod planes;

/// Says that planes were fused which an interrupted run had left.
fn note_finished(planes: usize) {
    if planes > 0 {
        eprintln!("note: {planes} planes that an interrupted run had left were fused first");
    }
}

/// Opens a model file or a store for reading.
fn open_model(path: &std::path::Path) -> Result<ModelFile, Failure> {
    let file = ModelFile::open(path)?;
    let planes = file.planes_finished();
    if planes > 0 {
        eprintln!(
            "note: {planes} planes that an interrupted run had left were fused in memory; repeat \
             the run to store them"
        );
    }
    Ok(file)
}
