//! `transect evaluate`: how accurate a model is.

use crate::failure::Failure;
use crate::table::{print, print_rows_csv};
use std::path::{Path, PathBuf};
use transect_workflow::{ModelFile, Reference, ResultFolder, ScoreLimits, find_model, score};

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

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let file = find_model(&arguments.model)?;
    let reference = match &arguments.reference {
        Some(mesh) => Reference::Mesh(mesh.clone()),
        None => Reference::of_results(&ResultFolder::new(file.parent().unwrap_or(Path::new("")))),
    };
    if matches!(reference, Reference::Nothing) {
        eprintln!(
            "note: only duplicated length is measured. There is no --reference MESH, and the scan has \
             no truth beside it, or was read in part or by another convention"
        );
    }
    let limits =
        ScoreLimits { from: arguments.from.clone(), tolerance: arguments.tolerance.clone() };
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
