//! Options that say how a scan is opened.

use transect_exchange::OpenOptions;
use transect_geometry::LengthUnit;

/// How a scan is opened.
#[derive(Debug, clap::Args)]
pub struct ScanArguments {
    /// Length unit of a scan that does not state one: m, dm, cm, mm, um, in or ft.
    #[arg(long)]
    unit: Option<LengthUnit>,
    /// Leave out views whose file does not exist, with a note.
    #[arg(long)]
    skip_missing: bool,
}

impl ScanArguments {
    /// The options that the arguments stand for.
    pub fn options(&self) -> OpenOptions {
        let mut options = OpenOptions::default();
        (options.unit, options.skip_missing) = (self.unit, self.skip_missing);
        options
    }
}
