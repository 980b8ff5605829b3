//! Outputs on disk: which files may be replaced, and how a group of files is replaced together.
//!
//! 1. Before any work, [`claim_output`] refuses an output that is an input or a model store.
//! 2. [`Staging`] keeps the new files in a folder inside the target until all are complete. A full
//!    disk or a killed process therefore leaves the old files.
//! 3. [`Staging::commit`] then renames file by file, which needs no space and takes milliseconds.

use crate::WorkflowError;
use serde_json::Value;
use std::fs::{self, File, TryLockError};
use std::io::Read;
use std::path::{Path, PathBuf};
use transect_exchange::MANIFEST_FILE;
use transect_model::SCHEMA_VERSION;
use transect_model::store::LINES_START;

/// The folder inside the target that holds files until all of them are complete.
const STAGE: &str = ".transect.part";

/// The file in that folder that a running process keeps locked.
const LOCK: &str = ".lock";

/// The advice for an output that would replace a file that must stay.
const ELSEWHERE: &str = "choose another place for the output";

/// Prepares a file for being replaced: refuses files that must stay, and removes the temporary
/// files that killed processes left beside it.
///
/// # Errors
/// [`WorkflowError::File`] if the output is a folder, one of the inputs, or a model store.
pub(crate) fn claim_output(output: &Path, inputs: &[PathBuf]) -> Result<(), WorkflowError> {
    check_output(output, inputs)?;
    remove_leftovers(output);
    Ok(())
}

/// Refuses an output that is a folder, one of the inputs, or a model store.
pub(crate) fn check_output(output: &Path, inputs: &[PathBuf]) -> Result<(), WorkflowError> {
    let refuse = |problem: String| Err(WorkflowError::file(output, problem));
    if output.is_dir() {
        return refuse("is a folder, and the output needs a file of that name; rename it".into());
    }
    if let Some(input) = inputs.iter().find(|input| same_file(output, input)) {
        let input = input.display();
        return refuse(format!("the output would replace the input {input}; {ELSEWHERE}"));
    }
    if is_store(output) {
        return refuse(format!(
            "the output would replace a model store, or a model of another version; {ELSEWHERE}"
        ));
    }
    Ok(())
}

/// Prepares a file for the manifest of a folder of depth images. Without `force`, a file that is
/// there must be the manifest that the command `manifest` wrote for the same folder.
///
/// # Errors
/// [`WorkflowError::File`] if it is of other origin, a folder, one of the inputs, or a store.
pub fn claim_manifest(
    output: &Path,
    images: &Path,
    force: bool,
    inputs: &[PathBuf],
) -> Result<(), WorkflowError> {
    claim_output(output, inputs)?;
    let first_image = |found: &Value| found["views"][0]["file"].as_str().map(PathBuf::from);
    let of_folder = |found: &Value| {
        let image = first_image(found);
        image.is_some_and(|image| image.ancestors().any(|folder| same_file(folder, images)))
    };
    match origin_of_other(output, "manifest", of_folder) {
        Some(origin) if !force => {
            let problem = format!(
                "the file exists, and {origin}; manifest replaces its own file of the same folder \
                 only. Choose another --out, or replace it with --force"
            );
            Err(WorkflowError::file(output, problem))
        }
        _ => Ok(()),
    }
}

/// Prepares a folder for the `scan.json` of `register`. A file that is there must be the one that
/// `register` wrote for the same scan, by the report beside it.
///
/// # Errors
/// [`WorkflowError::File`] if it is of other origin, a folder, one of the inputs, or a store.
pub(crate) fn claim_registered(
    output: &Path,
    report: &Path,
    scan: &Path,
    inputs: &[PathBuf],
) -> Result<(), WorkflowError> {
    claim_output(output, inputs)?;
    let of_scan = |_: &Value| {
        let registered = json(report)["registered"].as_str().map(PathBuf::from);
        registered.is_some_and(|registered| same_scan(&registered, scan))
    };
    match origin_of_other(output, "register", of_scan) {
        Some(origin) => {
            let problem = format!(
                "the file exists, and {origin}; register replaces its own file of the same scan \
                 only. Choose another --out, or remove the file"
            );
            Err(WorkflowError::file(output, problem))
        }
        None => Ok(()),
    }
}

/// Where a manifest comes from, in words, if a command may not replace it; `None` if it may.
///
/// `is_same` tells whether a manifest that the command wrote is about the same scan.
fn origin_of_other(
    output: &Path,
    command: &str,
    is_same: impl Fn(&Value) -> bool,
) -> Option<String> {
    if !output.exists() {
        return None;
    }
    let found = json(output);
    match command_of(&found) {
        None | Some("") => {
            Some("its key \"tool\" does not name this program and its command".to_owned())
        }
        Some(own) if own == command => {
            (!is_same(&found)).then(|| format!("{command} wrote it for another scan"))
        }
        Some(other) => Some(format!("transect {other} wrote it")),
    }
}

/// Prepares a file for the lines of a store. A file that is there must hold such lines: it might be
/// an image or a manifest that the store's views came from.
///
/// # Errors
/// [`WorkflowError::File`] if it is of other origin, a folder, one of the inputs, or a store.
pub fn claim_lines(output: &Path, inputs: &[PathBuf]) -> Result<(), WorkflowError> {
    claim_output(output, inputs)?;
    if !output.exists() || starts_with(output, LINES_START) {
        return Ok(());
    }
    let problem = format!("the file exists, and export --lines did not write it; {ELSEWHERE}");
    Err(WorkflowError::file(output, problem))
}

fn starts_with(path: &Path, start: &[u8]) -> bool {
    let mut found = vec![0; start.len()];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut found));
    read.is_ok() && found == start
}

/// Whether a manifest states that the command `simulate` wrote it. Manifests of earlier builds name
/// the program without a command.
pub(crate) fn is_simulated_manifest(path: &Path) -> bool {
    matches!(command_of(&json(path)), Some("simulate" | ""))
}

/// The command that wrote a manifest, empty if only the program is named; `None` if its key `tool`
/// does not name this program.
fn command_of(manifest: &Value) -> Option<&str> {
    let version = manifest["tool"].as_str()?.strip_prefix("transect ")?;
    Some(version.split_once(' ').map_or("", |(_, command)| command))
}

/// The content of a JSON file; null if it cannot be read.
fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap_or_default()).unwrap_or_default()
}

/// Whether two paths lead to one scan. A folder stands for the manifest in it.
fn same_scan(a: &Path, b: &Path) -> bool {
    let file = |path: &Path| match path.is_dir() {
        true => path.join(MANIFEST_FILE),
        false => path.to_owned(),
    };
    same_file(a, b) || same_file(&file(a), &file(b))
}

/// Whether two paths lead to one file, through links or not. Neither file has to exist.
fn same_file(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    if let (Ok(a), Ok(b)) = (fs::metadata(a), fs::metadata(b)) {
        use std::os::unix::fs::MetadataExt;
        return (a.dev(), a.ino()) == (b.dev(), b.ino());
    }
    resolved(a) == resolved(b)
}

/// The path without links; for a file that does not exist, that of its folder with its name.
fn resolved(path: &Path) -> PathBuf {
    let absolute = || std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    path.canonicalize().unwrap_or_else(|_| match (absolute().parent(), path.file_name()) {
        (Some(folder), Some(name)) => resolved(folder).join(name),
        _ => absolute(),
    })
}

/// Whether a file starts like a model store of any version, like the database inside it, or like a
/// model of another version.
fn is_store(path: &Path) -> bool {
    let mut start = [0; 12];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut start));
    let [magic @ .., a, b, c, d] = start;
    let is_other_model = magic == *b"TRANSECT" && [a, b, c, d] != SCHEMA_VERSION.to_le_bytes();
    read.is_ok() && (is_other_model || start.starts_with(b"redb"))
}

/// Removes `.NAME.PROCESS.part` and `NAME.PROCESS-N.part` beside a file, if the process has ended.
pub(crate) fn remove_leftovers(output: &Path) {
    let folder = output.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (Ok(entries), Some(name)) = (fs::read_dir(folder), output.file_name()) else { return };
    let name = name.to_string_lossy();
    for entry in entries.flatten() {
        let found = entry.file_name().to_string_lossy().into_owned();
        let rest = found.strip_prefix('.').unwrap_or(&found).strip_prefix(&*name);
        let process = rest.and_then(|r| r.strip_prefix('.')?.strip_suffix(".part"));
        let process = process.and_then(|p| p.split('-').next()?.parse().ok());
        if process.is_some_and(|process| !is_running(process)) {
            // A file that cannot be removed is left; the next run tries again.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Whether a process runs. Systems without `/proc` do not tell, so the answer is yes there.
fn is_running(process: u32) -> bool {
    !Path::new("/proc/self").exists() || Path::new("/proc").join(process.to_string()).exists()
}

/// New files of a folder, which appear there together.
#[derive(Debug)]
pub(crate) struct Staging {
    target: PathBuf,
    stage: PathBuf,
    /// Whether the target did not exist before.
    is_new: bool,
    /// Locked as long as this process runs; the next run removes what a killed process left.
    _lock: File,
}

impl Staging {
    /// An empty stage for the files of a folder.
    ///
    /// # Errors
    /// [`WorkflowError`] if the folder cannot be written, or another process writes into it.
    pub fn begin(target: &Path) -> Result<Self, WorkflowError> {
        let (is_new, stage) = (!target.exists(), target.join(STAGE));
        fs::create_dir_all(&stage).map_err(WorkflowError::io("make the folder", &stage))?;
        let lock = stage.join(LOCK);
        let lock = File::create(&lock).map_err(WorkflowError::io("make the file", &lock))?;
        if matches!(lock.try_lock(), Err(TryLockError::WouldBlock)) {
            let problem = "another process is writing into this folder; wait until it has ended, \
                           or choose another folder";
            return Err(WorkflowError::file(target, problem));
        }
        let staging = Self { target: target.to_owned(), stage, is_new, _lock: lock };
        for file in staging.files()? {
            let left = staging.stage.join(file);
            fs::remove_file(&left).map_err(WorkflowError::io("remove the old file", &left))?;
        }
        Ok(staging)
    }

    /// The folder to write into.
    pub fn path(&self) -> &Path {
        &self.stage
    }

    /// Moves all files into the target; returns their paths in it.
    ///
    /// # Errors
    /// [`WorkflowError`] naming the file that cannot be moved.
    pub fn commit(mut self) -> Result<Vec<PathBuf>, WorkflowError> {
        let files: Vec<_> = self.files()?.into_iter().map(|f| (self.target.join(&f), f)).collect();
        // Everything that can be found out before the first move is found out before it.
        for (target, _) in &files {
            check_output(target, &[])?;
            let folder = target.parent().unwrap_or(&self.target);
            fs::create_dir_all(folder).map_err(WorkflowError::io("make the folder", folder))?;
        }
        for (target, file) in &files {
            fs::rename(self.stage.join(file), target)
                .map_err(WorkflowError::io("put the new file in place", target))?;
        }
        self.is_new = false;
        Ok(files.into_iter().map(|(target, _)| target).collect())
    }

    /// The files of the stage and of the folders in it, sorted, without the lock.
    fn files(&self) -> Result<Vec<PathBuf>, WorkflowError> {
        let (mut files, mut folders) = (Vec::new(), vec![self.stage.clone()]);
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(&folder)
                .map_err(WorkflowError::io("list the folder", &folder))?
                .flatten()
            {
                let path = entry.path();
                match path.strip_prefix(&self.stage) {
                    _ if path.is_dir() => folders.push(path),
                    Ok(file) if file != Path::new(LOCK) => files.push(file.to_owned()),
                    _ => (),
                }
            }
        }
        files.sort();
        Ok(files)
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        // An error was reported already, or all files are in their places.
        let _ = fs::remove_dir_all(&self.stage);
        if self.is_new {
            let _ = fs::remove_dir(&self.target);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_appear_together_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("out");
        let write = |names: &[&str], text: &str| {
            let staging = Staging::begin(&target).unwrap();
            for name in names {
                let path = staging.path().join(name);
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                fs::write(path, text).unwrap();
            }
            staging
        };
        drop(write(&["a"], "given up"));
        assert!(!target.exists(), "the folder is as it was: absent");
        let moved = write(&["a", "planes/b"], "old").commit().unwrap();
        assert_eq!(moved, [target.join("a"), target.join("planes/b")]);
        fs::create_dir(target.join("c")).unwrap();
        let error = write(&["a", "c"], "new").commit().unwrap_err().to_string();
        assert!(error.contains("is a folder"), "{error}");
        assert_eq!(fs::read(target.join("a")).unwrap(), b"old");
        assert!(!target.join(STAGE).exists());
    }

    #[test]
    fn the_next_run_removes_what_a_killed_one_left_and_no_living_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir_all(path(STAGE)).unwrap();
        fs::write(path(STAGE).join("half"), "half").unwrap();
        let living = Staging::begin(folder.path()).unwrap();
        assert!(!living.path().join("half").exists());
        let refused = Staging::begin(folder.path()).unwrap_err().to_string();
        assert!(refused.contains("another process"), "{refused}");
        assert!(living.path().exists());
        let own = std::process::id();
        // No system numbers its processes that high.
        for name in [".m.dxf.4294967295.part", "m.dxf.4294967295-3.part", ".notes.4294967295.part"]
        {
            fs::write(path(name), "").unwrap();
        }
        fs::write(path(&format!(".m.dxf.{own}.part")), "").unwrap();
        claim_output(&path("m.dxf"), &[]).unwrap();
        let mut left: Vec<_> = fs::read_dir(folder.path()).unwrap().flatten().collect();
        left.sort_by_key(fs::DirEntry::file_name);
        let left: Vec<_> = left.iter().map(fs::DirEntry::file_name).collect();
        let own = format!(".m.dxf.{own}.part");
        assert_eq!(left, [&own, ".notes.4294967295.part", STAGE]);
    }

    #[test]
    fn links_to_one_file_are_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let [file, hard, absent] = ["file", "hard", "absent"].map(|n| folder.path().join(n));
        fs::write(&file, "").unwrap();
        fs::hard_link(&file, &hard).unwrap();
        assert!(same_file(&file, &hard) && same_file(&file, &folder.path().join("./file")));
        assert!(same_file(&absent, &folder.path().join("./absent")));
        assert!(!same_file(&file, &absent));
    }
}
