//! `lookup_table`: a scanner with one scanning angle on a linear axis, calibrated by tables
//! (HYSCAN).
//!
//! | key | meaning |
//! |---|---|
//! | `theta0`, `dtheta` | scanning angle of column 0 and from one column to the next, radians |
//! | `calibration` | the calibration sweeps: a text file, relative to the manifest, see [`read_calibration`](crate::read_calibration) |
//! | `median_window` | samples in the calibration's median filter, odd; default 7, none: 1 |
//! | `pairs` | which depths give a beam's line: `neighbours` (the default) or `half_apart` |
//! | `y0`, `dy` | place of row 0 on the linear axis and from one row to the next; lengths, `dy` signed and not 0, also for an image of one row |
//! | `mounting` | the plane that is swept: `xz`, carried along y, or `yz`, carried along x |
//! | `tilt` | the scanner's turn about the linear axis, radians; default 0 |
//! | `projector`, `receiver` | `[u, v]` of the mirrors' pivots in the scanner's plane; lengths, both or neither |
//!
//! Pixels hold `p`, the spot's place on the detector in the calibration's unit.

use super::super::keys::Keys;
use super::Sensor;
use super::shared::Shared;
use crate::scan::FramedImage;
use crate::view_file::ViewFile;
use crate::{Place, ReadError, read_calibration};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use transect_device::ImageSize;
use transect_sensors::lookup_table::{
    CalibrationOptions, DepthPairs, DigitizedField, LinearSteps, Mounting, ScanPlane, ThetaSteps,
    Viewpoints, digitize,
};
use transect_sensors::{LookupTable, SensorError};

/// A calibrated scanner on a linear axis in a manifest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LookupTableEntry {
    /// Scanning angle of column 0; radians.
    pub theta0: f64,
    /// From one column to the next; radians, positive.
    pub dtheta: f64,
    /// The file of the calibration sweeps, relative to the manifest or absolute.
    pub calibration: String,
    /// Samples in the calibration's median filter, odd; 1 for none.
    #[serde(default = "usual_window")]
    pub median_window: usize,
    /// Which two depths give an estimate of a beam.
    #[serde(default)]
    pub pairs: DepthPairs,
    /// Place of row 0 on the linear axis; a length.
    pub y0: f64,
    /// From one row to the next; a signed length, not 0.
    pub dy: f64,
    /// The plane that is swept, and with it the linear axis.
    pub mounting: ScanPlane,
    /// Turn about the linear axis; radians.
    #[serde(default)]
    pub tilt: f64,
    /// The start of the light and the point that sees it, if known.
    #[serde(flatten, skip_deserializing)]
    pub viewpoints: Option<ViewpointsEntry>,
}

/// The mirrors' pivots `[u, v]` in the scanner's plane; lengths.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ViewpointsEntry {
    /// Pivot of the projecting mirror.
    pub projector: [f64; 2],
    /// Pivot of the receiving mirror.
    pub receiver: [f64; 2],
}

/// The expected value of each of the two keys.
const BOTH: &str = "[u, v], and stand with the other of \"projector\" and \"receiver\"";

fn usual_window() -> usize {
    CalibrationOptions::default().median_window
}

impl LookupTableEntry {
    pub(super) fn read(keys: &Keys<'_>) -> Result<Self, ReadError> {
        let viewpoints = match (keys.optional("projector")?, keys.optional("receiver")?) {
            (Some(projector), Some(receiver)) => Some(ViewpointsEntry { projector, receiver }),
            (None, None) => None,
            (None, Some(_)) => return Err(keys.wrong("projector", BOTH)),
            (Some(_), None) => return Err(keys.wrong("receiver", BOTH)),
        };
        Ok(Self { viewpoints, ..keys.fields()? })
    }

    /// The scanner. Its calibration file is relative to `folder`.
    pub(super) fn sensor(&self, folder: &Path) -> LookupTableSensor {
        let calibration = folder.join(&self.calibration);
        LookupTableSensor { entry: self.clone(), calibration, tables: Shared::default() }
    }

    /// The treatment of the calibration data.
    pub(super) fn options(&self) -> CalibrationOptions {
        CalibrationOptions { median_window: self.median_window, pairs: self.pairs }
    }
}

#[derive(Debug)]
pub(super) struct LookupTableSensor {
    entry: LookupTableEntry,
    calibration: PathBuf,
    tables: Shared<LookupTable>,
}

impl Sensor for LookupTableSensor {
    /// The calibration.
    fn file(&self) -> Option<&Path> {
        Some(&self.calibration)
    }

    fn load(&self, file: &ViewFile, notes: &mut Vec<String>) -> Result<FramedImage, ReadError> {
        let image = file.load_image(notes)?;
        let size = image.size();
        let frame = self.tables.get_or_make(size, || self.table(file, size))?;
        Ok(FramedImage { frame, image })
    }
}

impl LookupTableSensor {
    fn table(&self, file: &ViewFile, size: ImageSize) -> Result<LookupTable, ReadError> {
        let field = self.field(file, size.cols)?;
        let rows = LinearSteps::new(self.entry.y0, self.entry.dy, size.rows);
        let mounting = Mounting::from_radians(self.entry.mounting, self.entry.tilt);
        let table = LookupTable::new(field, rows, mounting).map_err(|e| file.bad_sensor(e))?;
        let Some(ViewpointsEntry { projector, receiver }) = self.entry.viewpoints else {
            return Ok(table);
        };
        let viewpoints = Viewpoints { projector: projector.into(), receiver: receiver.into() };
        table.with_viewpoints(viewpoints).map_err(|e| file.bad_sensor(e))
    }

    fn field(&self, file: &ViewFile, columns: usize) -> Result<DigitizedField, ReadError> {
        let sweeps = read_calibration(&self.calibration)?;
        let columns = ThetaSteps::from_radians(self.entry.theta0, self.entry.dtheta, columns);
        digitize(&sweeps, &columns, self.entry.options()).map_err(|e| match e {
            // These parameters come from the manifest; the others from the sweeps.
            SensorError::BadParameter { key: "theta0" | "dtheta" | "median_window", .. } => {
                file.bad_sensor(e)
            }
            e => ReadError::unusable(&self.calibration, Place::Whole, "the calibration", e),
        })
    }
}
