//! Options that say how a scan is opened, and which part of it is used.

use crate::failure::Failure;
use std::path::Path;
use transect_exchange::OpenOptions;
use transect_geometry::LengthUnit;
use transect_workflow::{OpenScan, Selection};

/// How a scan is opened.
#[derive(Debug, clap::Args)]
pub struct ScanArguments {
    /// Length unit of a scan that does not state one: m, dm, cm, mm, um, in or ft.
    #[arg(long)]
    unit: Option<LengthUnit>,
    /// Leave out views whose file does not exist, with a note.
    #[arg(long)]
    skip_missing: bool,
    #[command(flatten)]
    part: PartArguments,
}

/// The part of a scan that is used.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Part of the scan")]
struct PartArguments {
    /// Use these views only: numbers from 0, ranges of numbers and names, such as 3-7,12.
    #[arg(long, value_name = "LIST")]
    views: Option<String>,
    /// Use the first view and every NUMBERth after it.
    #[arg(long, value_name = "NUMBER")]
    every: Option<usize>,
    /// Leave out points outside a box in the world; an empty length leaves its side open.
    #[arg(long, value_name = "X0,X1,Y0,Y1,Z0,Z1", allow_hyphen_values = true)]
    crop: Option<String>,
    /// Leave out points farther than this from their sensor.
    #[arg(long, value_name = "LENGTH")]
    max_range: Option<String>,
}

impl ScanArguments {
    /// Opens the part of a scan that the arguments name.
    pub fn open(&self, path: &Path) -> Result<OpenScan, Failure> {
        let mut selection = Selection::default();
        selection.views.clone_from(&self.part.views);
        selection.every = self.part.every;
        selection.crop.clone_from(&self.part.crop);
        selection.max_range.clone_from(&self.part.max_range);
        let scan = OpenScan::open(path, &self.options())?.select(&selection)?;
        // Before anything can fail: a note may be the reason.
        scan.scan().notes.iter().for_each(|note| eprintln!("note: {note}"));
        Ok(scan)
    }

    /// The options that the arguments stand for.
    fn options(&self) -> OpenOptions {
        let mut options = OpenOptions::default();
        (options.unit, options.skip_missing) = (self.unit, self.skip_missing);
        options
    }
}
