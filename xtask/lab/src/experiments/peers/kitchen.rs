//! One plane of the red kitchen in a picture: without and with averaging the views' surfaces, and
//! by another program.

use crate::experiments::lab::Lab;
use crate::experiments::posters::INK;
use crate::experiments::posters::projection::{Lines, Projection, panel, stroke};
use crate::experiments::python;
use crate::experiments::trial::{self, Public};
use crate::failure::Failure;
use serde_json::{Value, json};
use std::path::Path;
use transect::{Setup, Unwatched, reconstruct};
use transect_device::{Pixel, View};
use transect_exchange::svg::{Anchor, Figure, Mark};
use transect_exchange::{MANIFEST_FILE, write_file, write_npy_image};
use transect_fusion::{ConsensusOptions, FusionMethod};
use transect_geometry::{Curve, LengthUnit, PlaneIndex, Point2, Point3};
use transect_model::Model;
use transect_workflow::default_folder;

/// The plane that is drawn, 0.2 m below the first camera: walls, table and shelf.
const PLANE: PlaneIndex = PlaneIndex(2);

/// Edge of the other program's voxels, in metres. Chosen by hand: six times the spacing of the rays
/// at two metres.
const VOXEL: &str = "0.02";

/// Width and height of one panel, and the space between two, in pixels.
const PANEL: [f64; 2] = [560.0, 470.0];
const BETWEEN: f64 = 30.0;

/// Draws the plane.
pub fn draw(lab: &Lab, python: &Path) -> Result<(), Failure> {
    eprintln!("red kitchen");
    let kitchen = trial::red_kitchen(lab.scans()?)?;
    let models = [averaged(&kitchen, false)?, averaged(&kitchen, true)?];
    let other = by_voxels(&kitchen, python)?;
    let mut figure = Figure::new(
        "A section of a real kitchen by a depth camera",
        "The red kitchen of 7-Scenes, 50 frames: plane 2, across the upright. Poses and depths of \
         the frames differ by centimetres.",
        [3.0 * PANEL[0] + 2.0 * BETWEEN, PANEL[1] + 70.0],
    );
    let frame = models[1].planes().frame(PLANE);
    let curves = |model: &Model| -> Vec<Curve> {
        model.section(PLANE).into_iter().flat_map(|s| s.curves().cloned()).collect()
    };
    let [each, both] = [curves(&models[0]), curves(&models[1])];
    let nodes: Vec<Point3> =
        both.iter().flat_map(Curve::nodes).map(|n| frame.world_from_plane(&n.position)).collect();
    type Panel<'a> = (&'a str, &'a dyn Fn(&Projection) -> Lines);
    let panels: [Panel<'_>; 3] = [
        ("every view as it is", &|to| to.lines(&frame, &each)),
        ("views' surfaces averaged (default)", &|to| to.lines(&frame, &both)),
        ("Open3D's VoxelBlockGrid, voxels of 20 mm", &|to| {
            other.iter().map(|ends| (ends.map(|p| to.place(&p)).to_vec(), false)).collect()
        }),
    ];
    for (k, (name, lines)) in panels.into_iter().enumerate() {
        let at = Point2::new(k as f64 * (PANEL[0] + BETWEEN), 30.0);
        let projection = Projection::onto(&frame).fitting(nodes.iter().copied(), at, PANEL);
        figure.text(Point2::new(at.x, 16.0), Anchor::Start, 18.0, INK, name);
        panel(&mut figure, (at, PANEL), (projection.scale, "m"), |figure| {
            figure.path(&lines(&projection), 1.2, &stroke(INK));
        });
    }
    figure.legend(Mark::Line(INK), "section");
    lab.picture("depth_camera", |file| figure.write(file))
}

/// The model of the kitchen with or without averaging the views' surfaces.
fn averaged(kitchen: &Public, settle: bool) -> Result<Model, Failure> {
    let mut setup = Setup::new(LengthUnit::Metre, kitchen.planes.clone());
    let mut options = ConsensusOptions::default();
    options.steps.settle = settle;
    setup.fusion = FusionMethod::Consensus(options);
    Ok(reconstruct(&kitchen.views, &setup, &Unwatched)?.model)
}

/// The pieces of the other program's section.
fn by_voxels(kitchen: &Public, python: &Path) -> Result<Vec<[Point3; 2]>, Failure> {
    let folder = default_folder("peers").join("red-kitchen");
    std::fs::create_dir_all(&folder).map_err(|e| Failure::with_file(&folder, e))?;
    let views: Result<Vec<Value>, Failure> =
        kitchen.views.iter().map(|view| write_view(view, &folder)).collect();
    let planes = json!({ "normal": [0, -1, 0], "offset": 0, "interval": 0.1 });
    let scan = json!({ "name": "red kitchen", "unit": "m", "planes": planes, "views": views? });
    write_file(&folder.join(MANIFEST_FILE), |out| Ok(serde_json::to_writer(out, &scan)?))?;
    let place = folder.to_string_lossy();
    let printed = python::run(python, "peers/section.py", &[&place, &PLANE.0.to_string(), VOXEL])?;
    let piece = |line: &str| {
        let numbers: Vec<f64> = line.split(' ').filter_map(|n| n.parse().ok()).collect();
        let [a, b, c, d, e, f] = numbers.try_into().ok()?;
        Some([Point3::new(a, b, c), Point3::new(d, e, f)])
    };
    let pieces: Option<Vec<_>> = printed.lines().map(piece).collect();
    pieces.ok_or_else(|| Failure::because("peers/section.py: a line without six numbers"))
}

/// Writes the depths of a view, along its camera's axis; returns its entry of the scan.
fn write_view(view: &View, folder: &Path) -> Result<Value, Failure> {
    let size = view.image().size();
    let depth = |p: Pixel| view.point_in_sensor(p).map_or(f32::NAN, |point| point.z as f32);
    let values: Vec<f32> = size.all_pixels().map(depth).collect();
    let file = format!("{}.npy", view.name());
    write_file(&folder.join(&file), |out| write_npy_image(size, &values, out))?;
    let slopes = |p: Pixel| {
        view.frame().ray(p).map(|r| [r.direction.x, r.direction.y].map(|c| c / r.direction.z))
    };
    let corner = Pixel::new(size.rows - 1, size.cols - 1);
    let rays = slopes(Pixel::new(0, 0)).zip(slopes(corner));
    let ([x, y], [far_x, far_y]) =
        rays.ok_or_else(|| Failure::because("a camera without rays at its corners"))?;
    let (fx, fy) = (corner.col as f64 / (far_x - x), corner.row as f64 / (far_y - y));
    let pose = view.world_from_sensor().to_homogeneous();
    let pose: Vec<f64> =
        pose.row_iter().flat_map(|row| row.iter().copied().collect::<Vec<_>>()).collect();
    Ok(json!({ "file": file, "pose": pose, "fx": fx, "fy": fy, "cx": -x * fx, "cy": -y * fy }))
}
