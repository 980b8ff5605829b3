//! The measurements of Transect: `cargo xtask bench` and `cargo xtask experiments`.
#![allow(clippy::print_stderr, reason = "progress and errors go there")]

mod bench;
mod experiments;
mod failure;
mod statistics;
mod table;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version, next_line_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Measure what the documentation states, such as every sensor's accuracy.
    Experiments(experiments::Arguments),
    /// Measure the speed of a stage, beside what it is compared with.
    Bench(bench::Arguments),
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Experiments(a) => experiments::run(&a),
        Command::Bench(a) => bench::run(&a),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_of_the_documentation_parses() {
        let commands = experiments::pages::Page::commands_of_the_lab();
        assert!(commands.len() > 30, "{commands:?}");
        for (page, command) in commands {
            let words = std::iter::once("xtask").chain(command.split_whitespace());
            if let Err(error) = Arguments::try_parse_from(words) {
                panic!("{}: {command}: {error}", page.display());
            }
        }
    }
}
