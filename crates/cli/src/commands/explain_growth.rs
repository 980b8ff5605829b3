//! `transect explain-growth`: a figure of a plane after every view, and one that repeats all of
//! them.

use super::explain::DrawingArguments;
use crate::failure::Failure;

/// Options of `explain-growth`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    drawing: DrawingArguments,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    arguments
        .drawing
        .run("explain-growth", |scan, settings, plane| scan.explain_growth(settings, plane))
}
