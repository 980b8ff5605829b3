//! The command line of Transect: `transect <command>`.
//!
//! This file is the list of commands; each has a file of its own. Results go to stdout, progress,
//! notes and warnings to stderr. Exit codes: 0 done, 1 failed, 2 bad arguments.
#![allow(clippy::print_stderr, reason = "progress, notes and errors go there")]

mod commands;
mod failure;
mod notes;
mod printable;
mod progress;
mod table;
mod threads;

use clap::{Parser, Subcommand};
use commands::{
    align, compact, evaluate, explain, explain_growth, export, gaps, import, inspect, list_views,
    manifest, measure, query, reconstruct, register, remove_view, replace_view, simulate, verify,
};
use failure::Failure;
use std::io::{self, ErrorKind};
use std::process::ExitCode;
use transect_geometry::LengthUnit;

/// Registered range images in, cross-section models out.
#[derive(Debug, Parser)]
#[command(name = "transect", version, next_line_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// Unit of the lengths, areas and volumes that are printed: m, dm, cm, mm, um, in or ft
    /// [default: one in which each number is easy to read]. Files keep the model's unit.
    #[arg(long, global = true, value_name = "UNIT")]
    output_unit: Option<LengthUnit>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make a cross-section model of a scan; without a scan, of the bundled room.
    Reconstruct(Box<reconstruct::Arguments>),
    /// Write a scan of a simulated scene, with its truth.
    Simulate(simulate::Arguments),
    /// Score a model against a reference mesh or a simulated scan's truth.
    Evaluate(evaluate::Arguments),
    /// Draw each step of the methods on one view and one plane.
    Explain(explain::Arguments),
    /// Draw how a plane of a scan grows view by view, by --fusion pairwise.
    ExplainGrowth(explain_growth::Arguments),
    /// List the views, sizes, noise and extent of a scan, or the contents of a model.
    Inspect(inspect::Arguments),
    /// Refine the poses of a scan, or of the views in a model store.
    Register(Box<register::Arguments>),
    /// List the views of a model store.
    ListViews(list_views::Arguments),
    /// Remove a view from a model store.
    RemoveView(remove_view::Arguments),
    /// Replace the image or the pose of a view in a model store.
    ReplaceView(replace_view::Arguments),
    /// Check the checksums and the contents of a model or a model store.
    Verify(verify::Arguments),
    /// Give the space of removed views back to the disk.
    Compact(compact::Arguments),
    /// Tell whether points are inside the solid, outside, or unknown.
    Query(query::Arguments),
    /// List the surface that no view saw, and propose next views.
    Gaps(gaps::Arguments),
    /// Print bounds of the areas of each plane of a model, and of the volumes.
    Measure(measure::Arguments),
    /// Write a model's curves as files for other programs, or a store as JSON lines.
    Export(export::Arguments),
    /// Make a model store from JSON lines.
    Import(import::Arguments),
    /// Find a scanner's pose from scans of the machine table and of spheres.
    Align(align::Arguments),
    /// Write a scan.json for a folder of depth images with poses.
    Manifest(manifest::Arguments),
}

impl Command {
    /// Runs the command.
    fn run(self) -> Result<(), Failure> {
        threads::check(match &self {
            Self::Reconstruct(a) => a.threads,
            _ => 0,
        })?;
        match self {
            Self::Reconstruct(a) => reconstruct::run(&a),
            Self::Simulate(a) => simulate::run(&a),
            Self::Evaluate(a) => evaluate::run(&a),
            Self::Explain(a) => explain::run(&a),
            Self::ExplainGrowth(a) => explain_growth::run(&a),
            Self::Inspect(a) => inspect::run(&a),
            Self::Register(a) => register::run(&a),
            Self::ListViews(a) => list_views::run(&a),
            Self::RemoveView(a) => remove_view::run(&a),
            Self::ReplaceView(a) => replace_view::run(&a),
            Self::Verify(a) => verify::run(&a),
            Self::Compact(a) => compact::run(&a),
            Self::Query(a) => query::run(&a),
            Self::Gaps(a) => gaps::run(&a),
            Self::Measure(a) => measure::run(&a),
            Self::Export(a) => export::run(&a),
            Self::Import(a) => import::run(&a),
            Self::Align(a) => align::run(&a),
            Self::Manifest(a) => manifest::run(&a),
        }
    }
}

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        // Help and version are no errors, unless they cannot be printed.
        Err(text) => return code(text.exit_code(), text.print()),
    };
    arguments.output_unit.into_iter().for_each(table::set_output_unit);
    match arguments.command.run() {
        Ok(()) => code(0, table::written()),
        Err(failure) => failure.report(),
    }
}

/// An exit code, unless the output could not be written. A reader that has gone away is no error.
fn code(code: i32, output: io::Result<()>) -> ExitCode {
    match output {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            let reason = format!("the output cannot be written to stdout: {error}; free its disk");
            Failure::Failed(reason.into()).report()
        }
        _ => u8::try_from(code).map_or(ExitCode::FAILURE, ExitCode::from),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_of_the_dissertations_index_parses() {
        let page = include_str!("../../../docs/dissertation.md");
        let quoted = page.split('`').skip(1).step_by(2);
        let commands: Vec<&str> = quoted.filter(|c| c.starts_with("transect ")).collect();
        assert!(commands.len() > 10, "{commands:?}");
        for command in commands {
            let words = command.split_whitespace();
            if let Err(error) = Arguments::try_parse_from(words) {
                panic!("docs/dissertation.md: {command}: {error}");
            }
        }
    }
}
