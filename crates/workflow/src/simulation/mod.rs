//! Simulated scans: a scene, seen by its own sensors or by others of the user's choice.
//!
//! 1. [`describe`] reads a scene file; [`PreparedScene::new`] makes its surface.
//! 2. [`PreparedScene::simulate`] places the sensors of a [`SensorPlan`] and casts their rays.
//! 3. [`SimulatedScan::write`] writes a scan folder with the truth.

mod placing;
mod scan_folder;
mod sensor;

pub use placing::SceneBounds;
pub use scan_folder::{StripeImages, claim_scan_folder, stripe_camera};
pub use sensor::{Instrument, SensorKind};

use crate::WorkflowError;
use placing::{Standpoint, station_of_view};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};
use transect_device::{View, ViewError};
use transect_exchange::{TriangleMesh, read_mesh, read_text};
use transect_scene::{BUNDLED_SCENES, CastError, Description, Mesh, Scene};

/// Largest distance between a curved solid and the mesh of its surface, as a share of the plane
/// interval. Chosen by hand: far below the noise of every simulated sensor. Doubled, the
/// truth of curved solids is off by twice as much.
const CHORD_SHARE: f64 = 1e-3;

/// The sensors that look at a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorPlan {
    /// Kind of all sensors. Without it, the scene's own sensors.
    pub sensor: Option<SensorKind>,
    /// Number of views. Without it, one per station of the scene.
    pub views: Option<usize>,
    /// Factor on rows and columns of chosen sensors; the scene's own sensors keep their size.
    pub density: f64,
}

impl SensorPlan {
    /// The scene's own sensors.
    pub const OWN: Self = Self { sensor: None, views: None, density: 1.0 };

    /// Sensors of a kind at the scene's own stations, of their usual density.
    pub fn with(sensor: SensorKind) -> Self {
        Self { sensor: Some(sensor), ..Self::OWN }
    }
}

/// Reads a scene file with the meshes beside it, or takes a bundled scene by its name.
///
/// # Errors
/// [`WorkflowError`] naming the file that cannot be read or understood.
pub fn describe(scene: &Path) -> Result<Description, WorkflowError> {
    let bundled = BUNDLED_SCENES.iter().find(|(name, _)| Path::new(name) == scene);
    let text = match bundled {
        Some((_, text)) => (*text).to_owned(),
        None => read_text(scene)?,
    };
    let folder = scene.parent().unwrap_or(Path::new(""));
    let unusable = || WorkflowError::unusable(scene, "the scene cannot be used");
    let names = Description::mesh_names(&text).map_err(unusable())?;
    let mut meshes = BTreeMap::new();
    for name in names {
        let TriangleMesh { vertices, faces } = read_mesh(&folder.join(&name))?.mesh;
        meshes.insert(name, Mesh { vertices, faces });
    }
    let description = Description::parse_with_meshes(&text, &meshes);
    description.map_err(unusable())
}

/// A scene that is ready for sensors.
#[derive(Debug)]
pub struct PreparedScene {
    /// The content of the scene file.
    pub description: Description,
    /// The solids, ready for rays.
    pub scene: Scene,
    /// The true surface.
    pub truth: Mesh,
    /// The space that the surface takes.
    pub bounds: SceneBounds,
}

/// A sensor in its place.
#[derive(Debug)]
pub struct PlacedInstrument {
    /// Name of its view: the station's, with the number of turns after the first round.
    pub name: String,
    /// The sensor.
    pub instrument: Instrument,
}

/// The views of a simulation.
#[derive(Debug)]
pub struct SimulatedScan {
    /// The sensors that saw anything, in order.
    pub instruments: Vec<PlacedInstrument>,
    /// Their views.
    pub views: Vec<View>,
    /// The names of sensors that saw nothing of the scene.
    pub blind: Vec<String>,
    /// Rays that were cast: one per pixel.
    pub rays: usize,
    /// Time of all views, each on one core.
    pub time: Duration,
}

impl PreparedScene {
    /// Makes the solids and the surface of a description.
    ///
    /// # Errors
    /// [`WorkflowError::Scene`] if the surface would have too many faces.
    pub fn new(description: Description) -> Result<Self, WorkflowError> {
        let scene = description.scene();
        let truth = scene.mesh(CHORD_SHARE * description.planes.interval())?;
        let bounds = SceneBounds::of(&truth);
        Ok(Self { description, scene, truth, bounds })
    }

    /// Places the sensors of a plan.
    ///
    /// # Errors
    /// [`WorkflowError`] if the scene has no station, or a sensor cannot be made.
    pub fn instruments(&self, plan: &SensorPlan) -> Result<Vec<PlacedInstrument>, WorkflowError> {
        let count = plan.views.unwrap_or(self.description.stations.len());
        (0..count).map(|view| self.instrument(plan, view)).collect()
    }

    fn instrument(
        &self,
        plan: &SensorPlan,
        view: usize,
    ) -> Result<PlacedInstrument, WorkflowError> {
        let stations = &self.description.stations;
        let (own, turned) = station_of_view(&self.description, &self.bounds, view);
        let Some(station) = stations.get(own) else {
            let problem = "the scene has no station to place a sensor at; add a [[station]]";
            return Err(WorkflowError::Simulation(problem.to_owned()));
        };
        let file = scan_folder::calibration_file(view);
        let instrument = match plan.sensor {
            None => {
                let pose = turned * station.world_from_sensor;
                Instrument::own(station.size, &station.sensor, pose, &file)?
            }
            Some(kind) => {
                let at = Standpoint::of(station, &turned, &self.scene, &self.bounds);
                Instrument::chosen(kind, &at, plan.density, &file)?
            }
        };
        let name = match view / stations.len() {
            0 => station.name.clone(),
            turns => format!("{}, turned {turns} times", station.name),
        };
        Ok(PlacedInstrument { name, instrument })
    }

    /// Places the sensors of a plan and casts their rays, with the noise of the description.
    ///
    /// # Errors
    /// [`WorkflowError`] if a sensor cannot be made, or no sensor sees anything.
    pub fn simulate(&self, plan: &SensorPlan) -> Result<SimulatedScan, WorkflowError> {
        let placed = self.instruments(plan)?;
        let (noise, stations) = (&self.description.noise, self.description.stations.len());
        let view = |(k, p): (usize, &PlacedInstrument)| {
            let start = Instant::now();
            let Instrument { frame, world_from_sensor, .. } = &p.instrument;
            let (name, frame) = (p.name.clone(), frame.clone());
            let visited = self.description.visited_scene(k % stations.max(1));
            let scene = visited.as_ref().unwrap_or(&self.scene);
            (scene.view(name, frame, *world_from_sensor, noise, k as u64), start.elapsed())
        };
        let cast: Vec<(Result<View, CastError>, Duration)> =
            placed.par_iter().enumerate().map(view).collect();
        let rays = placed.iter().map(|p| p.instrument.frame.size().pixels()).sum();
        let time = cast.iter().map(|c| c.1).sum();
        let (mut instruments, mut views, mut blind) = (Vec::new(), Vec::new(), Vec::new());
        for (placed, (view, _)) in placed.into_iter().zip(cast) {
            match view {
                Ok(view) => {
                    instruments.push(placed);
                    views.push(view);
                }
                Err(CastError::View(ViewError::NoValidPixel)) => blind.push(placed.name),
                Err(source) => {
                    return Err(WorkflowError::SimulatedView { view: placed.name, source });
                }
            }
        }
        if views.is_empty() {
            let problem = "no sensor sees anything of the scene; check its stations";
            return Err(WorkflowError::Simulation(problem.to_owned()));
        }
        Ok(SimulatedScan { instruments, views, blind, rays, time })
    }
}
