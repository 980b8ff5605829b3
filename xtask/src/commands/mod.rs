//! One file per command, and what several of them share.

pub mod bench;
pub mod check;
pub mod compact;
pub mod evaluate;
pub mod experiments;
pub mod export;
pub mod gaps;
pub mod import;
pub mod inspect;
pub mod list_views;
pub mod manifest;
pub mod measure;
pub mod query;
pub mod reconstruct;
pub mod remove_view;
pub mod replace_view;
pub mod simulate;
pub mod test;
pub mod verify;

mod growing;
mod inspect_model;
mod model_file;
mod outputs;
mod planes;
mod report_file;

use crate::failure::Failure;
use std::path::{Path, PathBuf};
use std::process::Command;
use transect::{LoadedView, SourceError, ViewSource};
use transect_exchange::ScanView;

/// A view in a file, for the modeler.
pub struct FileView<'a>(pub &'a ScanView);

impl ViewSource for FileView<'_> {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn load(&self) -> Result<LoadedView, SourceError> {
        let (view, notes) = self.0.load()?;
        Ok(LoadedView { view, notes })
    }
}

/// The workspace's root folder.
pub fn workspace_root() -> PathBuf {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    here.parent().map_or(here.clone(), PathBuf::from)
}

/// Where results go unless told otherwise: a folder that git ignores.
pub fn default_out(name: &str) -> PathBuf {
    let safe = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    workspace_root().join("target/transect").join(name.chars().map(safe).collect::<String>())
}

/// Prints a command, runs it from the workspace's root, and fails if it fails.
pub fn run_command(command: &mut Command) -> Result<(), Failure> {
    let arguments: Vec<_> = command.get_args().map(|a| a.to_string_lossy().into_owned()).collect();
    // The program by its name alone: where it lies says nothing to a reader.
    let program = Path::new(command.get_program()).file_name().unwrap_or(command.get_program());
    let line = format!("{} {}", program.to_string_lossy(), arguments.join(" "));
    eprintln!("$ {line}");
    let status = command.current_dir(workspace_root()).status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Failure::because(format!("{line}: {status}"))),
        Err(error) => Err(Failure::because(format!("{line}: {error}"))),
    }
}

/// A cargo command, by the cargo that runs this.
pub fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}
