//! Calibrated scanners on a linear axis: the calibration is digitised once for all views.

use super::Loaded;
use super::shared::Shared;
use crate::manifest::{LookupTableEntry, ViewpointsEntry};
use crate::{Place, ReadError, ScanView, read_calibration};
use std::path::{Path, PathBuf};
use transect_device::ImageSize;
use transect_sensors::lookup_table::{
    DigitizedField, LinearSteps, Mounting, ThetaSteps, Viewpoints, digitize,
};
use transect_sensors::{LookupTable, SensorError};

#[derive(Debug)]
pub(crate) struct LookupTableSource {
    entry: LookupTableEntry,
    calibration: PathBuf,
    tables: Shared<LookupTable>,
}

impl LookupTableSource {
    pub(super) fn new(folder: &Path, entry: &LookupTableEntry) -> Self {
        let calibration = folder.join(&entry.calibration);
        Self { entry: entry.clone(), calibration, tables: Shared::new() }
    }

    /// The calibration.
    pub(super) fn file(&self) -> &Path {
        &self.calibration
    }

    pub(super) fn load(
        &self,
        view: &ScanView,
        notes: &mut Vec<String>,
    ) -> Result<Loaded, ReadError> {
        let image = view.load_image(notes)?;
        let size = image.size();
        let table = self.tables.get_or_make(size, || self.table(view, size))?;
        Ok((table, image))
    }

    fn table(&self, view: &ScanView, size: ImageSize) -> Result<LookupTable, ReadError> {
        let field = self.field(view, size.cols)?;
        let rows = LinearSteps::new(self.entry.y0, self.entry.dy, size.rows);
        let mounting = Mounting::from_radians(self.entry.mounting, self.entry.tilt);
        let table = LookupTable::new(field, rows, mounting).map_err(|e| view.bad_sensor(e))?;
        let Some(ViewpointsEntry { projector, receiver }) = self.entry.viewpoints else {
            return Ok(table);
        };
        let viewpoints = Viewpoints { projector: projector.into(), receiver: receiver.into() };
        table.with_viewpoints(viewpoints).map_err(|e| view.bad_sensor(e))
    }

    fn field(&self, view: &ScanView, columns: usize) -> Result<DigitizedField, ReadError> {
        let sweeps = read_calibration(&self.calibration)?;
        let columns = ThetaSteps::from_radians(self.entry.theta0, self.entry.dtheta, columns);
        digitize(&sweeps, &columns, self.entry.options()).map_err(|e| match e {
            // These come from the manifest; everything else is about the sweeps.
            SensorError::BadParameter { key: "theta0" | "dtheta" | "median_window", .. } => {
                view.bad_sensor(e)
            }
            e => ReadError::unusable(&self.calibration, Place::Whole, "the calibration", e),
        })
    }
}
