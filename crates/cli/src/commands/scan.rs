//! Options that say how a scan is opened, and which part of it is used.

use super::lengths::length;
use super::named;
use crate::failure::Failure;
use crate::notes;
use std::path::{Path, PathBuf};
use transect::register::PoseReading;
use transect_device::{ImageOrder, ImageSize, PinholeScale};
use transect_exchange::{CameraOption, OpenOptions};
use transect_geometry::LengthUnit;
use transect_workflow::{OpenScan, Selection, ViewList};

/// How a scan is opened.
#[derive(Debug, clap::Args)]
pub struct ScanArguments {
    /// Length unit of a scan that does not state one: m, dm, cm, mm, um, in or ft.
    #[arg(long)]
    unit: Option<LengthUnit>,
    /// Leave out views whose file does not exist, with a note.
    #[arg(long)]
    skip_missing: bool,
    /// Rows and columns of a cloud whose points are stored row by row, such as 480x640.
    #[arg(long, value_name = "ROWSxCOLS", value_parser = grid)]
    grid: Option<ImageSize>,
    /// Number of lasers of a rotating lidar whose file has no field for them.
    #[arg(long, value_name = "N")]
    rings: Option<usize>,
    /// Read the poses by another convention than world from sensor with x right, y down and z
    /// forward.
    #[arg(long, value_name = "NAME",
        value_parser = named(PoseReading::ALL.map(|reading| (reading.name(), reading))))]
    pose_convention: Option<PoseReading>,
    /// Read images whose files hold the pixels in another order than the sensor's.
    #[arg(long, value_name = "NAME",
        value_parser = named(ImageOrder::ALL.map(|order| (order.name(), order))))]
    image_order: Option<ImageOrder>,
    #[command(flatten)]
    depth: DepthArguments,
    #[command(flatten)]
    part: PartArguments,
}

/// The part of a scan that is used.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Part of the scan")]
struct PartArguments {
    /// Use these views only: numbers from 0, ranges of numbers and names, such as 3-7,12. Names may
    /// hold commas.
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

/// Options in place of the files of a folder of depth images.
#[derive(Debug, clap::Args)]
pub struct DepthArguments {
    /// Poses of a folder of depth images or clouds, sensor to world: TUM, KITTI, Open3D .log or
    /// .json, matrices as numbers, or a folder with one file per image.
    #[arg(long, value_name = "FILE")]
    poses: Option<PathBuf>,
    /// Camera of a folder of depth images: a JSON file of Open3D or RealSense, a text file, or the
    /// numbers FX,FY,CX,CY in pixels.
    #[arg(long, value_name = "FILE")]
    camera: Option<CameraOption>,
    /// Metres per count of a folder's depth images, such as 0.001.
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    depth_scale: Option<f64>,
    /// Read the pixels of a folder's depth images as depths along the optical axis, which is the
    /// default, or as lengths of rays.
    #[arg(long, value_name = "NAME",
        value_parser = named(PinholeScale::ALL.map(|scale| (scale.name(), scale))))]
    pixels_hold: Option<PinholeScale>,
    /// Largest difference between the times of a depth image and of the nearest pose, in seconds;
    /// 0.02 if not stated.
    #[arg(long, value_name = "SECONDS")]
    max_time_difference: Option<f64>,
}

fn grid(text: &str) -> Result<ImageSize, String> {
    let (rows, cols) = text.split_once(['x', '×']).unwrap_or((text, ""));
    let size = rows.trim().parse().ok().zip(cols.trim().parse().ok());
    let size = size.map(|(rows, cols)| ImageSize { rows, cols }).filter(|s| s.check().is_ok());
    size.ok_or_else(|| "expected rows x columns, such as 480x640".to_owned())
}

impl ScanArguments {
    /// Opens the part of a scan that the arguments name.
    pub fn open(&self, path: &Path) -> Result<OpenScan, Failure> {
        let selection = self.selection()?;
        let scan = OpenScan::open(path, &self.options())?;
        let scan = match self.pose_convention {
            Some(reading) => scan.with_reading(reading),
            None => scan,
        };
        let scan = scan.select(&selection)?;
        // Before anything can fail: a note may be the reason.
        notes::tell(&scan.scan().notes);
        Ok(scan)
    }

    /// Whether no argument is given.
    pub fn is_empty(&self) -> bool {
        self.options() == OpenOptions::default()
            && self.part.is_empty()
            && self.pose_convention.is_none()
    }

    fn selection(&self) -> Result<Selection, Failure> {
        let mut selection = Selection::default();
        selection.views = self.part.views.as_deref().map(ViewList::from);
        selection.every = self.part.every;
        selection.crop = self.part.crop.as_deref().map(str::parse).transpose()?;
        selection.max_range = length("max-range", self.part.max_range.as_ref())?;
        Ok(selection)
    }

    /// The options that the arguments stand for.
    fn options(&self) -> OpenOptions {
        let mut options = self.depth.options();
        (options.unit, options.skip_missing) = (self.unit, self.skip_missing);
        (options.grid, options.rings) = (self.grid, self.rings);
        options.image_order = self.image_order;
        options
    }
}

impl PartArguments {
    /// Whether no argument is given.
    fn is_empty(&self) -> bool {
        let Self { views, every, crop, max_range } = self;
        views.is_none() && every.is_none() && crop.is_none() && max_range.is_none()
    }
}

impl DepthArguments {
    /// The options that the arguments stand for.
    pub fn options(&self) -> OpenOptions {
        let mut options = OpenOptions::default();
        (options.poses, options.camera) = (self.poses.clone(), self.camera.clone());
        (options.depth_scale, options.pixels_hold) = (self.depth_scale, self.pixels_hold);
        options.max_time_difference = self.max_time_difference;
        options
    }
}
