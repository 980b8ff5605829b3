//! The launcher's own answers, and its passing on of commands, output and exit codes.
#![allow(clippy::unwrap_used, reason = "tests fail loudly")]

use std::path::Path;
use std::process::{Command, Output};

fn xtask(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
    // The launcher has cargo run the package. This stand-in shows its arguments instead of
    // building.
    let stand_in = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cargo.sh");
    command.args(arguments).env("CARGO", stand_in).output().unwrap()
}

#[test]
#[cfg(unix)]
fn commands_go_to_their_package_and_come_back_as_they_are() {
    for (command, package) in [
        ("reconstruct", "transect-cli"),
        ("unheard-of", "transect-cli"),
        ("experiments", "xtask-lab"),
    ] {
        let output = xtask(&[command, "--out", "a folder", "--help"]);
        let stdout = String::from_utf8(output.stdout).unwrap();
        let passed = format!("--package\n{package}\n--\n{command}\n--out\na folder\n--help\n");
        assert!(stdout.starts_with("run\n--quiet\n--release\n"), "{stdout}");
        assert!(stdout.ends_with(&passed), "{stdout}");
        assert_eq!(String::from_utf8(output.stderr).unwrap(), "on stderr\n");
        assert_eq!(output.status.code(), Some(7));
    }
}

#[test]
#[cfg(unix)]
fn the_sweep_has_a_second_name() {
    let stdout = String::from_utf8(xtask(&["bench", "partial", "--size", "64"]).stdout).unwrap();
    assert!(stdout.ends_with("--\nexperiments\nspeed\n--size\n64\n"), "{stdout}");
}

#[test]
fn the_launcher_answers_for_itself() {
    let help = xtask(&["--help"]);
    let text = String::from_utf8(help.stdout).unwrap();
    assert_eq!(help.status.code(), Some(0));
    for command in ["test", "check", "bench", "experiments", "reconstruct", "manifest"] {
        assert!(text.contains(&format!("\n  {command} ")), "{text}");
    }
    assert_eq!(xtask(&[]).status.code(), Some(2));
    let check = xtask(&["check", "--tests"]);
    assert_eq!(check.status.code(), Some(2));
    assert!(String::from_utf8(check.stderr).unwrap().contains("--without-tests"));
}
