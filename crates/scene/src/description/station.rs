//! `[[station]]` entries: sensors and their places.

use super::check::{Place, Problem};
use super::instrument::Instruments;
use super::sensor::{SensorParameters, centres};
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion};
use serde::Deserialize;
use std::sync::Arc;
use transect_device::{DeviceFrame, ImageSize, MAX_PIXELS};
use transect_geometry::{Isometry3, Point3, Vector3};
use transect_sensors::SensorError;

/// A sensor at a place.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Station {
    /// Its name; unnamed stations are `station 1`, `station 2` and so on.
    pub name: String,
    /// Rows and columns of its image.
    pub size: ImageSize,
    /// The rays of its pixels.
    pub sensor: SensorParameters,
    /// Its pose.
    pub world_from_sensor: Isometry3,
}

impl Station {
    /// Its device frame.
    ///
    /// # Errors
    /// [`SensorError`] if the parameters, or their number of pixels, make no sensor.
    pub fn frame(&self) -> Result<Arc<dyn DeviceFrame>, SensorError> {
        self.sensor.frame(self.size)
    }
}

/// One table for all sensors, so that every wrong key can be named.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StationEntry {
    name: Option<String>,
    sensor: SensorName,
    rows: Option<usize>,
    cols: Option<usize>,
    theta: Option<[f64; 2]>,
    phi: Option<[f64; 2]>,
    field_of_view: Option<f64>,
    at: [f64; 3],
    heading: Option<f64>,
    tilt: Option<f64>,
    look_at: Option<[f64; 3]>,
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "snake_case")]
enum SensorName {
    Spherical,
    Pinhole,
    LightStripe,
    LookupTable,
}

impl StationEntry {
    /// The station that an entry describes.
    pub fn build(self, index: usize, instruments: &Instruments) -> Result<Station, Problem> {
        let place = Place::entry("station", index, self.name.as_deref());
        let size = self.size(&place)?;
        let sensor = match self.sensor {
            SensorName::Spherical => self.spherical(&place, size)?,
            SensorName::Pinhole => self.pinhole(&place, size)?,
            SensorName::LightStripe | SensorName::LookupTable => {
                self.scanner(&place, size, instruments)?
            }
        };
        let world_from_sensor = self.pose(&place)?;
        let name = self.name.unwrap_or_else(|| format!("station {}", index + 1));
        Ok(Station { name, size, sensor, world_from_sensor })
    }

    fn size(&self, place: &Place) -> Result<ImageSize, Problem> {
        let [rows, cols] = match self.sensor {
            SensorName::Spherical | SensorName::Pinhole => [None; 2],
            SensorName::LightStripe => Instruments::light_stripe_size().map(Some),
            SensorName::LookupTable => Instruments::lookup_table_size().map(Some),
        };
        let rows = place.needed("rows", self.rows.or(rows), "station")?;
        let cols = place.needed("cols", self.cols.or(cols), "station")?;
        let reason = format!(
            "an image has at least one row and column and at most 2^{} pixels",
            MAX_PIXELS.ilog2()
        );
        if cols == 0 {
            return Err(place.problem("cols", reason));
        }
        match rows.checked_mul(cols) {
            Some(1..=MAX_PIXELS) => Ok(ImageSize { rows, cols }),
            _ => Err(place.problem("rows", reason)),
        }
    }

    fn spherical(&self, place: &Place, size: ImageSize) -> Result<SensorParameters, Problem> {
        place.refuse("field_of_view", self.field_of_view.is_some(), "spherical sensor")?;
        let theta = place.needed("theta", self.theta, "spherical sensor")?;
        let phi = place.needed("phi", self.phi, "spherical sensor")?;
        for angle in phi {
            place.value(
                "phi",
                angle,
                |a| a.abs() <= 90.0,
                "an elevation from -90 to 90 degrees",
            )?;
        }
        let (theta0, dtheta) = centres(place, "theta", theta, size.cols)?;
        let (phi0, dphi) = centres(place, "phi", phi, size.rows)?;
        Ok(SensorParameters::Spherical { theta0, dtheta, phi0, dphi })
    }

    fn pinhole(&self, place: &Place, size: ImageSize) -> Result<SensorParameters, Problem> {
        place.refuse("theta", self.theta.is_some(), "pinhole")?;
        place.refuse("phi", self.phi.is_some(), "pinhole")?;
        let degrees = place.needed("field_of_view", self.field_of_view, "pinhole")?;
        let possible = |a: f64| a > 0.0 && a < 180.0;
        place.value("field_of_view", degrees, possible, "between 0 and 180 degrees")?;
        let (rows, cols) = (size.rows as f64, size.cols as f64);
        let focal_length = 0.5 * cols / (0.5 * degrees).to_radians().tan();
        let (cx, cy) = (0.5 * (cols - 1.0), 0.5 * (rows - 1.0));
        Ok(SensorParameters::Pinhole { fx: focal_length, fy: focal_length, cx, cy })
    }

    /// The scene's triangulation scanner. Its own table states its field.
    fn scanner(
        &self,
        place: &Place,
        size: ImageSize,
        instruments: &Instruments,
    ) -> Result<SensorParameters, Problem> {
        let stripe = self.sensor == SensorName::LightStripe;
        let kind = if stripe {
            "station with light_stripe; the table [light_stripe] has its field"
        } else {
            "station with lookup_table; the table [lookup_table] has its field"
        };
        place.refuse("theta", self.theta.is_some(), kind)?;
        place.refuse("phi", self.phi.is_some(), kind)?;
        place.refuse("field_of_view", self.field_of_view.is_some(), kind)?;
        if stripe { instruments.light_stripe(size) } else { instruments.lookup_table(size) }
    }

    fn pose(&self, place: &Place) -> Result<Isometry3, Problem> {
        let at: Point3 = place.triple("at", self.at)?;
        let (heading, tilt) = match self.look_at {
            None => (self.angle(place, "heading")?, self.angle(place, "tilt")?),
            Some(target) => {
                place.refuse("heading", self.heading.is_some(), "station with look_at")?;
                place.refuse("tilt", self.tilt.is_some(), "station with look_at")?;
                self.aim(place, place.triple::<Point3>("look_at", target)? - at)?
            }
        };
        let rotation = match self.sensor {
            // Heading about the upright axis, after the tilt that lifts x towards z.
            SensorName::Spherical => {
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading)
                    * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -tilt)
            }
            _ => camera(heading, tilt),
        };
        Ok(Isometry3::from_parts(Translation3::from(at.coords), rotation))
    }

    fn angle(&self, place: &Place, key: &'static str) -> Result<f64, Problem> {
        let degrees = if key == "heading" { self.heading } else { self.tilt };
        let degrees = place.value(key, degrees.unwrap_or(0.0), |_| true, "a finite angle")?;
        Ok(degrees.to_radians())
    }

    /// Heading and tilt towards a target. A scanner stays upright and only turns towards it.
    fn aim(&self, place: &Place, towards: Vector3) -> Result<(f64, f64), Problem> {
        let level = towards.x.hypot(towards.y);
        let heading = towards.y.atan2(towards.x);
        match self.sensor {
            SensorName::Spherical if level > 0.0 => Ok((heading, 0.0)),
            _ if self.sensor != SensorName::Spherical && towards.norm() > 0.0 => {
                Ok((heading, towards.z.atan2(level)))
            }
            _ => Err(place.problem("look_at", "it gives no direction from `at`")),
        }
    }
}

/// Rotation of a camera (x right, y down, z forward) that looks along a heading and a tilt.
fn camera(heading: f64, tilt: f64) -> UnitQuaternion<f64> {
    let forward = Vector3::new(tilt.cos() * heading.cos(), tilt.cos() * heading.sin(), tilt.sin());
    let right = Vector3::new(heading.sin(), -heading.cos(), 0.0);
    let axes = Matrix3::from_columns(&[right, forward.cross(&right), forward]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
}
