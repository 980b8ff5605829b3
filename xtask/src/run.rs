//! Running cargo and other programs.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Why the launcher ends with an exit code other than 0.
#[derive(Debug)]
pub struct Failure {
    /// One line for stderr; `None` if the program that was run has said it.
    pub reason: Option<String>,
    /// The exit code.
    pub code: ExitCode,
}

impl Failure {
    /// A failure with exit code 1.
    pub fn because(reason: impl Into<String>) -> Self {
        Self { reason: Some(reason.into()), code: ExitCode::FAILURE }
    }

    /// Bad arguments: exit code 2.
    pub fn usage(reason: impl Into<String>) -> Self {
        Self { reason: Some(reason.into()), code: ExitCode::from(2) }
    }
}

/// The workspace's root folder.
pub fn workspace_root() -> PathBuf {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    here.parent().map_or(here.clone(), PathBuf::from)
}

/// A cargo command, by the cargo that runs this.
pub fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// Prints a command, runs it from the workspace's root, and fails if it fails.
pub fn run_command(command: &mut Command) -> Result<(), Failure> {
    let arguments: Vec<_> = command.get_args().map(|a| a.to_string_lossy().into_owned()).collect();
    // The program's name without its folder, which differs between machines.
    let program = Path::new(command.get_program()).file_name().unwrap_or(command.get_program());
    let line = format!("{} {}", program.to_string_lossy(), arguments.join(" "));
    eprintln!("$ {line}");
    match command.current_dir(workspace_root()).status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Failure::because(format!("{line}: {status}"))),
        Err(error) => Err(Failure::because(format!("{line}: {error}"))),
    }
}

/// Builds a package in release and runs its program in the current folder. Output and exit code
/// are the program's own.
pub fn forward(package: &str, arguments: &[OsString]) -> Result<(), Failure> {
    let manifest = workspace_root().join("Cargo.toml");
    let mut command = cargo();
    command.args(["run", "--quiet", "--release", "--manifest-path"]).arg(manifest);
    command.args(["--package", package, "--"]).args(arguments);
    let status = command.status().map_err(|e| Failure::because(format!("cargo run: {e}")))?;
    match status.code() {
        Some(0) => Ok(()),
        // Codes above 255 exist on Windows alone.
        Some(code) => {
            let code = u8::try_from(code).map_or(ExitCode::FAILURE, ExitCode::from);
            Err(Failure { reason: None, code })
        }
        None => Err(Failure::because(format!("{package}: {status}"))),
    }
}
