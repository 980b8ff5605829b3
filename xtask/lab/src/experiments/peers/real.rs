//! The Stanford bunny for the other programs: the points of each range grid, and the published
//! mesh.

use super::{models, smoothed};
use crate::experiments::trial::{self, Public};
use crate::failure::Failure;
use serde_json::json;
use std::path::Path;
use transect::Setup;
use transect_device::{ImageSize, View};
use transect_exchange::{
    MANIFEST_FILE, TRUTH_FILE, TriangleMesh, write_file, write_npy_image, write_truth,
};
use transect_geometry::{LengthUnit, Point3};

/// The name of its folder and of its table.
pub const NAME: &str = "bunny";

/// Distance of the sensor from a range grid's origin along z, in metres. The files do not state it;
/// a tenth or ten times of it turns no normal round.
const SENSOR: f64 = 1.0;

/// Writes the scan, as given and smoothed, and our curves without and with smoothing. Returns the
/// seconds of the default run.
pub fn write(data: &Path, folder: &Path) -> Result<f64, Failure> {
    eprintln!("{NAME}");
    let (Public { views, planes }, mesh) = trial::bunny(data)?;
    let seconds = models(&views, Setup::new(LengthUnit::Metre, planes), folder)?;
    let corners = mesh.vertices.iter();
    let [low, high] = [f64::min, f64::max].map(|of: fn(f64, f64) -> f64| {
        corners.clone().copied().reduce(|a, b| a.coords.zip_map(&b.coords, of).into())
    });
    let size = low.zip(high).map_or(0.0, |(low, high)| (high - low).amax());
    let truth = TriangleMesh { vertices: mesh.vertices, faces: mesh.faces };
    let smooth: Vec<View> = views.iter().map(smoothed).collect();
    for (name, views) in [("given", &views), ("smoothed", &smooth)] {
        let folder = folder.join(name);
        std::fs::create_dir_all(&folder).map_err(|e| Failure::with_file(&folder, e))?;
        let mut entries = Vec::new();
        for (k, view) in views.iter().enumerate() {
            let file = format!("points_{k:03}.npy");
            write_points(view, &folder.join(&file))?;
            let from = view.world_from_sensor() * Point3::new(0.0, 0.0, SENSOR);
            entries.push(json!({ "points": file, "from": [from.x, from.y, from.z] }));
        }
        let planes = json!({ "normal": [0, 1, 0], "offset": 0, "interval": 0.001 });
        let scan = json!({ "name": "Stanford bunny", "unit": "m", "size": size, "sigma": 0,
            "planes": planes, "lowest": trial::BUNNY_FROM, "views": entries });
        write_file(&folder.join(MANIFEST_FILE), |out| Ok(serde_json::to_writer(out, &scan)?))?;
        write_file(&folder.join(TRUTH_FILE), |out| write_truth(&truth, out))?;
    }
    Ok(seconds)
}

/// The points of a view in the world, one a row.
fn write_points(view: &View, file: &Path) -> Result<(), Failure> {
    let pixels = view.image().size().all_pixels();
    let points = pixels.filter_map(|p| view.point_in_sensor(p));
    let points = points.map(|p| view.world_from_sensor() * p);
    let values: Vec<f32> = points.flat_map(|p| [p.x, p.y, p.z].map(|c| c as f32)).collect();
    let size = ImageSize { rows: values.len() / 3, cols: 3 };
    Ok(write_file(file, |out| write_npy_image(size, &values, out))?)
}
