//! `transect manifest`: a scan.json for a folder of depth images.

use super::lengths::length;
use super::planes::parse_normal;
use super::scan::DepthArguments;
use crate::failure::Failure;
use crate::notes;
use crate::table::{Row, print};
use std::path::PathBuf;
use transect_exchange::{
    FileNames, PlanesEntry, depth_sequence_manifest, write_file, write_manifest,
};
use transect_geometry::LengthUnit;
use transect_workflow::claim_manifest;

/// Options of `manifest`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of depth images with poses and a camera: TUM, ICL-NUIM, ScanNet, 7-Scenes, Open3D.
    folder: PathBuf,
    #[command(flatten)]
    depth: DepthArguments,
    /// File to write; images are named by absolute path in it.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Replace the file even if this command did not write it for the same folder.
    #[arg(long)]
    force: bool,
    /// Normal of the section planes to put into it, as X,Y,Z.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "interval")]
    normal: Option<String>,
    /// Distance between the section planes to put into it; a bare number is in metres.
    #[arg(long, value_name = "LENGTH", requires = "normal")]
    interval: Option<String>,
    /// Station of plane 0 to put into it; a bare number is in metres. 0 if it is left out.
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, requires = "normal")]
    offset: Option<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let options = arguments.depth.options();
    let (mut manifest, notes) =
        depth_sequence_manifest(&arguments.folder, FileNames::Absolute, &options)?;
    notes::tell(&notes);
    let metres = |option, text: &Option<String>| -> Result<Option<f64>, Failure> {
        Ok(length(option, text.as_ref())?.map(|length| length.in_unit(LengthUnit::Metre)))
    };
    let interval = metres("interval", &arguments.interval)?;
    if let (Some(normal), Some(interval)) = (&arguments.normal, interval) {
        let offset = metres("offset", &arguments.offset)?;
        let planes = PlanesEntry::new(parse_normal(normal)?, offset.unwrap_or(0.0), interval);
        planes.family().map_err(|e| Failure::Usage(e.to_string()))?;
        manifest.planes = Some(planes);
    }
    let images = manifest.views.iter().map(|view| PathBuf::from(&view.file));
    let (images, folder) = (images.collect::<Vec<_>>(), &arguments.folder);
    claim_manifest(&arguments.out, folder, arguments.force, &images)?;
    if let Some(folder) = arguments.out.parent().filter(|f| !f.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(|e| Failure::with_file(folder, e))?;
    }
    write_file(&arguments.out, |out| write_manifest(&manifest, "manifest", out))?;
    print(&[
        Row::plain("views", manifest.views.len()),
        Row::plain("manifest", arguments.out.display()),
    ]);
    Ok(())
}
