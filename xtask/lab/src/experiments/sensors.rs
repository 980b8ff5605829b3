//! Accuracy of every sensor on every bundled scene, without noise, through the whole pipeline.

use super::lab::Lab;
use super::trial;
use crate::failure::Failure;
use crate::table::{cells, length, say, share};
use transect_scene::{BUNDLED_SCENES, SensorParameters};
use transect_workflow::simulation::{PreparedScene, SensorKind, SensorPlan};

/// Options of `experiments sensors`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Only this bundled scene.
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// Only this sensor.
    #[arg(long, value_name = "SENSOR")]
    sensor: Option<SensorKind>,
    /// Factor on the sensors' rows and columns.
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR")]
    density: f64,
}

/// Runs the experiment.
pub fn run(arguments: &Arguments, lab: &Lab) -> Result<(), Failure> {
    let chosen = |name: &str| arguments.scene.as_ref().is_none_or(|s| s == name);
    let mut lines = Vec::new();
    for (name, _) in BUNDLED_SCENES.iter().filter(|(name, _)| chosen(name)) {
        let scene = trial::bundled_without_noise(name)?;
        // Scenes of scanners at their true size are made for these.
        if let Some(kind) = true_size(&scene) {
            if arguments.sensor.is_none_or(|s| s == kind) {
                lines.push(line(&scene, kind, SensorPlan::OWN)?);
            }
            continue;
        }
        for kind in SensorKind::ALL {
            if arguments.sensor.is_none_or(|s| s == kind) {
                eprintln!("{name}, {}", kind.name());
                let plan = SensorPlan { density: arguments.density, ..SensorPlan::with(kind) };
                lines.push(line(&scene, kind, plan)?);
            }
        }
    }
    let heads = "scene | sensor | views | pixels | median | p95 | complete % | oriented % | unit";
    lab.table("table", heads, lines)?;
    say("Distances from the true sections, noise-free, on what the views could see.");
    Ok(())
}

/// The kind of a scene's own triangulation scanners.
fn true_size(scene: &PreparedScene) -> Option<SensorKind> {
    scene.description.stations.iter().find_map(|station| match station.sensor {
        SensorParameters::LightStripe(_) => Some(SensorKind::LightStripe),
        SensorParameters::LookupTable(_) => Some(SensorKind::LookupTable),
        _ => None,
    })
}

fn line(scene: &PreparedScene, kind: SensorKind, plan: SensorPlan) -> Result<Vec<String>, Failure> {
    let views = scene.simulate(&plan)?.views;
    let (_, accuracy) = trial::scored(scene, &views, &trial::setup(scene))?;
    let (name, unit) = (&scene.description.name, scene.description.unit.symbol());
    let (kind, count, pixels) = (kind.name(), views.len(), trial::pixels(&views));
    let [median, p95] = [accuracy.median, accuracy.p95].map(length);
    let [complete, oriented] = [accuracy.completeness, accuracy.oriented].map(share);
    Ok(cells(&format!(
        "{name} | {kind} | {count} | {pixels} | {median} | {p95} | {complete} | {oriented} | {unit}"
    )))
}
