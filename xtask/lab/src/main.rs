//! The measurements of Transect: `cargo xtask experiments`.
#![allow(clippy::print_stderr, reason = "progress and errors go there")]

mod chart;
mod experiments;
mod failure;
mod statistics;
mod table;
mod timing;

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
}

fn main() -> ExitCode {
    let Command::Experiments(arguments) = Arguments::parse().command;
    match experiments::run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
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
