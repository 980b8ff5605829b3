//! Pictures of scanned points and their models, after the dissertation's Figures 4.11 to 4.20.

mod charts;

use super::lab::Lab;
use super::trial;
use crate::failure::Failure;
use crate::table::say;
use transect_device::{Pixel, View};
use transect_exchange::svg::{OverviewOptions, write_overview, write_points};
use transect_geometry::Point3;
use transect_workflow::simulation::{PreparedScene, SensorKind, SensorPlan};

/// A sensor with the bundled scene that it scans, at its own size.
pub struct Shown {
    pub sensor: SensorKind,
    pub scene: &'static str,
    /// Azimuth and elevation of the observer in degrees.
    pub observer: (f64, f64),
}

/// The dissertation's scanners.
pub const SCANNERS: [Shown; 3] = [
    Shown { sensor: SensorKind::Spherical, scene: "room", observer: (-60.0, 35.0) },
    Shown { sensor: SensorKind::LightStripe, scene: "smart_eye_jug", observer: (-65.0, 20.0) },
    Shown { sensor: SensorKind::LookupTable, scene: "hyscan_mask", observer: (-65.0, 20.0) },
];

/// A sensor that the dissertation does not have.
const CAMERA: Shown =
    Shown { sensor: SensorKind::Pinhole, scene: "machined_part", observer: (-60.0, 30.0) };

/// Largest number of points drawn of a scan. Chosen by hand; doubled, the pictures take twice the
/// space.
const POINTS: usize = 8000;

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    for shown in SCANNERS.iter().chain([&CAMERA]) {
        let scene = trial::bundled_without_noise(shown.scene)?;
        scan_and_model(&scene, shown, lab)?;
        if shown.sensor == SensorKind::LightStripe {
            let placed = scene.instruments(&SensorPlan::OWN)?;
            let figure = charts::stripe_row(&scene, &placed)?;
            lab.picture("light_stripe-row", |file| figure.write(file))?;
        }
    }
    for (name, figure) in charts::calibration() {
        lab.picture(name, |file| figure.write(file))?;
    }
    say(&format!("pictures in {}", lab.folder()?.display()));
    Ok(())
}

/// The points that the first view scanned, and the model of all views.
fn scan_and_model(scene: &PreparedScene, shown: &Shown, lab: &Lab) -> Result<(), Failure> {
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let (description, name) = (&scene.description, shown.sensor.name());
    let options = |what: &str| observed(&format!("{}: {what}", description.name), shown.observer);
    let points = views.first().map(scanned).unwrap_or_default();
    let seen = format!("{} of the points that one view of the {name} sensor scanned", points.len());
    let (planes, unit) = (&description.planes, description.unit);
    lab.picture(&format!("{name}-points"), |out| {
        write_points(&points, planes, unit, &seen, &options("scanned points"), out)
    })?;
    let model = trial::scene_model(scene, &views)?;
    lab.picture(&format!("{name}-model"), |out| {
        write_overview(&model, &options("cross-section model"), out)
    })
}

/// An overview with a title, from an azimuth and an elevation in degrees.
pub fn observed(title: &str, (azimuth_deg, elevation_deg): (f64, f64)) -> OverviewOptions {
    let mut options = OverviewOptions::default();
    title.clone_into(&mut options.title);
    (options.azimuth_deg, options.elevation_deg) = (azimuth_deg, elevation_deg);
    (options.width, options.height) = (1000.0, 760.0);
    options
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
