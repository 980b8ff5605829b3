//! Other programs in Python: which Python has them, and running a script with it.

use crate::failure::Failure;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The Python that is given, else the one of an environment below `target`, else `python3`.
pub fn find(environment: &str, given: Option<&PathBuf>) -> PathBuf {
    let made = script("../target").join(environment).join("bin/python");
    let usual = if made.is_file() { made } else { "python3".into() };
    given.cloned().unwrap_or(usual)
}

/// A file below the folder `xtask`.
pub fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name)
}

/// Whether a Python can import modules; otherwise the last line of its error.
pub fn import(python: &Path, modules: &str) -> Result<(), String> {
    let output = Command::new(python).args(["-c", &format!("import {modules}")]).output();
    let output = output.map_err(|error| error.to_string())?;
    let error = String::from_utf8_lossy(&output.stderr);
    let last = error.lines().last().unwrap_or("the import failed");
    if output.status.success() { Ok(()) } else { Err(last.to_owned()) }
}

/// Why a Python lacks modules, and how to make one that has them; `None` if it has them.
pub fn missing(python: &Path, modules: &str, environment: &str, hint: &str) -> Option<String> {
    let reason = import(python, modules).err()?;
    Some(format!(
        "{}: {reason}. Make a Python with the other programs{hint}, and repeat:\n  \
         python3 -m venv target/{environment}\n  \
         target/{environment}/bin/pip install -r xtask/{environment}/requirements.txt",
        python.display()
    ))
}

/// Runs a script of the folder `xtask`, and returns what it prints.
pub fn run(python: &Path, name: &str, arguments: &[&str]) -> Result<String, Failure> {
    // Without files of byte code beside the scripts.
    let mut command = Command::new(python);
    command.arg("-B").arg(script(name)).args(arguments).stderr(Stdio::inherit());
    let output = command.output().map_err(|error| Failure::with_file(python, error))?;
    if !output.status.success() {
        return Err(Failure::because(format!("xtask/{name}: {}", output.status)));
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim_end().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_python_without_the_programs_is_told_how_to_get_them() {
        let reason = missing("no/such/python".as_ref(), "numpy", "peers", "").unwrap();
        assert!(reason.contains("pip install -r xtask/peers/requirements.txt"), "{reason}");
    }
}
