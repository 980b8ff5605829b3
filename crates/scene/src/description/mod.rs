//! The scene file: solids, stations and section planes.
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
//! sigma_growth = 0.0005           # grows it with range: sigma + sigma_growth · range
//! sigma_square = 0.0015           # and with its square, per length unit; of disparities
//! correlation = 4                 # pixels at which the errors' correlation is 1/e, 0 to 100
//! quantum = 0.001                 # step of the stored values
//! dropout = 0.02                  # share of the pixels
//! max_incidence = 85              # degrees
//! full_return = 0.2               # reflectivity · cos(incidence) that always gives a range
//! mixed = 0.3                     # share of the pixels at range jumps that lie in between
//! depth_camera = { base_line = 0.075, disparity_step = 0.125, shuffle = 0.5, distortion = 0.006 }
//! pose = { degrees = 0.05, shift = 0.003 }      # spread of the stated poses, each key optional
//! seed = 1
//!
//! [materials]                     # optional; without a material a solid reflects all light
//! plaster = { reflectivity = 0.8 }
//!
//! [[solid]]
//! name = "pillar"                 # optional
//! shape = "cylinder"              # see below
//! radius = 0.2
//! height = 2.8
//! material = "plaster"            # optional
//! at = [4, 3, 1.4]                # the solid's centre
//! rotate = { axis = [0, 0, 1], degrees = 30 }   # optional, about the centre
//! stations = [0, 2]               # optional: it is there for these alone, and not in the truth
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
//!
//! [[station]]
//! sensor = "lookup_table"         # or "light_stripe"; rows and cols are optional
//! at = [0.3, 0.1, 1.4]
//! look_at = [0.3, 0.25, 1.4]
//!
//! [lookup_table]                  # the scanner of all these stations; each key is optional
//! step = 0.0005
//! ```
//!
//! `light_stripe` and `lookup_table` are the dissertation's SmartEye and HYSCAN, **at their true
//! size** in any unit; they are not scaled to the scene. Their frames have z forward and y down.
//! x runs from the laser to the camera, and across the beams. All stations of a kind share one
//! instrument. Its table changes it; angles are in degrees:
//!
//! | table, sensor | key | default | meaning |
//! |---|---|---|---|
//! | `light_stripe` | `theta` | 57.955, 75.955 | range of the laser angle, divided into the columns |
//! | | `fan_angle` | 60 | of the line lens |
//! | | `baseline` | 300 mm | from the mirror's axis to the camera |
//! | | `farthest` | 2000 mm | largest distance along z at which the stripe is seen |
//! | | `camera_cols` | 768 | cells of a camera row; the station's `rows` are its rows |
//! | | `focal_length` | 16 mm | |
//! | | `cell_width` | 0.0084 mm | |
//! | | `cell_height` | 4.84 mm / rows | |
//! | | `mirror_axis`, `mirror_face` | 16 mm, 20 mm | place of the mirror's axis and face |
//! | `lookup_table` | `theta` | −5.76, 21.86 | range of the beams, divided into the columns |
//! | | `depth` | 110 mm, 200 mm | nearest and farthest calibrated depth |
//! | | `baseline` | 60 mm | between the two mirrors |
//! | | `step` | 0.39 mm | way on the linear axis from row to row; the station is its middle |
//!
//! Every error is off unless it is given. Those of `depth_camera`
//! ([`DepthCamera`](crate::DepthCamera)) act on `pinhole` stations alone. With them, or with
//! `correlation`, views state no sigma:
//!
//! | key of `depth_camera` | unit, range | meaning |
//! |---|---|---|
//! | `base_line` | length, from 0 | distance of the projector, to the right; places without its light are missing |
//! | `disparity_step` | pixels, 0 to 100 | depths have steps of `disparity_step · depth² / (base_line · focal length in pixels)`; needs a `base_line` |
//! | `shuffle` | pixels, 0 to 100 | spread of the place that a pixel measures |
//! | `distortion` | share, 0 to 1 | root mean square of a smooth relative depth error that all views share |
//!
//! | `shape` | its keys | where it is |
//! |---|---|---|
//! | `"box"` | `size = [x, y, z]` | edges along the axes |
//! | `"pyramid"` | `size = [x, y, height]` | tip up the z axis |
//! | `"cylinder"` | `radius`, `height` | axis z |
//! | `"cone"` | `radius`, `height` | axis z, tip up |
//! | `"frustum"` | `radius`, `top_radius`, `height` | axis z: a truncated cone |
//! | `"ball"` | `radius` | |
//! | `"torus"` | `radius`, `tube` | around z; `tube` is the radius of the tube |
//! | `"prism"` | `bottom = [[x, y], ...]`, `height`, `top` | between two polygons of as many corners, perpendicular to z; `top` is like `bottom` unless given |
//! | `"mesh"` | `mesh = "name.stl"` | its own coordinates |
//!
//! `at` is the solid's centre: of a prism the middle of its height at its polygons' origin, of a
//! mesh its coordinates' origin.
//!
//! An angular range is divided into equal pixels, each sampled at its centre: a full circle needs
//! no care. This crate reads no files: the meshes that a description names
//! ([`Description::mesh_names`]) are handed to [`Description::parse_with_meshes`]. Names that
//! begin with `builtin:` are those of [`fixtures`](crate::fixtures) and need no file.

mod check;
mod instrument;
mod sensor;
mod solid;
mod station;

pub use check::{DescriptionError, Problem};
pub use sensor::SensorParameters;
pub use station::Station;

use crate::{DepthCamera, Mesh, Noise, PoseNoise, Scene, Solid, fixtures};
use check::Place;
use instrument::{Instruments, LightStripeTable, LookupTableTable};
use serde::Deserialize;
use solid::{Library, MaterialEntry, SolidEntry};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use transect_geometry::{
    CurvedGuide, Guide, GuideError, LengthUnit, PlaneFamily, StraightGuide, Vector3,
};

/// A scene description that has been checked.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Description {
    /// The scene's name.
    pub name: String,
    /// The unit of every length in it.
    pub unit: LengthUnit,
    /// The section planes.
    pub planes: PlaneFamily,
    /// The solids that stay, in the order of the file.
    pub solids: Vec<Solid>,
    /// The solids that are there while some stations measure, such as people who walk by.
    pub visitors: Vec<Visitor>,
    /// The stations, in the order of the file. The number of a view is its place in this list.
    pub stations: Vec<Station>,
    /// The errors of the sensors.
    pub noise: Noise,
}

/// A solid that is not always there. It is no part of the truth.
#[derive(Debug, Clone)]
pub struct Visitor {
    /// The solid.
    pub solid: Solid,
    /// Numbers of the stations that see it.
    pub stations: Vec<usize>,
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
        Self::parse_with_meshes(toml, &BTreeMap::new())
    }

    /// Reads a description whose solids may be meshes. The meshes are given by their names.
    ///
    /// # Errors
    /// As [`Description::parse`]; a mesh that is missing or does not bound a solid is a problem of
    /// the solid's key `mesh`.
    pub fn parse_with_meshes(
        toml: &str,
        meshes: &BTreeMap<String, Mesh>,
    ) -> Result<Self, DescriptionError> {
        let file: File = toml::from_str(toml)?;
        let mut problems = Vec::new();
        let mut keep = |problem: Problem| {
            // Stations with one instrument have its problems in common.
            if !problems.contains(&problem) {
                problems.push(problem);
            }
        };
        let planes = file.planes.build().map_err(&mut keep).ok();
        let noise = file.noise.build().map_err(&mut keep).ok();
        for (name, entry) in &file.materials {
            let _ = entry.check(name).map_err(&mut keep);
        }
        let File { light_stripe, lookup_table, unit, .. } = file;
        let instruments = Instruments { light_stripe, lookup_table, unit };
        let library = Library { meshes, materials: &file.materials };
        let (mut solids, mut visitors) = (Vec::new(), Vec::new());
        for (index, entry) in file.solid.into_iter().enumerate() {
            let visit = entry.visit(index, file.station.len()).map_err(&mut keep).ok().flatten();
            let solid = entry.build(index, &library).map_err(&mut keep);
            match visit {
                None => solids.extend(solid),
                Some(stations) => visitors.extend(solid.map(|solid| Visitor { solid, stations })),
            }
        }
        let mut stations = Vec::new();
        for (index, entry) in file.station.into_iter().enumerate() {
            stations.extend(entry.build(index, &instruments).map_err(&mut keep));
        }
        match (planes, noise) {
            (Some(planes), Some(noise)) if problems.is_empty() => {
                Ok(Self { name: file.name, unit, planes, solids, visitors, stations, noise })
            }
            _ => Err(DescriptionError::Invalid(problems)),
        }
    }

    /// The meshes that a description names, each once, in alphabetical order: what its reader has
    /// to find before [`Description::parse_with_meshes`]. Built-in ones are not among them.
    ///
    /// # Errors
    /// [`DescriptionError::Syntax`] for broken TOML and unknown keys.
    pub fn mesh_names(toml: &str) -> Result<Vec<String>, DescriptionError> {
        let file: File = toml::from_str(toml)?;
        let named = file.solid.into_iter().filter_map(|entry| entry.mesh);
        let mut names: Vec<_> =
            named.filter(|name| !name.starts_with(fixtures::BUILT_IN)).collect();
        names.sort_unstable();
        names.dedup();
        Ok(names)
    }

    /// The union of the solids that stay, ready for rays.
    pub fn scene(&self) -> Scene {
        Scene::new(self.solids.clone())
    }

    /// The same with what is there while a station measures; `None` if nothing else is.
    pub fn visited_scene(&self, station: usize) -> Option<Scene> {
        let there = self.visitors.iter().filter(|visitor| visitor.stations.contains(&station));
        let visitors: Vec<Solid> = there.map(|visitor| visitor.solid.clone()).collect();
        (!visitors.is_empty()).then(|| Scene::new([self.solids.clone(), visitors].concat()))
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
    light_stripe: LightStripeTable,
    #[serde(default)]
    lookup_table: LookupTableTable,
    #[serde(default)]
    materials: BTreeMap<String, MaterialEntry>,
    #[serde(default)]
    solid: Vec<SolidEntry>,
    #[serde(default)]
    station: Vec<station::StationEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanesEntry {
    /// Either the normal or a guide is needed.
    normal: Option<[f64; 3]>,
    guide: Option<CurvedGuide>,
    offset: f64,
    interval: f64,
}

impl PlanesEntry {
    fn build(self) -> Result<PlaneFamily, Problem> {
        let place = Place::new("planes");
        let guide = match (self.guide, self.normal) {
            (Some(_), Some(_)) => {
                let problem = "it means nothing beside a guide; leave out one of the two";
                return Err(place.problem("normal", problem));
            }
            (Some(guide), None) => Ok(guide.into()),
            (None, Some(normal)) => StraightGuide::along(Vector3::from(normal)).map(Guide::from),
            (None, None) => return Err(place.problem("normal", "it is missing, and so is a guide")),
        };
        let offset = place.value("offset", self.offset, |_| true, "a number")?;
        let interval = place.value("interval", self.interval, |_| true, "a number")?;
        let family = guide.and_then(|guide| PlaneFamily::new(guide, offset, interval));
        family.map_err(|error| {
            let key = match error {
                GuideError::BadInterval(_) => "interval",
                GuideError::BadOffset(_) => "offset",
                _ => "normal",
            };
            place.problem(key, error)
        })
    }
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct NoiseEntry {
    sigma: Option<f64>,
    sigma_growth: Option<f64>,
    sigma_square: Option<f64>,
    correlation: Option<f64>,
    quantum: Option<f64>,
    dropout: Option<f64>,
    max_incidence: Option<f64>,
    full_return: Option<f64>,
    mixed: Option<f64>,
    #[serde(default)]
    depth_camera: CameraEntry,
    #[serde(default)]
    pose: PoseEntry,
    seed: Option<u64>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct CameraEntry {
    base_line: Option<f64>,
    disparity_step: Option<f64>,
    shuffle: Option<f64>,
    distortion: Option<f64>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct PoseEntry {
    degrees: Option<f64>,
    shift: Option<f64>,
}

impl NoiseEntry {
    fn build(&self) -> Result<Noise, Problem> {
        let place = Place::new("noise");
        let within = |key, value: Option<f64>, most: f64, wanted| {
            place.value(key, value.unwrap_or(0.0), |v| (0.0..=most).contains(&v), wanted)
        };
        let length = |key, value| within(key, value, f64::MAX, "a length of at least 0");
        let share = |key, value| within(key, value, 1.0, "a share from 0 to 1");
        let pixels = |key, value| within(key, value, 100.0, "from 0 to 100 pixels");
        let camera = &self.depth_camera;
        let depth_camera = DepthCamera {
            base_line: length("depth_camera.base_line", camera.base_line)?,
            disparity_step: pixels("depth_camera.disparity_step", camera.disparity_step)?,
            shuffle: pixels("depth_camera.shuffle", camera.shuffle)?,
            distortion: share("depth_camera.distortion", camera.distortion)?,
        };
        if depth_camera.disparity_step > 0.0 && depth_camera.base_line == 0.0 {
            let problem = "disparities need a base_line of more than 0";
            return Err(place.problem("depth_camera.disparity_step", problem));
        }
        let degrees = self.max_incidence.or(Some(90.0));
        let degrees = within("max_incidence", degrees, 90.0, "degrees from 0 to 90")?;
        let turn = within("pose.degrees", self.pose.degrees, 180.0, "degrees from 0 to 180")?;
        Ok(Noise {
            sigma: length("sigma", self.sigma)?,
            sigma_growth: share("sigma_growth", self.sigma_growth)?,
            sigma_square: length("sigma_square", self.sigma_square)?,
            correlation: pixels("correlation", self.correlation)?,
            quantum: within("quantum", self.quantum, f64::MAX, "a step of at least 0")?,
            dropout: share("dropout", self.dropout)?,
            // Exactly 90° means no limit, independent of the rounding of the conversion.
            max_incidence: if degrees < 90.0 { degrees.to_radians() } else { FRAC_PI_2 },
            full_return: share("full_return", self.full_return)?,
            mixed: share("mixed", self.mixed)?,
            depth_camera,
            pose: PoseNoise { degrees: turn, shift: length("pose.shift", self.pose.shift)? },
            seed: self.seed.unwrap_or(0),
        })
    }
}

#[cfg(test)]
mod tests;
