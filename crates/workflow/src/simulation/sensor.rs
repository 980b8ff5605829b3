//! The sensors of a simulation: the dissertation's three, and a depth camera.

use super::placing::{BoundedField, Standpoint};
use crate::WorkflowError;
use std::f64::consts::PI;
use std::str::FromStr;
use std::sync::Arc;
use transect_device::{DeviceFrame, ImageSize};
use transect_exchange::{LightStripeEntry, LookupTableEntry, SensorEntry, ViewpointsEntry};
use transect_geometry::{Isometry3, Point3};
use transect_scene::SensorParameters;
use transect_sensors::lookup_table::{
    CalibrationOptions, CalibrationSweep, CarriedScanner, LinearSteps, ScanPlane,
};
use transect_sensors::{Intrinsics, LaserAngles, LightStripe, LightStripeParameters, SensorError};

/// A kind of sensor, by the name that scan manifests give it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorKind {
    /// Terrestrial scanner: two angles and a range.
    Spherical,
    /// Depth camera.
    Pinhole,
    /// Laser sheet and camera; the dissertation's range finder, scaled to the scene.
    LightStripe,
    /// Calibrated line scanner on a linear axis; the dissertation's, scaled to the scene.
    LookupTable,
}

impl SensorKind {
    /// Every kind, in the order of the documentation's tables.
    pub const ALL: [Self; 4] =
        [Self::Spherical, Self::LightStripe, Self::LookupTable, Self::Pinhole];

    /// Its name in scan manifests.
    pub fn name(self) -> &'static str {
        match self {
            Self::Spherical => "spherical",
            Self::Pinhole => "pinhole",
            Self::LightStripe => "light_stripe",
            Self::LookupTable => "lookup_table",
        }
    }
}

impl FromStr for SensorKind {
    type Err = WorkflowError;

    fn from_str(name: &str) -> Result<Self, WorkflowError> {
        let names = || Self::ALL.map(Self::name).join(", ");
        let unknown =
            || WorkflowError::setting("sensor", format!("{name:?} is none of {}", names()));
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(unknown)
    }
}

/// A sensor that turns a scene into a view: device frame, manifest entry and pose.
#[derive(Debug, Clone)]
pub struct Instrument {
    /// The device frame.
    pub frame: Arc<dyn DeviceFrame>,
    /// Kind and parameters, for the manifest.
    pub entry: SensorEntry,
    /// Where it stands.
    pub world_from_sensor: Isometry3,
    /// Its size as a multiple of the dissertation's instrument, whose lengths are millimetres;
    /// `None` for sensors that are not scaled.
    pub scale: Option<f64>,
    /// The calibration of a lookup table; the entry names its file.
    pub calibration: Vec<CalibrationSweep>,
    /// The light-stripe sensor in `frame`, which knows where its camera sees the stripe.
    pub light_stripe: Option<LightStripe>,
}

impl Instrument {
    fn plain(
        frame: Arc<dyn DeviceFrame>,
        entry: SensorEntry,
        world_from_sensor: Isometry3,
    ) -> Self {
        let (calibration, light_stripe) = (Vec::new(), None);
        Self { frame, entry, world_from_sensor, scale: None, calibration, light_stripe }
    }

    /// A scene's own sensor.
    ///
    /// # Errors
    /// [`SensorError`] if the parameters make no sensor.
    pub fn own(
        size: ImageSize,
        sensor: &SensorParameters,
        world_from_sensor: Isometry3,
        calibration_file: &str,
    ) -> Result<Self, SensorError> {
        let entry = match sensor {
            &SensorParameters::Spherical { theta0, dtheta, phi0, dphi } => {
                SensorEntry::Spherical { theta0, dtheta, phi0, dphi }
            }
            &SensorParameters::Pinhole { fx, fy, cx, cy } => {
                SensorEntry::pinhole(Intrinsics { fx, fy, cx, cy })
            }
            SensorParameters::LightStripe(parameters) => {
                return Self::light_stripe(parameters.clone(), world_from_sensor);
            }
            SensorParameters::LookupTable(scanner) => {
                return Self::lookup_table(scanner, world_from_sensor, calibration_file);
            }
        };
        Ok(Self::plain(sensor.frame(size)?, entry, world_from_sensor))
    }

    fn light_stripe(
        parameters: LightStripeParameters,
        world_from_sensor: Isometry3,
    ) -> Result<Self, SensorError> {
        let frame = LightStripe::new(parameters)?;
        let entry = SensorEntry::LightStripe(LightStripeEntry::new(frame.parameters(), None));
        let light_stripe = Some(frame.clone());
        Ok(Self { light_stripe, ..Self::plain(Arc::new(frame), entry, world_from_sensor) })
    }

    fn lookup_table(
        scanner: &CarriedScanner,
        world_from_sensor: Isometry3,
        calibration_file: &str,
    ) -> Result<Self, SensorError> {
        let (columns, viewpoints) = (scanner.columns, scanner.scanner.viewpoints());
        let entry = SensorEntry::LookupTable(LookupTableEntry {
            theta0: columns.angle(0),
            dtheta: columns.angle(1) - columns.angle(0),
            calibration: calibration_file.to_owned(),
            median_window: CalibrationOptions::EXACT.median_window,
            pairs: CalibrationOptions::EXACT.pairs,
            y0: scanner.rows.place(0.0),
            dy: scanner.rows.step(),
            mounting: ScanPlane::Xz,
            tilt: 0.0,
            viewpoints: Some(ViewpointsEntry {
                projector: viewpoints.projector.into(),
                receiver: viewpoints.receiver.into(),
            }),
        });
        let plain = Self::plain(Arc::new(scanner.table()?), entry, world_from_sensor);
        Ok(Self { calibration: scanner.sweeps(), ..plain })
    }

    /// A sensor of a kind at a standpoint; `density` multiplies its rows and columns.
    pub fn chosen(
        kind: SensorKind,
        at: &Standpoint,
        density: f64,
        calibration_file: &str,
    ) -> Result<Self, SensorError> {
        match kind {
            SensorKind::Spherical => spherical(at, density),
            SensorKind::Pinhole => pinhole(at, density),
            SensorKind::LightStripe => light_stripe(at, density),
            SensorKind::LookupTable => lookup_table(at, density, calibration_file),
        }
    }
}

fn counts(rows: f64, cols: f64, density: f64) -> ImageSize {
    let count = |n: f64| (n * density).round().max(2.0) as usize;
    ImageSize { rows: count(rows), cols: count(cols) }
}

/// An object in 400 × 400 pixels, or the full circle inside a scene, 60° up and down.
fn spherical(at: &Standpoint, density: f64) -> Result<Instrument, SensorError> {
    let (size, (wide, high)) = match at.half_angle() {
        Some(half) => (counts(400.0, 400.0, density), (half, half)),
        None => (counts(267.0, 800.0, density), (PI, PI / 3.0)),
    };
    // From left to right and from top to bottom, each pixel sampled at its centre.
    let (dtheta, dphi) = (-2.0 * wide / size.cols as f64, -2.0 * high / size.rows as f64);
    let (theta0, phi0) = (wide + 0.5 * dtheta, high + 0.5 * dphi);
    let sensor = SensorParameters::Spherical { theta0, dtheta, phi0, dphi };
    Instrument::own(size, &sensor, at.place_scanner(), "")
}

/// An object in 480 × 360 pixels, or 70° × 55° inside a scene.
fn pinhole(at: &Standpoint, density: f64) -> Result<Instrument, SensorError> {
    let size = counts(360.0, 480.0, density);
    let half = match at.half_angle() {
        Some(half) => half.tan() * size.cols as f64 / size.rows as f64,
        None => 35_f64.to_radians().tan(),
    };
    let focal = 0.5 * size.cols as f64 / half;
    let centre = |n: usize| 0.5 * (n as f64 - 1.0);
    let (cx, cy) = (centre(size.cols), centre(size.rows));
    let sensor = SensorParameters::Pinhole { fx: focal, fy: focal, cx, cy };
    Instrument::own(size, &sensor, at.place_camera(), "")
}

/// Of [`LightStripeParameters::smart_eye`]: 735 mm ahead, where its field is 205 mm high; its laser
/// is 320 mm beside its camera.
const SMART_EYE_FIELD: BoundedField =
    BoundedField { middle: Point3::new(0.0, 0.0, 735.0), radius: 102.0, size: 320.0 };

/// The dissertation's range finder: 494 rows, 200 laser angles.
fn light_stripe(at: &Standpoint, density: f64) -> Result<Instrument, SensorError> {
    let scale = at.scale(&SMART_EYE_FIELD);
    let example = LightStripeParameters::smart_eye();
    let rows = counts(494.0, 200.0, density).rows;
    // The same field in more or fewer rows and angles.
    let steps = (199.0 * density).round().max(1.0);
    let theta_laser =
        LaserAngles::equal_steps_degrees(58.0, 199.0 * 0.09 / steps, steps as usize + 1);
    let parameters = LightStripeParameters {
        camera_rows: rows,
        cell_height: example.cell_height * 494.0 / rows as f64,
        y_center: 0.5 * (rows as f64 - 1.0),
        theta_laser,
        ..example
    };
    let pose = at.place_field(&SMART_EYE_FIELD, scale);
    let instrument = Instrument::light_stripe(parameters.scaled(scale), pose)?;
    Ok(Instrument { scale: Some(scale), ..instrument })
}

/// Of [`CarriedScanner::hyscan`]: half its depth, and 77 mm wide there; its mirrors are 30 mm to
/// the left and right, and it is carried 38 mm up and down.
const HYSCAN_FIELD: BoundedField =
    BoundedField { middle: Point3::new(-6.75, 0.0, 155.0), radius: 38.0, size: 50.0 };

/// The dissertation's scanner, carried 256 steps past the object.
fn lookup_table(
    at: &Standpoint,
    density: f64,
    calibration_file: &str,
) -> Result<Instrument, SensorError> {
    let scale = at.scale(&HYSCAN_FIELD);
    let size = counts(256.0, 256.0, density);
    let length = 2.0 * HYSCAN_FIELD.radius * scale;
    let rows = LinearSteps::new(-0.5 * length, length / (size.rows as f64 - 1.0), size.rows);
    let example = CarriedScanner::hyscan(rows).scaled(scale);
    let scanner = CarriedScanner { columns: example.columns.with_count(size.cols), ..example };
    let pose = at.place_field(&HYSCAN_FIELD, scale);
    let instrument = Instrument::lookup_table(&scanner, pose, calibration_file)?;
    Ok(Instrument { scale: Some(scale), ..instrument })
}
