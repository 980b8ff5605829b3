//! `cargo xtask check`: format, structure, lints, documentation, dependencies, tests, and commands.
//!
//! `.ci/run` runs it with the further stages of CI: fuzzed files, the installed program, files of
//! other programs, examples and packages.
//!
//! A check of the workspace's own files is a module of this folder with a function
//! `run(root: &Path) -> Result<(), Failure>`, and one line in [`STRUCTURE`].

mod dependencies;
mod finding;
mod imports;
mod index;
mod prose;

use crate::run::{Failure, cargo, run_command, workspace_root};
use crate::test;
use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

/// A check of files in the workspace: it takes the root folder and names what is wrong, and where.
type StructureCheck = fn(&Path) -> Result<(), Failure>;

/// The checks of the workspace's own files, by name, in the order in which they run.
const STRUCTURE: [(&str, StructureCheck); 4] = [
    ("prose", prose::run),
    ("imports", imports::run),
    ("dependencies", dependencies::run),
    ("index", index::run),
];

/// Runs the stages of the check; `--without-tests` leaves out the tests, for a caller that ran
/// them.
pub fn run(arguments: &[OsString]) -> Result<(), Failure> {
    let without_tests = match arguments {
        [] => false,
        [option] if option == "--without-tests" => true,
        _ => {
            let reason =
                format!("check takes no argument but --without-tests; found {arguments:?}");
            return Err(Failure::usage(reason));
        }
    };
    run_command(cargo().args(["fmt", "--all", "--check"]))?;
    check_structure()?;
    let clippy = ["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"];
    run_command(cargo().args(clippy))?;
    let mut docs = cargo();
    docs.args(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings");
    run_command(&mut docs)?;
    deny()?;
    if !without_tests {
        test::run(&[])?;
    }
    run_commands()
}

/// Runs every check of the workspace's own files, so that one run names everything to mend.
fn check_structure() -> Result<(), Failure> {
    let root = workspace_root();
    let results = STRUCTURE.map(|(name, check)| {
        eprintln!("$ check {name}");
        check(&root)
    });
    results.into_iter().collect()
}

/// Licences, sources and bans of the dependencies, where cargo-deny is installed.
///
/// Advisories are left out: their database is fetched from outside the package registries.
fn deny() -> Result<(), Failure> {
    let installed = Command::new("cargo-deny").arg("--version").output().is_ok();
    if !installed {
        eprintln!("skipped: cargo-deny is not installed (cargo install cargo-deny)");
        return Ok(());
    }
    run_command(cargo().args(["deny", "check", "licenses", "bans", "sources"]))
}

/// Commands that must succeed on bundled scenes: those of the README, and short experiments.
const COMMANDS_ON_SCENES: [&str; 8] = [
    "reconstruct --quiet",
    "evaluate transect-out/room",
    "simulate --out transect-out/simulated",
    "inspect transect-out/simulated",
    "experiments orders --doublings 1",
    "experiments database space",
    "experiments sensors --scene thin_sheet",
    "experiments pictures",
];

/// Commands that must succeed on real scans.
const COMMANDS_ON_SCANS: [&str; 5] = [
    "reconstruct ../shared/data/stanford_bunny/bun.conf --normal 0,1,0 --interval 1mm \
     --out target/bunny --quiet",
    "evaluate target/bunny --reference ../shared/data/stanford_bunny/reference/bun_zipper.ply \
     --from 0.06 --tolerance 0.5mm",
    "manifest ../shared/data/rgbd_redkitchen --normal 0,-1,0 --interval 0.1m \
     --out target/kitchen/scan.json",
    "reconstruct target/kitchen/scan.json --out target/kitchen --quiet",
    "evaluate target/kitchen",
];

/// Runs the commands that must succeed; those on real scans where the scans are.
fn run_commands() -> Result<(), Failure> {
    let xtask = |line: &&str| run_command(cargo().arg("xtask").args(line.split_whitespace()));
    COMMANDS_ON_SCENES.iter().try_for_each(xtask)?;
    let data = workspace_root().join("../shared/data");
    if data.is_dir() {
        return COMMANDS_ON_SCANS.iter().try_for_each(xtask);
    }
    eprintln!("skipped: the real scans are not there ({})", data.display());
    Ok(())
}
