//! `lookup_table`: a scanner with one scanning angle on a linear axis, calibrated by tables (HYSCAN).
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
use super::super::word;
use crate::ReadError;
use serde::Serialize;
use transect_sensors::lookup_table::{CalibrationOptions, DepthPairs, ScanPlane};

/// A calibrated scanner on a linear axis, as manifests describe it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LookupTableEntry {
    /// Scanning angle of column 0; radians.
    pub theta0: f64,
    /// From one column to the next; radians, positive.
    pub dtheta: f64,
    /// The file of the calibration sweeps, relative to the manifest or absolute.
    pub calibration: String,
    /// Samples in the calibration's median filter, odd; 1 for none.
    pub median_window: usize,
    /// Which two depths give an estimate of a beam.
    #[serde(serialize_with = "word::write")]
    pub pairs: DepthPairs,
    /// Place of row 0 on the linear axis; a length.
    pub y0: f64,
    /// From one row to the next; a signed length, not 0.
    pub dy: f64,
    /// The plane that is swept, and with it the linear axis.
    #[serde(serialize_with = "word::write")]
    pub mounting: ScanPlane,
    /// Turn about the linear axis; radians.
    pub tilt: f64,
    /// Where the light leaves and where it is watched from, if known.
    #[serde(flatten)]
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

impl LookupTableEntry {
    pub(super) fn read(keys: &Keys<'_>) -> Result<Self, ReadError> {
        let usual = CalibrationOptions::default();
        let calibration = keys.text("calibration")?;
        Ok(Self {
            theta0: keys.required_number("theta0")?,
            dtheta: keys.required_number("dtheta")?,
            calibration: calibration
                .ok_or_else(|| keys.wrong("calibration", "a file name"))?
                .to_owned(),
            median_window: keys.count("median_window")?.unwrap_or(usual.median_window),
            pairs: keys.word("pairs")?.unwrap_or(usual.pairs),
            y0: keys.required_number("y0")?,
            dy: keys.required_number("dy")?,
            mounting: keys.required_word("mounting")?,
            tilt: keys.number("tilt")?.unwrap_or(0.0),
            viewpoints: ViewpointsEntry::read(keys)?,
        })
    }

    /// How the calibration data are treated.
    pub(crate) fn options(&self) -> CalibrationOptions {
        CalibrationOptions { median_window: self.median_window, pairs: self.pairs }
    }
}

impl ViewpointsEntry {
    fn read(keys: &Keys<'_>) -> Result<Option<Self>, ReadError> {
        match (keys.numbers("projector")?, keys.numbers("receiver")?) {
            (Some(projector), Some(receiver)) => Ok(Some(Self { projector, receiver })),
            (None, None) => Ok(None),
            (None, Some(_)) => Err(keys.wrong("projector", "given with \"receiver\": [u, v]")),
            (Some(_), None) => Err(keys.wrong("receiver", "given with \"projector\": [u, v]")),
        }
    }
}
