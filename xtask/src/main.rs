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
    bench, check, compact, evaluate, experiments, export, gaps, import, inspect, list_views,
    manifest, measure, query, reconstruct, remove_view, replace_view, simulate, test, verify,
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
    /// Say what is in a scan, or in a model: views, sizes, noise, extent, and what its reader found odd.
    Inspect(inspect::Arguments),
    /// List the views of a model store.
    ListViews(list_views::Arguments),
    /// Take a view out of a model store.
    RemoveView(remove_view::Arguments),
    /// Put a new image or a new pose in a view's place in a model store.
    ReplaceView(replace_view::Arguments),
    /// Check a model or a model store: checksums, and everything that is promised of its contents.
    Verify(verify::Arguments),
    /// Give the space of removed views back to the disk.
    Compact(compact::Arguments),
    /// Say whether points are inside or outside of the solid, or unknown, and how far its curves are.
    Query(query::Arguments),
    /// List what nobody saw, and where next views would see most of it.
    Gaps(gaps::Arguments),
    /// Measure each plane of a model, and the volume between them.
    Measure(measure::Arguments),
    /// Write the curves of a model as files for others, or a whole store as lines of JSON.
    Export(export::Arguments),
    /// Make a model store of lines of JSON.
    Import(import::Arguments),
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
        Command::ListViews(a) => list_views::run(&a),
        Command::RemoveView(a) => remove_view::run(&a),
        Command::ReplaceView(a) => replace_view::run(&a),
        Command::Verify(a) => verify::run(&a),
        Command::Compact(a) => compact::run(&a),
        Command::Query(a) => query::run(&a),
        Command::Gaps(a) => gaps::run(&a),
        Command::Measure(a) => measure::run(&a),
        Command::Export(a) => export::run(&a),
        Command::Import(a) => import::run(&a),
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
