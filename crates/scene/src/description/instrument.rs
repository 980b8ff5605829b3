//! `[light_stripe]` and `[lookup_table]`: the triangulation scanners of a scene, at their true
//! size.
//!
//! Every key is optional. What is not given is the dissertation's: SmartEye (4.6.1) and HYSCAN
//! (4.7.1), whose lengths are millimetres, in the scene's unit.

use super::check::{Place, Problem};
use super::sensor::{SensorParameters, centres};
use serde::Deserialize;
use transect_device::ImageSize;
use transect_geometry::LengthUnit;
use transect_sensors::lookup_table::{
    CarriedScanner, LinearSteps, SynchronizedScanner, ThetaSteps,
};
use transect_sensors::{LaserAngles, LightStripeParameters, LookupTable, SensorError};

/// Rows of the lookup table's image, unless a station states them. Chosen by hand: with
/// [`HYSCAN_STEP`] the scanner is carried as far as its field is wide.
const HYSCAN_ROWS: usize = 256;

/// Way of the scanner on the machine from row to row, in millimetres. Chosen by hand: the distance
/// of two beams at the far end of the field, so that pixels are square there. Doubled, details
/// across the rows are twice as coarse.
const HYSCAN_STEP: f64 = 0.39;

/// Both tables.
pub(super) struct Instruments {
    pub light_stripe: LightStripeTable,
    pub lookup_table: LookupTableTable,
    pub unit: LengthUnit,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct LightStripeTable {
    theta: Option<[f64; 2]>,
    fan_angle: Option<f64>,
    baseline: Option<f64>,
    farthest: Option<f64>,
    camera_cols: Option<usize>,
    focal_length: Option<f64>,
    cell_width: Option<f64>,
    cell_height: Option<f64>,
    mirror_axis: Option<f64>,
    mirror_face: Option<f64>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct LookupTableTable {
    theta: Option<[f64; 2]>,
    depth: Option<[f64; 2]>,
    baseline: Option<f64>,
    step: Option<f64>,
}

impl Instruments {
    /// The rows and columns of a light-stripe image: camera rows and laser angles.
    pub fn light_stripe_size() -> [usize; 2] {
        let example = LightStripeParameters::smart_eye();
        [example.camera_rows, example.theta_laser.as_radians().len()]
    }

    /// The rows and columns of a lookup table's image: places on the linear axis and beams.
    pub fn lookup_table_size() -> [usize; 2] {
        [HYSCAN_ROWS, LookupTable::hyscan_columns().count()]
    }

    /// Scene units in a millimetre.
    fn millimetre(&self) -> f64 {
        1e-3 / self.unit.in_metres()
    }

    /// The light-stripe sensor with an image of this size, which divides the same field.
    pub fn light_stripe(&self, size: ImageSize) -> Result<SensorParameters, Problem> {
        let (place, table) = (Place::new("light_stripe"), &self.light_stripe);
        let example = LightStripeParameters::smart_eye().scaled(self.millimetre());
        let length = |key, given: Option<f64>, usual| place.length(key, given.unwrap_or(usual));
        let angles = match table.theta {
            Some(range) => range,
            None => outer(example.theta_laser.as_radians()),
        };
        for angle in angles {
            place.value("theta", angle, |a| a > 0.0 && a < 180.0, "between 0 and 180 degrees")?;
        }
        let (first, step) = centres(&place, "theta", angles, size.cols)?;
        let fan = table.fan_angle.unwrap_or(example.fan_angle.to_degrees());
        let between = |a: f64| a > 0.0 && a < 180.0;
        let fan = place.value("fan_angle", fan, between, "between 0 and 180 degrees")?;
        let camera_cols = table.camera_cols.unwrap_or(example.camera_cols);
        let array_height = example.cell_height * example.camera_rows as f64;
        let cell_height = array_height / size.rows as f64;
        let parameters = LightStripeParameters {
            camera_rows: size.rows,
            camera_cols,
            focal_length: length("focal_length", table.focal_length, example.focal_length)?,
            cell_width: length("cell_width", table.cell_width, example.cell_width)?,
            cell_height: length("cell_height", table.cell_height, cell_height)?,
            x_center: 0.5 * camera_cols as f64,
            y_center: 0.5 * (size.rows as f64 - 1.0),
            baseline: length("baseline", table.baseline, example.baseline)?,
            mirror_axis: length("mirror_axis", table.mirror_axis, example.mirror_axis)?,
            mirror_face: length("mirror_face", table.mirror_face, example.mirror_face)?,
            fan_angle: fan.to_radians(),
            farthest: length("farthest", table.farthest, example.farthest)?,
            theta_laser: LaserAngles::from_radians(
                (0..size.cols).map(|k| first + k as f64 * step).collect(),
            ),
        };
        checked(&place, SensorParameters::LightStripe(parameters), size)
    }

    /// The lookup table with an image of this size; its beams divide the same field.
    pub fn lookup_table(&self, size: ImageSize) -> Result<SensorParameters, Problem> {
        let (place, table) = (Place::new("lookup_table"), &self.lookup_table);
        let mm = self.millimetre();
        let hyscan = SynchronizedScanner::hyscan();
        let base = place.length("baseline", table.baseline.unwrap_or(hyscan.base * mm))?;
        let depths = table.depth.unwrap_or(CarriedScanner::HYSCAN_DEPTHS.map(|d| d * mm));
        for depth in depths {
            place.length("depth", depth)?;
        }
        let range = match table.theta {
            Some(range) => range,
            None => {
                let beams = LookupTable::hyscan_columns();
                outer(&(0..beams.count()).map(|k| beams.angle(k)).collect::<Vec<_>>())
            }
        };
        let (first, step) = centres(&place, "theta", range, size.cols)?;
        let dy = place.length("step", table.step.unwrap_or(HYSCAN_STEP * mm))?;
        let rows = LinearSteps::new(-0.5 * dy * (size.rows as f64 - 1.0), dy, size.rows);
        let scanner = CarriedScanner {
            scanner: SynchronizedScanner { base, ..hyscan },
            columns: ThetaSteps::from_radians(first, step, size.cols),
            depths,
            rows,
        };
        checked(&place, SensorParameters::LookupTable(scanner), size)
    }
}

/// The range, in degrees, that equal steps between pixel centres divide.
fn outer(radians: &[f64]) -> [f64; 2] {
    let (first, last) = (radians.first().unwrap_or(&0.0), radians.last().unwrap_or(&0.0));
    let half = 0.5 * (last - first) / (radians.len().max(2) - 1) as f64;
    [(first - half).to_degrees(), (last + half).to_degrees()]
}

/// A sensor that can be made.
fn checked(
    place: &Place,
    sensor: SensorParameters,
    size: ImageSize,
) -> Result<SensorParameters, Problem> {
    match sensor.frame(size) {
        Ok(_) => Ok(sensor),
        Err(SensorError::BadParameter { key, value, wanted }) => {
            // Scene files state all angles as one range in degrees.
            let (key, value) = match key {
                "theta" | "theta0" | "dtheta" | "theta_laser" => ("theta", value.to_degrees()),
                "dy" => ("step", value),
                _ => (key, value),
            };
            Err(place.problem(key, format_args!("{value} is not {wanted}")))
        }
        Err(error) => Err(place.problem("rows", error)),
    }
}
