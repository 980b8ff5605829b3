//! Pictures of scanned points and their models, after the dissertation's Figures 4.11 to 4.20.

pub mod charts;

use super::output::Output;
use super::trial;
use crate::failure::Failure;
use crate::table::say;
use std::path::Path;
use transect_device::{Pixel, View};
use transect_exchange::svg::{OverviewOptions, write_overview, write_points};
use transect_exchange::write_file;
use transect_geometry::Point3;
use transect_workflow::simulation::{PreparedScene, SensorKind, SensorPlan};

/// The sensors shown, each with its scene, and azimuth and elevation of the observer in degrees.
const SHOWN: [(SensorKind, &str, (f64, f64)); 4] = [
    (SensorKind::Spherical, "room", (-60.0, 35.0)),
    (SensorKind::LightStripe, "face_mask", (-65.0, 20.0)),
    (SensorKind::LookupTable, "face_mask", (-65.0, 20.0)),
    (SensorKind::Pinhole, "machined_part", (-60.0, 30.0)),
];

/// Largest number of points drawn of a scan. Chosen by hand; doubled, the pictures take twice the
/// space.
const POINTS: usize = 8000;

/// Runs the experiment.
pub fn run(out: &Output) -> Result<(), Failure> {
    let out = out.folder()?;
    for (kind, scene, view) in SHOWN {
        let scene = trial::bundled_without_noise(scene)?;
        scan_and_model(&scene, kind, view, out)?;
        if kind == SensorKind::LightStripe {
            let placed = scene.instruments(&SensorPlan::with(kind))?;
            charts::stripe_row(&scene, &placed, &out.join("light_stripe-row.svg"))?;
        }
    }
    charts::calibration(out)?;
    say(&format!("pictures in {}", out.display()));
    Ok(())
}

/// The points that the first view scanned, and the model of all views.
fn scan_and_model(
    scene: &PreparedScene,
    kind: SensorKind,
    (azimuth_deg, elevation_deg): (f64, f64),
    folder: &Path,
) -> Result<(), Failure> {
    // The room's own stations are scanners that look into it from its corners.
    let plan = if kind == SensorKind::Spherical { SensorPlan::OWN } else { SensorPlan::with(kind) };
    let outcome = trial::run(scene, &plan)?;
    let (description, name) = (&scene.description, kind.name());
    let options = |what: &str| {
        let mut options = OverviewOptions::default();
        options.title = format!("{}: {what}", description.name);
        (options.azimuth_deg, options.elevation_deg) = (azimuth_deg, elevation_deg);
        (options.width, options.height) = (1000.0, 760.0);
        options
    };
    let points = outcome.views.first().map(scanned).unwrap_or_default();
    let seen = format!("{} of the points that one view of the {name} sensor scanned", points.len());
    let (planes, unit) = (&description.planes, description.unit);
    write_file(&folder.join(format!("{name}-points.svg")), |out| {
        write_points(&points, planes, unit, &seen, &options("scanned points"), out)
    })?;
    write_file(&folder.join(format!("{name}-model.svg")), |out| {
        write_overview(&outcome.model, &options("cross-section model"), out)
    })?;
    Ok(())
}

/// Points of a view on a coarser grid, in the world.
pub fn scanned(view: &View) -> Vec<Point3> {
    let size = view.image().size();
    let valid = view.image().valid_count() as f64;
    let step = ((valid / POINTS as f64).sqrt().ceil() as usize).max(1);
    let pixels = (0..size.rows)
        .step_by(step)
        .flat_map(|row| (0..size.cols).step_by(step).map(move |col| Pixel::new(row, col)));
    pixels.filter_map(|p| view.point_in_sensor(p)).map(|p| view.world_from_sensor() * p).collect()
}
