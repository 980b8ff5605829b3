//! How good one view's curves are: accuracy by method, noise, surface and angle, and what the noise
//! step does to whole scenes.

mod accuracy;
mod error;
mod noise_step;
mod surface;

use crate::failure::Failure;
use crate::table::say;

/// Options of `experiments partial`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Rows and columns of the camera of the accuracy tables.
    #[arg(long, default_value_t = 256, value_name = "NUMBER")]
    size: usize,
    /// Only this table.
    #[arg(long, value_enum, value_name = "NAME")]
    table: Option<Table>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Table {
    /// Error by method, subpixel solution, noise, surface, and angle between surface and plane.
    Accuracy,
    /// One view before and after smoothing, on the bundled scenes.
    Noise,
}

/// Runs the experiment.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let chosen = |table: Table| arguments.table.is_none_or(|t| t == table);
    if chosen(Table::Accuracy) {
        accuracy::run(arguments.size)?;
    }
    if chosen(Table::Noise) {
        noise_step::run()?;
    }
    say("");
    Ok(())
}
