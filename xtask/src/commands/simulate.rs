//! `cargo xtask simulate`: a scan folder of a simulated scene, with its truth.

use super::{default_out, stations};
use crate::failure::Failure;
use crate::table::{Row, print};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use transect_device::{RangeImage, View};
use transect_exchange::{
    Manifest, PlanesEntry, TriangleMesh, read_mesh, write_file, write_manifest, write_npy_image,
    write_truth,
};
use transect_scene::{BUNDLED_SCENES, Description, Mesh};

/// Largest distance between a curved solid and its truth mesh, as a share of the plane interval:
/// well below anything a simulated scanner resolves.
const CHORD_SHARE: f64 = 1e-3;

/// Options of `simulate`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Scene file (TOML), or a bundled scene: room, face_mask, machined_part, thin_sheet or tunnel.
    #[arg(default_value = "room")]
    scene: PathBuf,
    /// Folder to write range_*.npy, scan.json and truth.npz into [default: target/transect/NAME/scan].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Seed of the noise [default: the scene's own].
    #[arg(long, value_name = "NUMBER")]
    seed: Option<u64>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut description = describe(&arguments.scene)?;
    if let Some(seed) = arguments.seed {
        description.noise.seed = seed;
    }
    let folder =
        arguments.out.clone().unwrap_or_else(|| default_out(&description.name).join("scan"));
    simulate(&description, &folder)?;
    print(&[
        Row::new("scene", description.name.clone(), ""),
        Row::count("views", description.stations.len()),
        Row::new("scan", folder.join("scan.json").display().to_string(), ""),
    ]);
    Ok(())
}

/// Reads a scene file with the meshes beside it, or takes a bundled scene.
pub fn describe(scene: &Path) -> Result<Description, Failure> {
    let bundled = BUNDLED_SCENES.iter().find(|(name, _)| Path::new(name) == scene);
    let text = match bundled {
        Some((_, text)) => (*text).to_owned(),
        None => std::fs::read_to_string(scene).map_err(|e| Failure::with_file(scene, e))?,
    };
    let folder = scene.parent().unwrap_or(Path::new(""));
    let names = Description::mesh_names(&text).map_err(|e| Failure::with_file(scene, e))?;
    let mut meshes = BTreeMap::new();
    for name in names {
        let TriangleMesh { vertices, faces } = read_mesh(&folder.join(&name))?.mesh;
        meshes.insert(name, Mesh { vertices, faces });
    }
    let description = Description::parse_with_meshes(&text, &meshes);
    description.map_err(|e| Failure::with_file(scene, e))
}

/// Simulates all stations and writes the scan folder.
pub fn simulate(description: &Description, folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|e| Failure::with_file(folder, e))?;
    let scene = description.scene();
    let view = |(k, station): (usize, &transect_scene::Station)| -> Result<View, Failure> {
        let frame = stations::frame(station)?;
        let pose = station.world_from_sensor;
        Ok(scene.view(station.name.clone(), frame, pose, &description.noise, k as u64)?)
    };
    let views = description
        .stations
        .par_iter()
        .enumerate()
        .map(|(k, s)| view((k, s)).map_err(|f| failure_text(&f)));
    let views: Vec<View> = views.collect::<Result<_, String>>().map_err(Failure::because)?;
    let mut entries = Vec::new();
    for (k, (view, station)) in views.iter().zip(&description.stations).enumerate() {
        let file = format!("range_{k:03}.npy");
        let values = values(view.image());
        write_file(&folder.join(&file), |out| write_npy_image(view.image().size(), &values, out))?;
        entries.push(stations::entry(station, view.world_from_sensor(), file));
    }
    let manifest = Manifest {
        name: description.name.clone(),
        unit: Some(description.unit),
        sigma: views.iter().filter_map(View::sigma).reduce(f64::max),
        planes: Some(planes_entry(description)),
        views: entries,
    };
    write_file(&folder.join("scan.json"), |out| write_manifest(&manifest, out))?;
    let mesh = scene.mesh(CHORD_SHARE * description.planes.interval())?;
    let truth = TriangleMesh { vertices: mesh.vertices, faces: mesh.faces };
    write_file(&folder.join("truth.npz"), |out| write_truth(&truth, out))?;
    Ok(())
}

/// A failure that can leave its thread.
fn failure_text(failure: &Failure) -> String {
    match failure {
        Failure::Usage(text) => text.clone(),
        Failure::Failed(error) => error.to_string(),
    }
}

fn values(image: &RangeImage) -> Vec<f32> {
    (0..image.size().rows).flat_map(|row| image.row(row).iter().copied()).collect()
}

fn planes_entry(description: &Description) -> PlanesEntry {
    let planes = &description.planes;
    PlanesEntry {
        normal: planes.guide().direction().into(),
        offset: planes.offset(),
        interval: planes.interval(),
    }
}
