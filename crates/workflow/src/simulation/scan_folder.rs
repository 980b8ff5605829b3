//! A scan folder of simulated views: manifest, images, calibrations and the truth.

use super::{PlacedInstrument, PreparedScene, SimulatedScan};
use crate::WorkflowError;
use crate::outputs::{Staging, is_simulated_manifest};
use std::path::Path;
use transect_device::{Pixel, RangeImage, View};
use transect_exchange::{
    Counts, MANIFEST_FILE, Manifest, PlanesEntry, SensorEntry, StripeEntry, TRUTH_FILE,
    TriangleMesh, ViewEntry, row_major, write_calibration, write_file, write_manifest,
    write_npy_image, write_npy_stack, write_truth,
};
use transect_scene::{BitDepth, Counts as StripeCounts, Mesh, StripeCamera};

/// The command that writes simulated scans.
const SIMULATE: &str = "simulate";

/// The form of the light-stripe sensors' images.
#[derive(Debug, Clone, Copy, Default)]
pub enum StripeImages {
    /// As range images: where the stripe is in each row.
    #[default]
    Extracted,
    /// As the camera's images, one per laser angle, in which the reader finds the stripe.
    Seen(StripeCamera),
}

/// The file of a view's calibration.
pub fn calibration_file(view: usize) -> String {
    format!("calibration_{view:03}.csv")
}

/// Prepares a folder for a simulated scan. Without `force`, it must be empty, or hold a simulated
/// scan.
///
/// # Errors
/// [`WorkflowError::File`] if the folder holds other files.
pub fn claim_scan_folder(folder: &Path, force: bool) -> Result<(), WorkflowError> {
    let is_empty = std::fs::read_dir(folder).map_or(true, |mut files| files.next().is_none());
    let is_simulated =
        is_simulated_manifest(&folder.join(MANIFEST_FILE)) && folder.join(TRUTH_FILE).is_file();
    if !(force || is_empty || is_simulated) {
        let problem = "the folder holds files that no simulation wrote; remove them, or choose \
                       another --out (simulate --force writes beside them)";
        return Err(WorkflowError::file(folder, problem));
    }
    Ok(())
}

impl SimulatedScan {
    /// Writes a scan folder: manifest, images, calibrations, and the truth for scoring. All files
    /// appear together, in place of older ones.
    ///
    /// # Errors
    /// [`WorkflowError`] naming the file that cannot be written.
    pub fn write(
        &self,
        scene: &PreparedScene,
        images: StripeImages,
        folder: &Path,
    ) -> Result<(), WorkflowError> {
        let staging = Staging::begin(folder)?;
        self.write_into(scene, images, staging.path())?;
        staging.commit().map(drop)
    }

    fn write_into(
        &self,
        scene: &PreparedScene,
        images: StripeImages,
        folder: &Path,
    ) -> Result<(), WorkflowError> {
        let mut entries = Vec::new();
        for (k, (placed, view)) in self.instruments.iter().zip(&self.views).enumerate() {
            if let SensorEntry::LookupTable(entry) = &placed.instrument.entry {
                let sweeps = &placed.instrument.calibration;
                write_file(&folder.join(&entry.calibration), |out| write_calibration(sweeps, out))?;
            }
            entries.push(write_view(scene, placed, view, (k, images), folder)?);
        }
        let description = &scene.description;
        let mut manifest = Manifest::new(description.name.clone(), entries);
        manifest.unit = Some(description.unit);
        manifest.sigma = sigma(&self.views, images);
        manifest.planes = Some(PlanesEntry::from(&description.planes));
        manifest.size = Some(scene.bounds.size());
        write_file(&folder.join(MANIFEST_FILE), |out| write_manifest(&manifest, SIMULATE, out))?;
        let Mesh { vertices, faces } = scene.truth.clone();
        let truth = TriangleMesh { vertices, faces };
        write_file(&folder.join(TRUTH_FILE), |out| write_truth(&truth, out))?;
        Ok(())
    }
}

/// The camera of a light-stripe sensor: 8 bits in a dim room. Its stripe is four cells wide at half
/// its height of 180 counts. The values are chosen by hand, as a camera with a clear stripe has
/// them.
pub fn stripe_camera(columns: usize, seed: u64) -> StripeCamera {
    StripeCamera {
        columns,
        depth: BitDepth::Eight,
        width: 4.0,
        peak: 180.0,
        background: 20.0,
        speckle: 0.15,
        read_noise: 2.0,
        seed,
    }
}

/// The largest noise of the views. It is unknown where intensity images are written.
fn sigma(views: &[View], images: StripeImages) -> Option<f64> {
    match images {
        StripeImages::Extracted => views.iter().filter_map(View::sigma).reduce(f64::max),
        StripeImages::Seen(_) => None,
    }
}

/// Writes a view's image, and gives its entry in the manifest.
fn write_view(
    scene: &PreparedScene,
    placed: &PlacedInstrument,
    view: &View,
    (k, images): (usize, StripeImages),
    folder: &Path,
) -> Result<ViewEntry, WorkflowError> {
    let size = view.image().size();
    let mut sensor = placed.instrument.entry.clone();
    let file = match (images, &mut sensor) {
        (StripeImages::Seen(camera), SensorEntry::LightStripe(entry)) => {
            entry.stripe = Some(stripe_entry(&camera));
            write_stack(scene, placed, (k, &camera), folder)?
        }
        _ => {
            let file = format!("range_{k:03}.npy");
            let values = values(view.image());
            write_file(&folder.join(&file), |out| write_npy_image(size, &values, out))?;
            file
        }
    };
    let (stated, true_pose) = (view.world_from_sensor(), &placed.instrument.world_from_sensor);
    let mut entry = ViewEntry::new(file, sensor, row_major(stated));
    (entry.rows, entry.cols) = (Some(size.rows), Some(size.cols));
    entry.pose_true = (stated != true_pose).then(|| row_major(true_pose));
    Ok(entry)
}

/// Writes the intensity images of a light-stripe sensor.
fn write_stack(
    scene: &PreparedScene,
    placed: &PlacedInstrument,
    (k, camera): (usize, &StripeCamera),
    folder: &Path,
) -> Result<String, WorkflowError> {
    let Some(frame) = &placed.instrument.light_stripe else {
        return Err(WorkflowError::Simulation(
            "only light-stripe sensors have intensity images".to_owned(),
        ));
    };
    let camera = StripeCamera { columns: frame.parameters().camera_cols, ..*camera };
    // Values count from the array's edge, columns from the first one's centre.
    let column = |_: Pixel, d3: f64| Some(d3 - 0.5);
    let pose = &placed.instrument.world_from_sensor;
    let stack = scene.scene.stripe_images(frame, pose, &camera, &column, k as u64)?;
    let counts = match &stack.counts {
        StripeCounts::Eight(all) => Counts::Eight(all),
        StripeCounts::Sixteen(all) => Counts::Sixteen(all),
    };
    let file = format!("stripes_{k:03}.npy");
    write_file(&folder.join(&file), |out| write_npy_stack(stack.steps, stack.size, counts, out))?;
    Ok(file)
}

/// The stripe that the reader searches: on a surface that returns 40 % of the light, or at least
/// 10 %.
fn stripe_entry(camera: &StripeCamera) -> StripeEntry {
    StripeEntry {
        // A triangle as high and as wide at half its height reaches twice as far.
        width: 2.0 * camera.width,
        height: Some(0.4 * camera.peak),
        least_height: Some(0.1 * camera.peak),
        ..StripeEntry::default()
    }
}

fn values(image: &RangeImage) -> Vec<f32> {
    (0..image.size().rows).flat_map(|row| image.row(row).iter().copied()).collect()
}
