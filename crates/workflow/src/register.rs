//! Registration: the poses of a scan, refined and written as a scan of their own.

use crate::outputs::{Staging, claim_output, claim_registered};
use crate::report_file::readable;
use crate::results::MODEL;
use crate::{Check, OpenScan, Plausibility, PriorSettings, WorkflowError};
use serde::Serialize;
use std::path::Path;
use transect::register::{PoseReading, RefinedPose};
use transect::{PoseReport, Watch};
use transect_device::Note;
use transect_exchange::{MANIFEST_FILE, PosedScan, ScanView, SensorEntry, ViewPose, write_file};

/// The file of the report beside it.
const REPORT: &str = "report.json";

/// The poses of a scan, refined.
#[derive(Debug)]
pub struct Registration<'a> {
    /// The poses, in the order of the scan's views.
    pub poses: PoseReport,
    /// The notes about them.
    pub notes: Vec<Note>,
    scan: &'a OpenScan,
}

/// The content of `report.json`.
#[derive(Serialize)]
struct RegistrationReport<'a> {
    tool: &'static str,
    version: &'static str,
    /// Absolute path of the scan that was registered.
    registered: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pose_convention: Option<PoseReading>,
    warnings: Vec<String>,
    notes: &'a [Note],
    reader_notes: &'a [Note],
    #[serde(flatten)]
    poses: &'a PoseReport,
}

impl OpenScan {
    /// Refines the poses of all views; see [`Settings::prior`](crate::Settings::prior).
    ///
    /// # Errors
    /// [`WorkflowError`] if a view cannot be loaded or is implausible. It is also an error if the
    /// poses were written by another convention, or if most views contradict each other.
    pub fn register(
        &self,
        prior: Option<PriorSettings>,
        accept: &[Check],
        watch: &dyn Watch,
    ) -> Result<Registration<'_>, WorkflowError> {
        let unit = self.scan().unit;
        let options = PriorSettings::options(prior, unit);
        let views = self.views("", Plausibility::without_planes(unit, accept))?;
        let poses = PoseReport::new(&views, Some(&options), unit, watch)?;
        if let Some(problem) = poses.unfit() {
            return Err(WorkflowError::file(&self.path, problem));
        }
        Ok(Registration { notes: poses.notes(), poses, scan: self })
    }
}

impl OpenScan {
    /// Judges the poses of all views as they are; `None` for a single view.
    ///
    /// # Errors
    /// [`WorkflowError`] if a view cannot be loaded.
    pub fn judge(&self, watch: &dyn Watch) -> Result<Option<PoseReport>, WorkflowError> {
        let unit = self.scan().unit;
        if self.scan().views.len() < 2 {
            return Ok(None);
        }
        let accepted = Plausibility::without_planes(unit, &Check::ALL);
        let views = self.views("", accepted)?;
        Ok(Some(PoseReport::new(&views, None, unit, watch)?))
    }
}

impl Registration<'_> {
    /// Refuses outputs that would replace an input or a file of another kind, or that cannot be
    /// written. Call it before long work.
    ///
    /// # Errors
    /// [`WorkflowError`] naming the file that must stay, or the folder that cannot be written.
    pub fn claim(scan: &OpenScan, folder: &Path) -> Result<(), WorkflowError> {
        let inputs = &scan.scan().inputs;
        let report = folder.join(REPORT);
        claim_registered(&folder.join(MANIFEST_FILE), &report, &scan.path, inputs)?;
        let model = folder.join(MODEL);
        if model.exists() {
            let problem = "the folder holds the results of reconstruct, whose report.json would be \
                           replaced; choose another --out";
            return Err(WorkflowError::file(&model, problem));
        }
        claim_output(&report, inputs)?;
        Staging::begin(folder).map(drop)
    }

    /// Writes the scan with the refined poses and the report into a folder; both appear together.
    /// Returns the warnings of the report.
    ///
    /// # Errors
    /// [`WorkflowError`] naming the file that cannot be written, or must stay.
    pub fn write(&self, folder: &Path) -> Result<Vec<String>, WorkflowError> {
        Self::claim(self.scan, folder)?;
        let staging = Staging::begin(folder)?;
        let of_view = |(pose, view): (&RefinedPose, &ScanView)| ViewPose {
            view: pose.view.clone(),
            world_from_sensor: pose.world_from_sensor,
            depth_offsets: pose.depth_offsets.clone(),
            surface_sigma: pose.surface_sigma_after(view.surface_sigma()),
        };
        let OpenScan { path, options, scan, .. } = self.scan;
        let poses = self.poses.refinement.iter().flat_map(|r| &r.poses);
        let poses: Vec<_> = poses.zip(&scan.views).map(of_view).collect();
        let posed = scan.posed(path, options, &poses, folder)?;
        write_file(&staging.path().join(MANIFEST_FILE), |out| posed.write(out))?;
        let mut warnings = self.poses.warnings();
        warnings.extend(lost_offsets(&posed, &poses));
        let report = RegistrationReport {
            tool: "transect",
            version: env!("CARGO_PKG_VERSION"),
            registered: readable(&std::path::absolute(path).unwrap_or_else(|_| path.clone())),
            pose_convention: self.scan.reading,
            warnings: warnings.clone(),
            notes: &self.notes,
            reader_notes: &scan.notes,
            poses: &self.poses,
        };
        let write = |out: &mut dyn std::io::Write| Ok(serde_json::to_writer_pretty(out, &report)?);
        write_file(&staging.path().join(REPORT), write)?;
        staging.commit()?;
        Ok(warnings)
    }
}

/// The warning that the written scan does not state the errors of its depth camera.
fn lost_offsets(posed: &PosedScan, poses: &[ViewPose]) -> Option<String> {
    let found = poses.iter().filter(|pose| pose.depth_offsets.is_some()).count();
    let states = |sensor: &SensorEntry| matches!(sensor, SensorEntry::Pinhole(entry) if entry.depth_offsets.is_some());
    let stated = match posed {
        PosedScan::Manifest(list) => list.views.iter().filter(|v| states(&v.sensor)).count(),
        PosedScan::Poses(_) => 0,
    };
    (found > stated).then(|| {
        format!(
            "scan.json has the refined poses, and not the error that the depth camera makes alike \
             in {found} images: only pinhole images of a scan.json or a folder can state it. Run \
             reconstruct SCAN --refine-poses, which corrects the images"
        )
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests may fail loudly")]
mod tests {
    use super::*;
    use transect_device::{DepthOffsets, Isometry3};

    #[test]
    fn offsets_that_a_scan_cannot_state_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part.conf");
        std::fs::write(&path, "bmesh a.ply 0 0 0 0 0 0 1\n").unwrap();
        std::fs::write(folder.path().join("a.ply"), "ply").unwrap();
        let offsets = DepthOffsets::new(2, 2, vec![1e-3; 4]).unwrap();
        let pose = |depth_offsets| ViewPose {
            view: "a.ply".to_owned(),
            world_from_sensor: Isometry3::identity(),
            depth_offsets,
            surface_sigma: None,
        };
        let scan = transect_exchange::Scan::open(&path).unwrap();
        let lost = |poses: &[ViewPose]| {
            let options = transect_exchange::OpenOptions::default();
            lost_offsets(&scan.posed(&path, &options, poses, folder.path()).unwrap(), poses)
        };
        assert_eq!(lost(&[pose(None)]), None);
        assert!(lost(&[pose(Some(offsets))]).unwrap().contains("in 1 images"));
    }
}
