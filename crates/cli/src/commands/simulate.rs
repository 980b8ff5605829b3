//! `transect simulate`: a scan folder of a simulated scene, with its truth.

use super::named;
use crate::failure::Failure;
use crate::notes;
use crate::table::{Row, digits, print};
use std::path::{Path, PathBuf};
use transect_device::Note;
use transect_exchange::MANIFEST_FILE;
use transect_scene::{Description, Noise, SensorParameters};
use transect_workflow::default_folder;
use transect_workflow::simulation::{
    PreparedScene, SensorKind, SensorPlan, StripeImages, claim_scan_folder, describe, stripe_camera,
};

/// Options of `simulate`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Scene file (TOML), or a bundled scene: room, face_mask, machined_part, thin_sheet, tunnel,
    /// bend_tunnel, kitchen, hyscan_mask or smart_eye_jug.
    #[arg(default_value = "room")]
    scene: PathBuf,
    /// Sensor at all stations, in place of the scene's own.
    #[arg(long, value_parser = named(SensorKind::ALL.map(|kind| (kind.name(), kind))))]
    sensor: Option<SensorKind>,
    /// Number of views; views beyond the number of stations are turned copies [default: one per
    /// station].
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(1..))]
    views: Option<u16>,
    /// Factor on the rows and columns of the sensor that --sensor chooses.
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR", requires = "sensor")]
    density: f64,
    /// Write the camera images of light-stripe sensors, in which the reader finds the stripe, in
    /// place of range images.
    #[arg(long)]
    stripe_images: bool,
    /// Folder to write scan.json, the images and truth.npz into [default: transect-out/NAME/scan].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write into the folder even if it holds files that no simulation wrote.
    #[arg(long)]
    force: bool,
    /// Seed of the noise [default: the scene's own].
    #[arg(long, value_name = "NUMBER")]
    seed: Option<u64>,
    /// No noise: perfect sensors at their true poses.
    #[arg(long, conflicts_with = "seed")]
    noise_free: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut description = describe(&arguments.scene)?;
    if let Some(seed) = arguments.seed {
        description.noise.seed = seed;
    }
    if arguments.noise_free {
        description.noise = Noise::NONE;
    }
    if !(arguments.density.is_finite() && (0.01..=100.0).contains(&arguments.density)) {
        let problem = format!("--density must be from 0.01 to 100, got {}", arguments.density);
        return Err(Failure::Usage(problem));
    }
    let plan = SensorPlan {
        sensor: arguments.sensor,
        views: arguments.views.map(usize::from),
        density: arguments.density,
    };
    check_stripe_images(arguments, &description)?;
    let folder =
        arguments.out.clone().unwrap_or_else(|| default_folder(&description.name).join("scan"));
    let images = if arguments.stripe_images {
        // The writer knows the columns of each sensor.
        StripeImages::Seen(stripe_camera(0, description.noise.seed))
    } else {
        StripeImages::Extracted
    };
    claim_scan_folder(&folder, arguments.force)?;
    print(&simulate_as(description, &plan, images, &folder)?);
    Ok(())
}

/// Refuses --stripe-images where no sensor sees a stripe.
fn check_stripe_images(arguments: &Arguments, scene: &Description) -> Result<(), Failure> {
    let is_stripe = |sensor: &SensorParameters| matches!(sensor, SensorParameters::LightStripe(_));
    let found = match arguments.sensor {
        _ if !arguments.stripe_images => return Ok(()),
        Some(SensorKind::LightStripe) => return Ok(()),
        Some(other) => format!("--sensor is {}", other.name()),
        None if scene.stations.iter().any(|station| is_stripe(&station.sensor)) => return Ok(()),
        None => format!("the scene {} has none, and --sensor chooses none", scene.name),
    };
    Err(Failure::Usage(format!(
        "--stripe-images: only light-stripe sensors have such images, and {found}; pass --sensor \
         light_stripe, or leave out --stripe-images"
    )))
}

/// Simulates a scene's own sensors and writes the scan folder.
pub fn simulate(description: Description, folder: &Path) -> Result<(), Failure> {
    claim_scan_folder(folder, false)?;
    simulate_as(description, &SensorPlan::OWN, StripeImages::Extracted, folder).map(drop)
}

fn simulate_as(
    description: Description,
    plan: &SensorPlan,
    images: StripeImages,
    folder: &Path,
) -> Result<Vec<Row>, Failure> {
    let scene = PreparedScene::new(description)?;
    let simulated = scene.simulate(plan)?;
    for name in &simulated.blind {
        let text = format!("view {name} sees nothing of the scene and is left out");
        notes::tell(&[Note::new(text)]);
    }
    simulated.write(&scene, images, folder)?;
    let rate = simulated.rays as f64 / simulated.time.as_secs_f64() / 1e6;
    let mut rows = vec![
        Row::new("scene", scene.description.name, ""),
        Row::plain("views", simulated.views.len()),
    ];
    if let (Some(kind), Some(first)) = (plan.sensor, simulated.instruments.first()) {
        rows.push(Row::new("sensor", kind.name(), ""));
        let in_millimetres = scene.description.unit.in_metres() * 1e3;
        let scale = first.instrument.scale.map(|s| digits(s * in_millimetres));
        rows.extend(scale.map(|s| Row::new("times the dissertation's (view 0)", s, "")));
    }
    rows.push(Row::plain("rays", simulated.rays));
    rows.push(Row::new("rays per second and core", digits(rate), "million"));
    rows.push(Row::plain("scan", folder.join(MANIFEST_FILE).display()));
    Ok(rows)
}
