//! One file per command.

use crate::failure::Failure;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use transect_exchange::DxfFrame;
use transect_workflow::ModelFile;

pub mod align;
pub mod compact;
pub mod evaluate;
pub mod explain;
pub mod explain_growth;
pub mod export;
pub mod gaps;
pub mod import;
pub mod inspect;
pub mod list_views;
pub mod manifest;
pub mod measure;
pub mod query;
pub mod reconstruct;
pub mod register;
pub mod remove_view;
pub mod replace_view;
pub mod simulate;
pub mod verify;

mod inspect_model;
mod lengths;
mod method;
mod planes;
mod scan;

/// The frame of drawings.
#[derive(Debug, clap::Args)]
struct DxfArguments {
    /// Frame of the curves in model.dxf: 3D polylines in the world, or 2D polylines in the
    /// coordinates of their planes, stacked by station [default: world].
    #[arg(long, value_name = "FRAME",
        value_parser = named([("world", DxfFrame::World), ("plane", DxfFrame::Plane)]))]
    dxf: Option<DxfFrame>,
}

impl DxfArguments {
    /// The frame that the option names, or the default.
    fn frame(&self) -> DxfFrame {
        self.dxf.unwrap_or(DxfFrame::World)
    }
}

/// A parser of names that stand for values.
fn named<T: Clone + Send + Sync + 'static>(
    values: impl IntoIterator<Item = (&'static str, T)>,
) -> impl TypedValueParser<Value = T> {
    let values: Vec<(&str, T)> = values.into_iter().collect();
    let names: Vec<&str> = values.iter().map(|(name, _)| *name).collect();
    PossibleValuesParser::new(names).try_map(move |name| {
        let value = values.iter().find(|(own, _)| *own == name).map(|(_, value)| value.clone());
        value.ok_or("unknown name")
    })
}

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
