//! Simulated scans: a scene, seen by its own sensors or by others of the reader's choice.
//!
//! [`Plan`] says which sensors and how many views, [`instruments`] places them, [`views`] casts
//! their rays, [`write()`] makes a scan folder of what they saw.

mod placing;
mod scan_folder;
mod sensor;

pub use placing::Surroundings;
pub use scan_folder::{StripeImages, write};
pub use sensor::{Instrument, SensorKind};

use crate::WorkflowError;
use placing::{Standpoint, round};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};
use transect_device::{View, ViewError};
use transect_exchange::{TriangleMesh, read_mesh};
use transect_scene::{BUNDLED_SCENES, CastError, Description, Mesh, Scene};

/// Largest distance between a curved solid and its truth mesh, as a share of the plane interval:
/// well below anything a simulated scanner resolves.
const CHORD_SHARE: f64 = 1e-3;

/// Which sensors look at a scene.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// Instead of the scene's own.
    pub sensor: Option<SensorKind>,
    /// How many; as many as the scene has stations if not said.
    pub views: Option<usize>,
    /// Factor on rows and columns of chosen sensors; the scene's own have the size that they have.
    pub density: f64,
}

impl Plan {
    /// The scene's own sensors.
    pub const OWN: Self = Self { sensor: None, views: None, density: 1.0 };

    /// A kind of sensor, as dense as it usually is, at the scene's own stations.
    pub fn with(sensor: SensorKind) -> Self {
        Self { sensor: Some(sensor), ..Self::OWN }
    }
}

/// A description with its scene made.
pub struct Stage {
    /// What was described.
    pub description: Description,
    /// Ready for rays.
    pub scene: Scene,
    /// Its surface.
    pub truth: Mesh,
    /// Where that is.
    pub around: Surroundings,
}

impl Stage {
    /// Makes the scene of a description.
    pub fn set(description: Description) -> Result<Self, WorkflowError> {
        let scene = description.scene();
        let truth = scene.mesh(CHORD_SHARE * description.planes.interval())?;
        let around = Surroundings::of(&truth);
        Ok(Self { description, scene, truth, around })
    }
}

/// Reads a scene file with the meshes beside it, or takes a bundled scene.
pub fn describe(scene: &Path) -> Result<Description, WorkflowError> {
    let bundled = BUNDLED_SCENES.iter().find(|(name, _)| Path::new(name) == scene);
    let text = match bundled {
        Some((_, text)) => (*text).to_owned(),
        None => std::fs::read_to_string(scene).map_err(WorkflowError::io(scene))?,
    };
    let folder = scene.parent().unwrap_or(Path::new(""));
    let names = Description::mesh_names(&text).map_err(|e| WorkflowError::file(scene, e))?;
    let mut meshes = BTreeMap::new();
    for name in names {
        let TriangleMesh { vertices, faces } = read_mesh(&folder.join(&name))?.mesh;
        meshes.insert(name, Mesh { vertices, faces });
    }
    let description = Description::parse_with_meshes(&text, &meshes);
    description.map_err(|e| WorkflowError::file(scene, e))
}

/// A view to be: what it is called and what takes it.
pub struct Placed {
    /// As the station is called, with the round's number after the first.
    pub name: String,
    /// What takes it.
    pub instrument: Instrument,
}

/// The sensors of a plan, placed.
pub fn instruments(stage: &Stage, plan: &Plan) -> Result<Vec<Placed>, WorkflowError> {
    let (description, around) = (&stage.description, &stage.around);
    let count = plan.views.unwrap_or(description.stations.len());
    let place = |view: usize| -> Result<Placed, WorkflowError> {
        let (own, turned) = round(description, around, view);
        let Some(station) = description.stations.get(own) else {
            return Err(WorkflowError::simulation("the scene has no station to place a sensor at"));
        };
        let instrument = match plan.sensor {
            None => {
                let pose = turned * station.world_from_sensor;
                Instrument::own(station.size, &station.sensor, pose)?
            }
            Some(kind) => {
                let at = Standpoint::of(station, &turned, &stage.scene, around);
                Instrument::chosen(kind, &at, plan.density, &scan_folder::calibration_file(view))?
            }
        };
        let again = view / description.stations.len();
        let name = if again == 0 {
            station.name.clone()
        } else {
            format!("{}, turned {again} times", station.name)
        };
        Ok(Placed { name, instrument })
    };
    (0..count).map(place).collect()
}

/// What the sensors saw.
pub struct Seen {
    /// The sensors that saw anything, in their order.
    pub placed: Vec<Placed>,
    /// What each of them saw.
    pub views: Vec<View>,
    /// The names of those that saw nothing at all.
    pub blind: Vec<String>,
    /// Rays cast: one per pixel.
    pub rays: usize,
    /// Time of all views, each on one core.
    pub time: Duration,
}

/// Casts the rays of all sensors, with the noise of the scene's description.
///
/// # Errors
/// A sensor's, or that none saw anything.
pub fn views(stage: &Stage, placed: Vec<Placed>) -> Result<Seen, WorkflowError> {
    let noise = &stage.description.noise;
    let view = |(k, p): (usize, &Placed)| {
        let start = Instant::now();
        let Instrument { frame, world_from_sensor, .. } = &p.instrument;
        let view =
            stage.scene.view(p.name.clone(), frame.clone(), *world_from_sensor, noise, k as u64);
        (view, start.elapsed())
    };
    let cast: Vec<(Result<View, CastError>, Duration)> =
        placed.par_iter().enumerate().map(view).collect();
    let rays = placed.iter().map(|p| p.instrument.frame.size().pixels()).sum();
    let time = cast.iter().map(|c| c.1).sum();
    let mut seen = Seen { placed: Vec::new(), views: Vec::new(), blind: Vec::new(), rays, time };
    for (placed, (view, _)) in placed.into_iter().zip(cast) {
        match view {
            Ok(view) => {
                seen.placed.push(placed);
                seen.views.push(view);
            }
            Err(CastError::View(ViewError::NoValidPixel)) => seen.blind.push(placed.name),
            Err(e) => return Err(WorkflowError::simulation(format!("view {}: {e}", placed.name))),
        }
    }
    if seen.views.is_empty() {
        return Err(WorkflowError::simulation("no sensor sees anything of the scene"));
    }
    Ok(seen)
}
