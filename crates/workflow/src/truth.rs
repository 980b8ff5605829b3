//! The truth of the simulated scan that a model was made of.
//!
//! A scan can be simulated anew after its model was made. The truth beside it then belongs to
//! another scene. `report.json` keeps the SHA-256 of the truth and of the manifest, so a changed
//! file is recognised.

use crate::report_file::sha256;
use crate::results::{MadeOf, ResultFolder};
use crate::{Reference, WorkflowError};
use std::path::{Path, PathBuf};
use transect_exchange::MANIFEST_FILE;

/// The reference of a model that is compared with no mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct TruthOfResults {
    /// The truth beside the scan, or nothing.
    pub reference: Reference,
    /// Why there is no truth; `None` if there is one.
    pub absent: Option<String>,
    /// Warnings: why the truth, or the part of it that the views could see, may be another one.
    pub warnings: Vec<String>,
}

impl TruthOfResults {
    /// The truth beside the scan that a folder's model was made of, if any. It counts what all
    /// views could see, so a model of a part of the scan has none.
    ///
    /// # Errors
    /// [`WorkflowError::File`] if the truth has changed since the model was made.
    pub fn find(folder: &ResultFolder) -> Result<Self, WorkflowError> {
        let absent = |reason| {
            let (reference, warnings) = (Reference::Nothing, Vec::new());
            Ok(Self { reference, absent: Some(reason), warnings })
        };
        let made_of = match folder.made_of() {
            Ok(made_of) => made_of,
            Err(reason) => return absent(reason),
        };
        let scan = &made_of.scan;
        if !scan.exists() {
            return absent(format!("the scan {} is not there any more", scan.display()));
        }
        let reference = Reference::beside(scan);
        let Reference::Simulated { truth, .. } = &reference else {
            return absent(format!("the scan {} has no truth beside it", scan.display()));
        };
        let mut warnings = Vec::new();
        match made_of.state_of(truth) {
            Comparison::Same => (),
            Comparison::Other => return Err(changed(truth, &folder.report())),
            Comparison::Unknown => warnings.push(format!(
                "{}: {} does not state its SHA-256, so the file may have changed since the model \
                 was made. If it has, reconstruct the scan again",
                truth.display(),
                folder.report().display()
            )),
        }
        let manifest = manifest_of(scan);
        if manifest.is_file() && made_of.state_of(&manifest) == Comparison::Other {
            warnings.push(format!(
                "{}: the file has changed since the model was made, so its views may see another \
                 part of the truth, and the completeness may be wrong. Reconstruct the scan again",
                manifest.display()
            ));
        }
        Ok(Self { reference, absent: None, warnings })
    }
}

/// What a report states of a file's content, compared with the file.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Comparison {
    Same,
    Other,
    /// The report does not state it, or the file cannot be read.
    Unknown,
}

impl MadeOf {
    /// Whether a file beside the scan is still the one that the model was made of. Files are known
    /// by name: reports state paths as the run had them, which may be relative.
    fn state_of(&self, file: &Path) -> Comparison {
        let of_name = self.inputs.iter().filter(|input| input.path.file_name() == file.file_name());
        let stated: Vec<&str> = of_name.filter_map(|input| input.sha256.as_deref()).collect();
        match sha256(file) {
            Some(found) if stated.contains(&found.as_str()) => Comparison::Same,
            Some(_) if !stated.is_empty() => Comparison::Other,
            _ => Comparison::Unknown,
        }
    }
}

/// The manifest of a scan that is one, or its folder.
fn manifest_of(scan: &Path) -> PathBuf {
    if scan.is_dir() { scan.join(MANIFEST_FILE) } else { scan.to_owned() }
}

fn changed(truth: &Path, report: &Path) -> WorkflowError {
    let problem = format!(
        "the file has changed since the model was made: its SHA-256 is not the one in {}. It is \
         no longer the truth of the model; reconstruct the scan again, or pass the setting \
         `reference` with a mesh of the scene",
        report.display()
    );
    WorkflowError::file(truth, problem)
}
