//! `transect evaluate`: how accurate a model is.

use super::lengths::length;
use crate::failure::Failure;
use crate::notes;
use crate::table::{print, print_rows_csv};
use std::path::{Path, PathBuf};
use transect_device::Note;
use transect_workflow::{
    ModelFile, Reference, ResultFolder, ScoreLimits, TruthOfResults, find_model, score,
};

/// Options of `evaluate`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder that `reconstruct` wrote, the model file in it, or a model store.
    model: PathBuf,
    /// Mesh to compare with (.ply, .stl or .obj) [default: the truth of a simulated scan; without
    /// one, only duplication is measured].
    #[arg(long, value_name = "MESH")]
    reference: Option<PathBuf>,
    /// Only planes from this station on; a bare number is in the model's unit.
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    from: Option<String>,
    /// Distance within which a curve counts as right [default: a fifth of the plane interval; where
    /// planes were inserted, of the widest interval that is left].
    #[arg(long, value_name = "LENGTH")]
    tolerance: Option<String>,
    /// Print comma separated values for a spreadsheet.
    #[arg(long)]
    csv: bool,
}

/// The truth of the scan that a folder's model was made of.
fn truth(folder: &Path) -> Result<Reference, Failure> {
    let found = TruthOfResults::find(&ResultFolder::new(folder))?;
    notes::warn(&found.warnings);
    let note = found.absent.map(|reason| {
        Note::new(format!(
            "only duplicated length is measured, because {reason}. To measure distances, pass \
             --reference MESH"
        ))
    });
    notes::tell(note.as_slice());
    Ok(found.reference)
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let file = find_model(&arguments.model)?;
    let reference = match &arguments.reference {
        Some(mesh) => Reference::Mesh(mesh.clone()),
        None => truth(file.parent().unwrap_or(Path::new("")))?,
    };
    let limits = ScoreLimits {
        from: length("from", arguments.from.as_ref())?,
        tolerance: length("tolerance", arguments.tolerance.as_ref())?,
    };
    let model = ModelFile::open(&file)?.into_model()?;
    let score = score(&model, &reference, &limits)?;
    let rows = [score.agreement, score.counts].concat();
    if arguments.csv {
        print_rows_csv(&rows)
    } else {
        print(&rows)
    }
    Ok(())
}
