//! Findings of the structure checks, and the list of files they read.

use crate::run::Failure;
use std::fmt;
use std::path::Path;

/// A place that breaks a rule, with what to do about it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Finding {
    /// The file, relative to the workspace's root, with forward slashes.
    pub file: String,
    /// The line, counted from 1.
    pub line: usize,
    /// The problem, the finding and the remedy.
    pub message: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.file, self.line, self.message)
    }
}

/// A text file of the workspace.
#[derive(Clone, Debug)]
pub struct TextFile {
    /// The file, relative to the workspace's root, with forward slashes.
    pub name: String,
    /// Its contents.
    pub text: String,
}

impl TextFile {
    /// The finding at a line of this file.
    pub fn finding(&self, line: usize, message: String) -> Finding {
        Finding { file: self.name.clone(), line, message }
    }
}

/// Reads all files below a folder of the workspace whose names end in one of the endings.
/// Leaves out build results, model results, hidden folders and links.
pub fn files(root: &Path, folder: &str, endings: &[&str]) -> Result<Vec<TextFile>, Failure> {
    let folder = root.join(folder);
    let unreadable = |e| Failure::because(format!("{}: {e}", folder.display()));
    let mut found = Vec::new();
    for entry in std::fs::read_dir(&folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let relative = path.strip_prefix(root).unwrap_or(&path);
        let name = relative.to_string_lossy().replace('\\', "/");
        if path.is_symlink() {
            continue;
        }
        if path.is_dir() {
            let folder = relative.file_name().unwrap_or_default().to_string_lossy();
            if !folder.starts_with('.') && folder != "target" && folder != "transect-out" {
                found.extend(files(root, &name, endings)?);
            }
        } else if endings.iter().any(|ending| name.ends_with(ending)) {
            found.push(read(root, &name)?);
        }
    }
    found.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(found)
}

/// Reads one file, given relative to the workspace's root.
pub fn read(root: &Path, name: &str) -> Result<TextFile, Failure> {
    let text = std::fs::read_to_string(root.join(name));
    let text = text.map_err(|e| Failure::because(format!("{name}: {e}")))?;
    Ok(TextFile { name: name.to_owned(), text })
}

/// Prints the findings of a check; any of them is a failure.
pub fn report(findings: Vec<Finding>) -> Result<(), Failure> {
    for finding in &findings {
        eprintln!("{finding}");
    }
    match findings.len() {
        0 => Ok(()),
        count => Err(Failure::because(format!("{count} places to mend, listed above"))),
    }
}
