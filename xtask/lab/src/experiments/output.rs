//! The files of an experiment: its tables and pictures, in a folder of its own.

use crate::failure::Failure;
use crate::table::{grid, say};
use std::io::Write;
use std::path::{Path, PathBuf};
use transect_exchange::write_file;

/// Where an experiment writes, and the command that runs it.
#[derive(Debug, Clone)]
pub struct Output {
    folder: PathBuf,
    command: String,
}

impl Output {
    /// Tables are printed, and no file is written: an input of the experiment is missing.
    pub fn printed() -> Self {
        Self { folder: PathBuf::new(), command: String::new() }
    }

    /// The files of an experiment below a folder. The command has no `cargo xtask` before it.
    pub fn new(parent: &Path, experiment: &str, command: String) -> Self {
        Self { folder: parent.join(experiment), command }
    }

    /// The experiment's folder, which exists.
    pub fn folder(&self) -> Result<&Path, Failure> {
        std::fs::create_dir_all(&self.folder).map_err(|e| Failure::with_file(&self.folder, e))?;
        Ok(&self.folder)
    }

    /// Prints a table and writes it into `NAME.md`. The file has the same bytes in every run.
    pub fn table(&self, name: &str, heads: &[&str], lines: &[Vec<String>]) -> Result<(), Failure> {
        let table = grid(heads, lines);
        say(&table);
        self.write(name, &table)
    }

    /// Prints a table of times, memory or file sizes, and writes it into `times.md`.
    pub fn times(&self, heads: &[&str], lines: &[Vec<String>]) -> Result<(), Failure> {
        self.table("times", heads, lines)
    }

    /// Writes a picture into `NAME.svg`.
    pub fn picture(
        &self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<(), Failure> {
        Ok(write_file(&self.folder()?.join(format!("{name}.svg")), write)?)
    }

    /// Writes a table below the command that made it.
    pub fn write(&self, name: &str, table: &str) -> Result<(), Failure> {
        if self.command.is_empty() {
            return Ok(());
        }
        let file = self.folder()?.join(format!("{name}.md"));
        write_file(&file, |out| writeln!(out, "<!-- {} -->\n{table}", self.command))?;
        Ok(())
    }
}
