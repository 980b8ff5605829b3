//! `cargo xtask bench`: how fast, beside what.

pub mod partial;
mod peers;
mod scene;
pub mod timing;

use crate::failure::Failure;

/// Options of `bench`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    stage: Stage,
}

#[derive(Debug, clap::Subcommand)]
enum Stage {
    /// The partial modeler: one view to curves on all planes.
    Partial(partial::Arguments),
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.stage {
        Stage::Partial(a) => partial::run(a),
    }
}
