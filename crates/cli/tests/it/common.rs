//! Running the command line in a folder of its own, and reading what it prints.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use transect_geometry::LengthUnit;

/// A temporary folder in which commands run; paths are relative to it.
pub struct Folder(tempfile::TempDir);

/// What a command left.
#[derive(Debug)]
pub struct Run {
    /// What was run, for messages.
    pub line: String,
    /// The exit code; `None` if a signal ended the command.
    pub code: Option<i32>,
    /// What went to stdout: results.
    pub stdout: String,
    /// What went to stderr: progress, notes, warnings and errors.
    pub stderr: String,
}

/// A line of a result table.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// What was measured.
    pub metric: String,
    /// Its value as text.
    pub value: String,
    /// Its unit, perhaps with a remark; empty for counts.
    pub unit: String,
}

impl Folder {
    /// An empty folder.
    pub fn empty() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// A folder with the simulated scan `scan` of a scene among the fixtures.
    pub fn simulated(scene: &str) -> Self {
        let folder = Self::empty();
        folder.run(&format!("simulate {} --out scan", fixture(scene).display())).succeeded();
        folder
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// The bytes of a file.
    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The text of a file.
    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).unwrap()
    }

    /// The content of a JSON file.
    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Changes a JSON file and writes it under another name.
    pub fn edit_json(&self, from: &str, to: &str, edit: impl FnOnce(&mut Value)) {
        let mut value = self.json(from);
        edit(&mut value);
        self.write(to, serde_json::to_vec(&value).unwrap());
    }

    /// Runs the command line with arguments that hold no white space.
    pub fn run(&self, line: &str) -> Run {
        self.run_with(&[], line)
    }

    /// Runs the command line as [`Folder::run`] does, with these environment variables.
    pub fn run_with(&self, variables: &[(&str, &str)], line: &str) -> Run {
        let mut command = Command::new(env!("CARGO_BIN_EXE_transect"));
        command.envs(variables.iter().copied());
        let output =
            command.args(line.split_whitespace()).current_dir(self.0.path()).output().unwrap();
        Run {
            line: line.to_owned(),
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Reconstructs a scan into `out` without progress.
    pub fn reconstruct(&self, scan_and_options: &str) -> Run {
        self.run(&format!("reconstruct {scan_and_options} --out out --quiet"))
    }
}

/// A file among the workspace's fixtures.
pub fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(name)
}

impl Run {
    /// The run itself, which must have ended well.
    pub fn succeeded(self) -> Self {
        assert_eq!(self.code, Some(0), "{}: {}", self.line, self.stderr);
        self
    }

    /// Asserts an exit code, and that stderr has every one of some texts.
    pub fn failed_with(&self, code: i32, texts: &[&str]) {
        assert_eq!(self.code, Some(code), "{}: {}", self.line, self.stderr);
        for text in texts {
            assert!(self.stderr.contains(text), "{}: no {text:?} in: {}", self.line, self.stderr);
        }
        assert!(!self.stderr.contains("panicked"), "{}: {}", self.line, self.stderr);
    }

    /// The lines of stderr that begin with a word.
    pub fn told(&self, word: &str) -> Vec<&str> {
        self.stderr.lines().filter(|l| l.starts_with(word)).collect()
    }

    /// The rows of the table on stdout, which must have its head.
    pub fn table(&self) -> Vec<Row> {
        let mut lines = self.stdout.lines();
        let head: Vec<&str> = lines.next().unwrap_or_default().split_whitespace().collect();
        assert_eq!(head, ["metric", "value", "unit"], "{}: {}", self.line, self.stdout);
        lines.take_while(|l| !l.is_empty()).map(row).collect()
    }

    /// The value of a metric as it is printed.
    pub fn value(&self, metric: &str) -> String {
        let row = self.table().into_iter().find(|r| r.metric == metric);
        row.unwrap_or_else(|| panic!("no {metric:?} in: {}", self.stdout)).value
    }

    /// The value of a metric as a number; lengths, areas and volumes in metres.
    pub fn number(&self, metric: &str) -> f64 {
        let row = self.table().into_iter().find(|r| r.metric == metric);
        let row = row.unwrap_or_else(|| panic!("no {metric:?} in: {}", self.stdout));
        let unit = row.unit.trim_end_matches(['²', '³']);
        let power =
            if row.unit.ends_with('²') { 2 } else { 1 + 2 * i32::from(row.unit.ends_with('³')) };
        let metres = unit.parse::<LengthUnit>().map_or(1.0, |unit| unit.in_metres().powi(power));
        metres * row.value.parse::<f64>().unwrap_or_else(|e| panic!("{metric}: {e}"))
    }
}

/// A row of a table, whose columns are two or more blanks apart.
fn row(line: &str) -> Row {
    let mut cells = line.split("  ").map(str::trim).filter(|c| !c.is_empty()).map(str::to_owned);
    let mut next = || cells.next().unwrap_or_default();
    Row { metric: next(), value: next(), unit: next() }
}

/// Turns the rotation of a manifest's view into its inverse.
pub fn conjugate(manifest: &mut Value, view: usize) {
    let pose = manifest["views"][view]["pose"].as_array_mut().unwrap();
    for (row, col) in [(0, 1), (0, 2), (1, 2)] {
        pose.swap(4 * row + col, 4 * col + row);
    }
}
