//! The launcher behind `cargo xtask <command>`.
//!
//! It runs the tests and the checks itself. Every other command belongs to another package, which
//! the launcher has cargo build and run: `transect-cli` for users, `xtask-lab` for measurements.
//! The launcher depends on nothing, so that `cargo xtask test` starts at once in a clean clone.
#![allow(clippy::print_stderr, clippy::print_stdout, reason = "a program talks to its terminal")]

mod check;
mod commands;
mod run;
mod test;

use commands::Owner;
use run::Failure;
use std::ffi::OsString;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
    match start(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure { reason, code }) => {
            if let Some(reason) = reason {
                eprintln!("error: {reason}");
            }
            code
        }
    }
}

fn start(arguments: &[OsString]) -> Result<(), Failure> {
    let Some((name, rest)) = arguments.split_first() else {
        eprintln!("{}", commands::help());
        return Err(Failure { reason: None, code: ExitCode::from(2) });
    };
    let name = name.to_string_lossy();
    let owner = commands::owner(&name);
    let asks_for_help = matches!(name.as_ref(), "help" | "--help" | "-h") && rest.is_empty()
        || owner == Owner::Launcher && rest.iter().any(|option| option == "--help");
    if asks_for_help {
        println!("{}", commands::help());
        return Ok(());
    }
    match (name.as_ref(), owner) {
        ("test", _) => test::run(rest),
        ("check", _) => check::run(rest),
        ("bench", _) if rest.first().is_some_and(|stage| stage == "partial") => {
            let words = ["experiments", "speed"].map(OsString::from);
            let options = rest.iter().skip(1).cloned();
            run::forward("xtask-lab", &words.into_iter().chain(options).collect::<Vec<_>>())
        }
        (_, Owner::Lab) => run::forward("xtask-lab", arguments),
        _ => run::forward("transect-cli", arguments),
    }
}
