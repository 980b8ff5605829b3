//! The surroundings of an experiment: its folder for tables and pictures, the public scans, and a
//! Python with other programs.

use super::python;
use crate::failure::Failure;
use crate::table::{grid, say};
use std::io::Write;
use std::path::{Path, PathBuf};
use transect_exchange::write_file;

/// Folder of the public scans, which are no part of the repository.
const DATA: &str = "../shared/data";

/// Folders and programs, the same for all experiments.
#[derive(Debug, Clone, clap::Args)]
pub struct Places {
    /// Folder for tables and pictures; each experiment has a folder in it.
    #[arg(long, global = true, value_name = "DIR", default_value = super::DEFAULT_FOLDER)]
    pub out: PathBuf,
    /// Folder with the public scans.
    #[arg(long, global = true, value_name = "DIR", default_value = DATA)]
    data: PathBuf,
    /// Python with the modules of the experiment's requirements.txt [default: the one in
    /// target/peers or target/foreign, else python3].
    #[arg(long, global = true, value_name = "PATH")]
    python: Option<PathBuf>,
}

/// The places of one experiment, and the command that runs it.
#[derive(Debug)]
pub struct Lab {
    places: Places,
    folder: PathBuf,
    command: String,
}

impl Lab {
    /// The files of an experiment. The command has no `cargo xtask` before it.
    pub fn new(places: &Places, experiment: &str, command: String) -> Self {
        Self { places: places.clone(), folder: places.out.join(experiment), command }
    }

    /// The experiment's folder, which exists.
    pub fn folder(&self) -> Result<&Path, Failure> {
        std::fs::create_dir_all(&self.folder).map_err(|e| Failure::with_file(&self.folder, e))?;
        Ok(&self.folder)
    }

    /// The folder of the public scans; skips the experiment without it.
    pub fn scans(&self) -> Result<&Path, Failure> {
        let data = &self.places.data;
        let missing = || Failure::Skipped(format!("{} is not there", data.display()));
        if data.is_dir() { Ok(data) } else { Err(missing()) }
    }

    /// A Python with other programs; skips the experiment without it. `environment` is the folder
    /// of `xtask` that has the requirements, and `hint` is added to the reason.
    pub fn python(&self, environment: &str, modules: &str, hint: &str) -> Result<PathBuf, Failure> {
        let python = python::find(environment, self.places.python.as_ref());
        match python::missing(&python, modules, environment, hint) {
            Some(reason) => Err(Failure::Skipped(reason)),
            None => Ok(python),
        }
    }

    /// The first Python that has modules; skips the experiment without one.
    pub fn any_python(&self, modules: &str) -> Result<PathBuf, Failure> {
        let named = std::env::var_os("TRANSECT_PYTHON").map(PathBuf::from);
        let usual = ["python3", "/usr/bin/python3"].map(PathBuf::from);
        let candidates = [python::find("peers", self.places.python.as_ref())].into_iter();
        let mut candidates = candidates.chain(named).chain(usual);
        let found = candidates.find(|python| python::import(python, modules).is_ok());
        let missing = || Failure::Skipped(format!("no Python has {modules}; set TRANSECT_PYTHON"));
        found.ok_or_else(missing)
    }

    /// Prints a table and writes it into `NAME.md`. The file has the same bytes in every run. The
    /// heads are separated by " | ".
    pub fn table(
        &self,
        name: &str,
        heads: &str,
        lines: impl IntoIterator<Item = Vec<String>>,
    ) -> Result<(), Failure> {
        let heads: Vec<&str> = heads.split(" | ").collect();
        let table = grid(&heads, &lines.into_iter().collect::<Vec<_>>());
        say(&format!("{table}\n"));
        self.write(name, &table)
    }

    /// Prints a table of times, memory or file sizes, and writes it into `times.md`.
    pub fn times(
        &self,
        heads: &str,
        lines: impl IntoIterator<Item = Vec<String>>,
    ) -> Result<(), Failure> {
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
        let file = self.folder()?.join(format!("{name}.md"));
        Ok(write_file(&file, |out| writeln!(out, "<!-- {} -->\n{table}", self.command))?)
    }
}
