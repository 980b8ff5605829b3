//! `transect replace-view`: replaces the image or the pose of a view in a model store.

use super::note_finished;
use super::planes::{AcceptArguments, parse_numbers};
use super::reconstruct::tell;
use crate::failure::Failure;
use crate::table::{Row, print};
use std::path::PathBuf;
use transect_exchange::pose_of_row_major;
use transect_geometry::Isometry3;
use transect_workflow::{Replacement, StoreFile};

/// Options of `replace-view`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model store.
    file: PathBuf,
    /// Name of the view to replace, as list-views prints it.
    name: String,
    /// Scan to take the view from [default: the scan that the view came from].
    scan: Option<PathBuf>,
    /// Name of the view in that scan [default: its name in the scan that it came from].
    #[arg(long, value_name = "NAME")]
    view: Option<String>,
    /// Pose in place of the scan's own: 16 numbers with commas between them, sensor to world, row
    /// by row.
    #[arg(long, value_name = "NUMBERS", allow_hyphen_values = true)]
    pose: Option<String>,
    #[command(flatten)]
    accept: AcceptArguments,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let replacement = Replacement {
        scan: arguments.scan.clone(),
        view: arguments.view.clone(),
        pose: arguments.pose.as_deref().map(parse_pose).transpose()?,
        accept: arguments.accept.accept.clone(),
    };
    let store = StoreFile::open(&arguments.file)?;
    note_finished(store.planes_finished());
    let replaced = store.replace_view(&arguments.name, &replacement)?;
    store.close()?;
    tell(&replaced.report);
    let planes: usize = replaced.views.iter().map(|view| view.planes.len()).sum();
    print(&[
        Row::plain("replaced", &arguments.name),
        Row::plain("planes fused anew", replaced.planes_fused),
        Row::plain("planes with its curves", planes),
    ]);
    Ok(())
}

fn parse_pose(text: &str) -> Result<Isometry3, Failure> {
    let wrong = |reason: String| Failure::Usage(format!("--pose: {reason}"));
    let matrix = parse_numbers(text);
    let matrix = matrix.ok_or_else(|| {
        wrong(format!("expected 16 numbers with commas between them, found {text}"))
    })?;
    let (pose, repaired) = pose_of_row_major(&matrix).map_err(wrong)?;
    if let Some(deviation) = repaired {
        eprintln!(
            "note: --pose: its columns deviate from orthonormal by {deviation:.2e}; the nearest \
             rotation is used"
        );
    }
    Ok(pose)
}
