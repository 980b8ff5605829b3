//! How fusion behaves: drift, noise, sheets, time and scale, on curves whose truth is known.
//!
//! Curves are made directly on the planes, as views would see them, with their noise across the
//! curve: what is measured is fusion alone, without sensors, images and partial modelling.

mod drift;
mod noise;
mod rings;
mod scale;
mod sheets;
mod time;

use crate::failure::Failure;
use crate::table::say;

/// Options of `experiments fusion`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Views along the tunnel; one for every half metre.
    #[arg(long, default_value_t = 2000, value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(100..=100_000))]
    tunnel_views: u32,
}

/// Runs the experiment.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    drift::print();
    say("");
    noise::print();
    say("");
    sheets::print();
    say("");
    time::print();
    say("");
    scale::print(arguments.tunnel_views);
    Ok(())
}
