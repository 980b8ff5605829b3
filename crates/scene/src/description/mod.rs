//! The scene file: what stands where, who looks at it, and where the section planes are.
//!
//! ```toml
//! name = "example"
//! unit = "m"                      # of every length here: m, dm, cm, mm, um, in, ft
//!
//! [planes]                        # plane k is normal · p = offset + k · interval
//! normal = [0, 0, 1]
//! offset = 0.05
//! interval = 0.1
//!
//! [noise]                         # optional, like each of its keys
//! sigma = 0.002                   # along the ray
//! dropout = 0.02                  # share of the pixels
//! max_incidence = 85              # degrees
//! seed = 1
//!
//! [[solid]]
//! name = "pillar"                 # optional
//! shape = "cylinder"              # radius, height (axis z); or "ball": radius; or "box": size
//! radius = 0.2
//! height = 2.8
//! at = [4, 3, 1.4]                # the solid's centre
//! rotate = { axis = [0, 0, 1], degrees = 30 }   # optional, about the centre
//!
//! [[station]]
//! name = "corner"                 # optional
//! sensor = "spherical"            # or "pinhole", with field_of_view (degrees, across all columns)
//! rows = 400
//! cols = 400
//! theta = [50, -50]               # degrees about the upright axis, from left to right here
//! phi = [50, -50]                 # degrees of elevation, from top to bottom here
//! at = [0.3, 0.3, 1.4]
//! heading = 40                    # degrees from x towards y; and tilt, degrees upwards
//! # look_at = [3, 2.5, 1]         # instead of heading and tilt
//! ```
//!
//! An angular range is divided into equal pixels, each sampled at its centre: a full circle needs
//! no care. Meshes cannot be named here, since this crate reads no files: add them to
//! [`Description::solids`].

mod check;
mod solid;
mod station;

pub use check::{DescriptionError, Problem};
pub use station::{SensorParameters, Station};

use crate::{Noise, Scene, Solid};
use check::Place;
use serde::Deserialize;
use std::f64::consts::FRAC_PI_2;
use transect_geometry::{GuideError, LengthUnit, PlaneFamily, StraightGuide, Vector3};

/// A scene description that has been checked.
#[derive(Debug, Clone)]
pub struct Description {
    /// What the scene is called.
    pub name: String,
    /// The unit of every length in it.
    pub unit: LengthUnit,
    /// The section planes.
    pub planes: PlaneFamily,
    /// What stands there, in the order of the file.
    pub solids: Vec<Solid>,
    /// Where it is seen from, in the order of the file; a view's number is its place here.
    pub stations: Vec<Station>,
    /// What the sensors do to the ranges.
    pub noise: Noise,
}

impl Description {
    /// Reads a description from TOML text.
    ///
    /// # Errors
    /// [`DescriptionError::Syntax`] for broken TOML and unknown keys, with line and key;
    /// [`DescriptionError::Invalid`] with one problem per faulty entry, each naming its key.
    ///
    /// ```
    /// let room = transect_scene::Description::parse(transect_scene::BUNDLED_ROOM).unwrap();
    /// assert_eq!(room.stations.len(), 4);
    /// ```
    pub fn parse(toml: &str) -> Result<Self, DescriptionError> {
        let file: File = toml::from_str(toml)?;
        let mut problems = Vec::new();
        let mut keep = |problem: Problem| problems.push(problem);
        let planes = file.planes.build().map_err(&mut keep).ok();
        let noise = file.noise.build().map_err(&mut keep).ok();
        let mut solids = Vec::new();
        for (index, entry) in file.solid.into_iter().enumerate() {
            solids.extend(entry.build(index).map_err(&mut keep));
        }
        let mut stations = Vec::new();
        for (index, entry) in file.station.into_iter().enumerate() {
            stations.extend(entry.build(index).map_err(&mut keep));
        }
        match (planes, noise) {
            (Some(planes), Some(noise)) if problems.is_empty() => {
                let File { name, unit, .. } = file;
                Ok(Self { name, unit, planes, solids, stations, noise })
            }
            _ => Err(DescriptionError::Invalid(problems)),
        }
    }

    /// The union of the solids, ready for rays.
    pub fn scene(&self) -> Scene {
        Scene::new(self.solids.clone())
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    unit: LengthUnit,
    planes: PlanesEntry,
    #[serde(default)]
    noise: NoiseEntry,
    #[serde(default)]
    solid: Vec<solid::SolidEntry>,
    #[serde(default)]
    station: Vec<station::StationEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanesEntry {
    normal: [f64; 3],
    offset: f64,
    interval: f64,
}

impl PlanesEntry {
    fn build(&self) -> Result<PlaneFamily, Problem> {
        let family = StraightGuide::along(Vector3::from(self.normal))
            .and_then(|guide| PlaneFamily::new(guide, self.offset, self.interval));
        family.map_err(|error| {
            let key = match error {
                GuideError::BadInterval(_) => "interval",
                GuideError::BadOffset(_) => "offset",
                _ => "normal",
            };
            Place::new("planes").problem(key, error)
        })
    }
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct NoiseEntry {
    sigma: Option<f64>,
    dropout: Option<f64>,
    max_incidence: Option<f64>,
    seed: Option<u64>,
}

impl NoiseEntry {
    fn build(&self) -> Result<Noise, Problem> {
        let place = Place::new("noise");
        let within = |key, value: Option<f64>, most: f64, wanted| {
            place.value(key, value.unwrap_or(0.0), |v| (0.0..=most).contains(&v), wanted)
        };
        let sigma = within("sigma", self.sigma, f64::MAX, "a length of at least 0")?;
        let dropout = within("dropout", self.dropout, 1.0, "a share from 0 to 1")?;
        let degrees = self.max_incidence.or(Some(90.0));
        let degrees = within("max_incidence", degrees, 90.0, "degrees from 0 to 90")?;
        // 90° exactly means no limit, whatever the rounding of the conversion.
        let max_incidence = if degrees < 90.0 { degrees.to_radians() } else { FRAC_PI_2 };
        Ok(Noise { sigma, dropout, max_incidence, seed: self.seed.unwrap_or(0) })
    }
}

#[cfg(test)]
mod tests;
