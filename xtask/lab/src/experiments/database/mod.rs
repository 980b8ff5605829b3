//! The promises of the model database, measured: areas and volumes, inside and outside, size.

mod large;
mod solids;
mod space;

use super::lab::Lab;
use super::trial;
use crate::failure::Failure;
use transect_device::View;
use transect_scene::Description;
use transect_workflow::simulation::{PreparedScene, SensorPlan};

/// Options of `experiments database`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// One part only [default: all].
    #[arg(value_enum)]
    part: Option<Part>,
    /// Planes of the large store; 2000 make ten million fused nodes and a file of 2.6 GB.
    #[arg(long, default_value_t = 200, value_name = "NUMBER", value_parser = clap::value_parser!(i64).range(50..))]
    planes: i64,
    /// Folder for the large store [default: the system's folder for temporary files].
    #[arg(long, value_name = "DIR")]
    folder: Option<std::path::PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Part {
    /// How far are areas and volumes of simulated solids from the exact ones?
    Solids,
    /// How often is the answer for a point wrong, and how often unknown?
    Space,
    /// What does a store cost that is larger than memory?
    Large,
}

/// Runs the experiments.
pub fn run(arguments: &Arguments, lab: &Lab) -> Result<(), Failure> {
    let asked = |part| arguments.part.is_none_or(|only| only == part);
    if asked(Part::Solids) {
        solids::run(lab)?;
    }
    if asked(Part::Space) {
        space::run(lab)?;
    }
    if asked(Part::Large) {
        let folder = arguments.folder.clone().unwrap_or_else(std::env::temp_dir);
        large::run(&folder, arguments.planes, lab)?;
    }
    Ok(())
}

/// Solids without surroundings, seen from all sides and from below, without noise.
struct Surrounded {
    scene: PreparedScene,
    views: Vec<View>,
}

/// Distance of the stations from the middle, in millimetres.
const DISTANCE: f64 = 400.0;
const PIXELS: usize = 300;
const FIELD_DEG: f64 = 40.0;
const STATIONS: usize = 24;

/// Distance between samples on a surface that faces a station from the middle, in millimetres.
fn footprint() -> f64 {
    2.0 * DISTANCE * (0.5 * FIELD_DEG).to_radians().tan() / PIXELS as f64
}

/// Prepares solids, in inline tables of a scene file, in millimetres around the origin.
fn surround(solids: &str) -> Result<Surrounded, Failure> {
    let mut text = format!(
        "name = \"solids\"\nunit = \"mm\"\nsolid = [{solids}]\n\
         planes = {{ normal = [0, 0, 1], offset = 0.3, interval = 4 }}\n"
    );
    for k in 0..STATIONS {
        // Points of a spiral, evenly spread over the ball.
        let z = 1.0 - (2.0 * k as f64 + 1.0) / STATIONS as f64;
        let (sin, cos) = (k as f64 * 2.399_963).sin_cos();
        let ring = DISTANCE * (1.0 - z * z).sqrt();
        text += &trial::camera([ring * cos, ring * sin, DISTANCE * z], PIXELS, FIELD_DEG);
    }
    let scene = PreparedScene::new(Description::parse(&text)?)?;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    Ok(Surrounded { scene, views })
}
