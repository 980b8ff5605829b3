//! `cargo xtask check`: everything that CI runs.

use super::{cargo, run_command, test, workspace_root};
use crate::failure::Failure;
use std::process::Command;

/// Options of `check`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Leave out the tests, for a caller that ran them already.
    #[arg(long)]
    without_tests: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    run_command(cargo().args(["fmt", "--all", "--check"]))?;
    let clippy = ["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"];
    run_command(cargo().args(clippy))?;
    let mut docs = cargo();
    docs.args(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings");
    run_command(&mut docs)?;
    deny()?;
    if !arguments.without_tests {
        test::run(&test::Arguments::default())?;
    }
    commands_of_the_readme()
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

/// The README's commands: the bundled room, and the real scans where they are.
fn commands_of_the_readme() -> Result<(), Failure> {
    let xtask = |line: &str| {
        let arguments: Vec<&str> = line.split_whitespace().collect();
        run_command(cargo().arg("xtask").args(arguments))
    };
    xtask("reconstruct --quiet")?;
    xtask("evaluate target/transect/room")?;
    xtask("simulate --out target/transect/simulated")?;
    xtask("inspect target/transect/simulated")?;
    xtask("experiments orders --doublings 1")?;
    xtask("experiments database utm")?;
    xtask("experiments database space")?;
    xtask("experiments sensors --scene thin_sheet")?;
    xtask("experiments pictures --out target/transect/pictures")?;
    let data = workspace_root().join("../shared/data");
    if !data.is_dir() {
        eprintln!("skipped: the real scans are not there ({})", data.display());
        return Ok(());
    }
    xtask(
        "reconstruct ../shared/data/stanford_bunny/bun.conf --normal 0,1,0 --interval 1mm \
         --out target/bunny --quiet",
    )?;
    xtask(
        "evaluate target/bunny --reference ../shared/data/stanford_bunny/reference/bun_zipper.ply \
         --from 0.06 --tolerance 0.5mm",
    )?;
    xtask(
        "manifest ../shared/data/rgbd_redkitchen --normal 0,-1,0 --interval 0.1m \
         --out target/kitchen/scan.json",
    )?;
    xtask("reconstruct target/kitchen/scan.json --out target/kitchen --quiet")?;
    xtask("evaluate target/kitchen")
}
