//! Options that say how a scan is opened.

use std::path::PathBuf;
use transect_device::ImageSize;
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
    /// File with one pose per cloud of a folder, world from sensor, as 3 × 4 or 4 × 4 numbers.
    #[arg(long, value_name = "FILE")]
    poses: Option<PathBuf>,
    /// Rows and columns of a cloud whose points are stored row by row, such as 480x640.
    #[arg(long, value_name = "ROWSxCOLS", value_parser = grid)]
    grid: Option<ImageSize>,
    /// Number of lasers of a rotating lidar whose file has no field for them.
    #[arg(long, value_name = "N")]
    rings: Option<usize>,
}

fn grid(text: &str) -> Result<ImageSize, String> {
    let (rows, cols) = text.split_once(['x', '×']).unwrap_or((text, ""));
    let size = rows.trim().parse().ok().zip(cols.trim().parse().ok());
    let size = size.map(|(rows, cols)| ImageSize { rows, cols }).filter(|s| s.check().is_ok());
    size.ok_or_else(|| "expected rows x columns, such as 480x640".to_owned())
}

impl ScanArguments {
    /// The options that the arguments stand for.
    pub fn options(&self) -> OpenOptions {
        let mut options = OpenOptions::default();
        (options.unit, options.skip_missing) = (self.unit, self.skip_missing);
        (options.grid, options.rings) = (self.grid, self.rings);
        options.poses.clone_from(&self.poses);
        options
    }
}
