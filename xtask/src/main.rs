//! The command line of Transect: `cargo xtask <command>`.
//!
//! One file per command; this one is the list of what exists. Results go to stdout, progress and
//! warnings to stderr. Exit codes: 0 done, 1 failed, 2 bad arguments.
#![allow(clippy::print_stderr, reason = "progress, notes and errors go there")]

mod commands;
mod failure;
mod memory;
mod progress;
mod simulation;
mod table;

use clap::{Parser, Subcommand};
use commands::{
    bench, check, evaluate, experiments, inspect, manifest, reconstruct, simulate, test,
};
use std::process::ExitCode;

/// Registered range images in, cross-section models out.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make a cross-section model of a scan; without a scan, of the bundled room.
    Reconstruct(reconstruct::Arguments),
    /// Write a scan of a simulated scene, with its truth.
    Simulate(simulate::Arguments),
    /// Score a model against a reference mesh, or against the truth that simulation left.
    Evaluate(evaluate::Arguments),
    /// Say what is in a scan: views, sizes, noise, extent, and what its reader found odd.
    Inspect(inspect::Arguments),
    /// Write a scan.json for a folder of depth images with poses.
    Manifest(manifest::Arguments),
    /// Measure what the documentation states, such as every sensor's accuracy.
    Experiments(experiments::Arguments),
    /// Run the tests.
    Test(test::Arguments),
    /// Measure the speed of a stage, beside what it is compared with.
    Bench(bench::Arguments),
    /// Run everything that CI runs.
    Check(check::Arguments),
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Reconstruct(a) => reconstruct::run(&a),
        Command::Simulate(a) => simulate::run(&a),
        Command::Evaluate(a) => evaluate::run(&a),
        Command::Inspect(a) => inspect::run(&a),
        Command::Manifest(a) => manifest::run(&a),
        Command::Experiments(a) => experiments::run(&a),
        Command::Test(a) => test::run(&a),
        Command::Bench(a) => bench::run(&a),
        Command::Check(a) => check::run(&a),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
