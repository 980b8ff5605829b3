//! Result folders: the one place that writes the files of a run.

use crate::outputs::{Staging, check_output, claim_output};
use crate::table::Row;
use crate::{Costs, ReportFile, WorkflowError};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::Read;
use std::path::{Path, PathBuf};
use transect_exchange::svg::{OverviewOptions, Sheets, write_overview};
use transect_exchange::{
    DxfFrame, MANIFEST_FILE, ModelSplines, read_text, write_contours, write_dxf, write_file,
};
use transect_geometry::PlaneIndex;
use transect_model::{Model, open_regular};

/// The model's file in a result folder.
pub(crate) const MODEL: &str = "model.transect";

/// The report's file in a result folder.
const REPORT: &str = "report.json";

/// The splines' files in a result folder.
const SPLINES: [&str; 2] = ["splines.json", "splines.dxf"];

/// The other files in a result folder: contours, drawing, picture of the whole model.
const OTHERS: [&str; 3] = ["contours.json", "model.dxf", "overview.svg"];

/// The folder of the sheets in a result folder.
const SHEETS: &str = "planes";

/// The folder, beneath the current one, that holds the results of a run without a chosen folder.
const DEFAULT_PARENT: &str = "transect-out";

/// The folder for the results of a run, unless the user chooses another: `transect-out/NAME`
/// beneath the current folder. A name without a letter or a digit is no name of a folder: dots
/// lead out of it.
pub fn default_folder(name: &str) -> PathBuf {
    let safe = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    let named = name.chars().any(char::is_alphanumeric);
    let name = if named { name } else { "scan" };
    Path::new(DEFAULT_PARENT).join(name.chars().map(safe).collect::<String>())
}

/// Whether a path is a model file, a model store, or a result folder.
///
/// A folder that is a scan as well counts as a scan.
pub fn is_model(path: &Path) -> bool {
    if path.join(MANIFEST_FILE).is_file() {
        return false;
    }
    let Ok(file) = find_model(path) else { return false };
    let mut magic = [0; 8];
    let read = open_regular(&file).and_then(|mut file| file.read_exact(&mut magic));
    read.is_ok() && magic == *b"TRANSECT"
}

/// The model file that a path stands for: the file itself, or the one in a result folder.
///
/// # Errors
/// [`WorkflowError`] if there is no such file, or the folder holds no model.
pub fn find_model(path: &Path) -> Result<PathBuf, WorkflowError> {
    if !std::fs::metadata(path).map_err(WorkflowError::io("find the model", path))?.is_dir() {
        return Ok(path.to_owned());
    }
    let file = path.join(MODEL);
    if file.is_file() {
        return Ok(file);
    }
    let problem = format!(
        "the folder holds no {MODEL}; give the folder of a model that reconstruct wrote, a model \
         file, or a model store"
    );
    Err(WorkflowError::file(path, problem))
}

/// The folder of a run's results.
#[derive(Debug, Clone)]
pub struct ResultFolder(PathBuf);

impl ResultFolder {
    /// A folder, which is made when the first file is written.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self(path.into())
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// The curves for CAD.
    pub fn drawing(&self) -> PathBuf {
        self.0.join("model.dxf")
    }

    /// The picture of the whole model.
    pub fn overview(&self) -> PathBuf {
        self.0.join("overview.svg")
    }

    /// Refuses results that would replace an input or a model store, or that cannot be written.
    /// Call it before long work.
    ///
    /// # Errors
    /// [`WorkflowError`] naming the file that must stay, or the folder that cannot be written.
    pub fn claim(&self, inputs: &[PathBuf]) -> Result<(), WorkflowError> {
        for folder in [self.0.clone(), self.0.join(SHEETS)] {
            if folder.exists() && !folder.is_dir() {
                let problem = "is a file, and the results need a folder there; choose another one";
                return Err(WorkflowError::file(&folder, problem));
            }
        }
        let files = [MODEL, REPORT].into_iter().chain(SPLINES).chain(OTHERS);
        files.clone().try_for_each(|name| claim_output(&self.0.join(name), inputs))?;
        self.old_sheets().iter().try_for_each(|sheet| check_output(sheet, inputs))?;
        self.check_origin(files.map(|name| self.0.join(name)).chain(self.old_sheets()))?;
        Staging::begin(&self.0).map(drop)
    }

    /// Refuses to replace files of other programs: those of this one have their model beside them.
    fn check_origin(&self, mut named: impl Iterator<Item = PathBuf>) -> Result<(), WorkflowError> {
        if is_model(&self.0.join(MODEL)) {
            return Ok(());
        }
        named.find(|file| file.exists()).map_or(Ok(()), |file| {
            let problem = format!(
                "the file exists, and no {MODEL} beside it tells that this program wrote it; \
                 choose another folder, or move the file away"
            );
            Err(WorkflowError::file(&file, problem))
        })
    }

    /// Writes the model, its contours, the drawing, the overview and one sheet per plane. All files
    /// appear together, in place of older ones.
    ///
    /// # Errors
    /// [`WorkflowError`] naming the file that cannot be written, or that must stay.
    pub fn write_model(
        &self,
        title: &str,
        model: &Model,
        frame: DxfFrame,
    ) -> Result<(), WorkflowError> {
        self.write_together(|staged| staged.write_curves(title, model, frame))
    }

    /// Writes files into a stage, moves them here together, and removes older sheets and splines,
    /// which would be taken for part of the new results.
    pub(crate) fn write_together<T>(
        &self,
        write: impl FnOnce(&Self) -> Result<T, WorkflowError>,
    ) -> Result<T, WorkflowError> {
        let staging = Staging::begin(&self.0)?;
        let done = write(&Self::new(staging.path()))?;
        let moved = staging.commit()?;
        let old = SPLINES.map(|name| self.0.join(name)).into_iter().chain(self.old_sheets());
        for file in old.filter(|file| file.exists() && !moved.contains(file)) {
            std::fs::remove_file(&file).map_err(WorkflowError::io("remove the old file", &file))?;
        }
        Ok(done)
    }

    pub(crate) fn write_curves(
        &self,
        title: &str,
        model: &Model,
        frame: DxfFrame,
    ) -> Result<(), WorkflowError> {
        model.save(self.0.join(MODEL))?;
        let [contours, drawing, _] = OTHERS.map(|name| self.0.join(name));
        write_file(&contours, |out| write_contours(model, out))?;
        write_file(&drawing, |out| write_dxf(model, frame, out))?;
        let mut options = OverviewOptions::default();
        options.title = title.to_owned();
        write_file(&self.overview(), |out| write_overview(model, &options, out))?;
        let sheets = self.0.join(SHEETS);
        std::fs::create_dir_all(&sheets).map_err(WorkflowError::io("make the folder", &sheets))?;
        write_sheets(&sheets, model)
    }

    /// The sheets in the folder, by their names: `planes/plane_+0012.svg`.
    fn old_sheets(&self) -> Vec<PathBuf> {
        let is_sheet = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let number = name.strip_prefix("plane_").and_then(|n| n.strip_suffix(".svg"));
            number.is_some_and(|n| {
                n.len() >= 5
                    && n.starts_with(['+', '-'])
                    && n[1..].bytes().all(|b| b.is_ascii_digit())
            })
        };
        let entries = std::fs::read_dir(self.0.join(SHEETS)).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).filter(is_sheet).collect()
    }

    /// Writes the curves as splines within a tolerance; returns the table's rows on them.
    pub(crate) fn write_splines(
        &self,
        model: &Model,
        tolerance: f64,
    ) -> Result<Vec<Row>, WorkflowError> {
        let splines = ModelSplines::fit(model, tolerance);
        let splines = splines.map_err(|e| WorkflowError::setting("splines", e))?;
        let [json, drawing] = SPLINES.map(|name| self.0.join(name));
        write_file(&json, |out| splines.write_json(out))?;
        write_file(&drawing, |out| splines.write_dxf(out))?;
        Ok(vec![
            Row::plain("control points of splines", splines.control_count()),
            Row::length("splines within", splines.deviation(), model.unit()),
        ])
    }

    /// Writes the report of a run with its table and costs.
    pub(crate) fn write_report(
        &self,
        report: &ReportFile<'_>,
        result: &[Row],
        stages: &Costs,
    ) -> Result<(), WorkflowError> {
        #[derive(Serialize)]
        struct Whole<'a> {
            #[serde(flatten)]
            report: &'a ReportFile<'a>,
            result: &'a [Row],
            stages: &'a Costs,
        }
        let whole = Whole { report, result, stages };
        let write = |out: &mut dyn std::io::Write| Ok(serde_json::to_writer_pretty(out, &whole)?);
        Ok(write_file(&self.0.join(REPORT), write)?)
    }

    /// The file of the report.
    pub(crate) fn report(&self) -> PathBuf {
        self.0.join(REPORT)
    }

    /// The scan that the folder's model was made of, as its report has it.
    ///
    /// # Errors
    /// The reason, in words: there is no report, or the scan was read in part, or in another way
    /// than it states.
    pub(crate) fn made_of(&self) -> Result<MadeOf, String> {
        #[derive(Deserialize)]
        struct Written {
            selection: Option<Value>,
            pose_convention: Option<Value>,
            image_order: Option<Value>,
            #[serde(default)]
            skip_missing: bool,
            #[serde(flatten)]
            made_of: MadeOf,
        }
        let report = self.report();
        if !report.exists() {
            return Err(format!(
                "no {REPORT} beside the model names its scan; reconstruct writes both into its --out"
            ));
        }
        let text = read_text(&report).ok();
        let written = text.and_then(|text| serde_json::from_str::<Written>(&text).ok());
        let written = written
            .ok_or_else(|| format!("{} does not name the scan of the model", report.display()))?;
        let otherwise = [written.selection, written.pose_convention, written.image_order];
        if otherwise.iter().any(Option::is_some) || written.skip_missing {
            let scan = written.made_of.scan.display();
            return Err(format!("the scan {scan} was read in part or by another convention"));
        }
        Ok(written.made_of)
    }
}

/// The scan of a model and the files that were read of it.
#[derive(Debug, Deserialize)]
pub(crate) struct MadeOf {
    pub scan: PathBuf,
    #[serde(default)]
    pub inputs: Vec<HashedInput>,
}

/// A file that was read, and the hash of its content, if it is known.
#[derive(Debug, Deserialize)]
pub(crate) struct HashedInput {
    pub path: PathBuf,
    pub sha256: Option<String>,
}

fn write_sheets(folder: &Path, model: &Model) -> Result<(), WorkflowError> {
    let sheets = Sheets::new(model);
    let planes: Vec<PlaneIndex> = model.sections().map(|(plane, _)| plane).collect();
    planes.par_iter().try_for_each(|&plane| {
        let path = folder.join(format!("plane_{:+05}.svg", plane.0));
        // The folder is in a stage: no program reads the file before it is renamed with the others.
        // A sheet is drawn from the model, so it may be lost in a crash of the machine. With a name
        // and a sync of its own, each of some thousand sheets takes twice the time.
        let mut text = Vec::new();
        let written = sheets.write(plane, &mut text).and_then(|()| std::fs::write(&path, text));
        written.map_err(WorkflowError::io("write the sheet", &path))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_leads_out_of_the_default_folder() {
        let names = ["room 1", "..", "", "a/../b", "."].map(default_folder);
        let wanted = ["room_1", "scan", "scan", "a_.._b", "scan"];
        assert_eq!(names, wanted.map(|name| Path::new("transect-out").join(name)));
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_named_before_the_work() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("file"), "").unwrap();
        let inside = ResultFolder::new(folder.path().join("file/results"));
        let text = inside.claim(&[]).unwrap_err().to_string();
        assert!(text.contains("file/results") && text.contains("cannot make"), "{text}");
        let results = folder.path().join("results");
        ResultFolder::new(results.clone()).claim(&[]).unwrap();
        assert!(!results.exists(), "a claim leaves nothing behind");
    }

    #[test]
    fn a_refused_action_is_named_with_its_file() {
        let text = crate::with_causes(&find_model(Path::new("no such model")).unwrap_err());
        assert!(text.starts_with("no such model: cannot find the model\n  because: "), "{text}");
    }
}
