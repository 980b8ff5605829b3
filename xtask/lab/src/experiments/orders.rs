//! How the error falls with the grid's density: a ball and a torus, whose sections are circles.
//!
//! Without noise, what is left is sampling: between two samples h apart a curve of radius R is a
//! chord, off by up to h²/8R. Twice the density must leave a quarter of the error, order 2.

use super::{table, trial};
use crate::failure::Failure;
use crate::simulation::{PreparedScene, SensorKind, SensorPlan};
use crate::table::{digits, say};
use transect_geometry::{Curve, PlaneIndex, Point2};
use transect_scene::Description;

/// Options of `experiments orders`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// How often the density is doubled, from half of the sensors' usual one on.
    #[arg(long, default_value_t = 3, value_name = "NUMBER", value_parser = clap::value_parser!(u8).range(1..=5))]
    doublings: u8,
}

/// Radius of the ball, of the torus around it, and of the torus's tube.
const BALL: f64 = 40.0;
const RING: f64 = 70.0;
const TUBE: f64 = 15.0;

/// Planes through both, off their symmetries, and where sensors stand.
const STATIONS: &str = r#"
name = "ball and torus"
unit = "mm"
[planes]
normal = [0, 0, 1]
offset = 0.4
interval = 4
[[station]]
name = "front"
sensor = "pinhole"
rows = 100
cols = 100
field_of_view = 30
at = [30, -250, 180]
look_at = [0, 0, 0]
[[station]]
name = "left"
sensor = "pinhole"
rows = 100
cols = 100
field_of_view = 30
at = [-240, 130, 160]
look_at = [0, 0, 0]
[[station]]
name = "right"
sensor = "pinhole"
rows = 100
cols = 100
field_of_view = 30
at = [230, 140, 170]
look_at = [0, 0, 0]
"#;

/// Runs the experiment.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let solids = format!(
        "[[solid]]\nshape = \"ball\"\nradius = {BALL}\nat = [0, 0, 0]\n\
         [[solid]]\nshape = \"torus\"\nradius = {RING}\ntube = {TUBE}\nat = [0, 0, 0]\n"
    );
    let scene = PreparedScene::new(Description::parse(&format!("{STATIONS}{solids}"))?)?;
    let mut lines = Vec::new();
    for kind in SensorKind::ALL {
        let mut before: Option<[f64; 2]> = None;
        for doubling in 0..=arguments.doublings {
            let density = 0.5 * f64::from(1 << doubling);
            let outcome = trial::run(&scene, &SensorPlan { density, ..SensorPlan::with(kind) })?;
            let errors = errors(&scene, outcome.curves());
            let pixels: usize = outcome.views.iter().map(|v| v.image().size().pixels()).sum();
            let order = |k: usize| match before {
                Some(b) => format!("{:.2}", (b[k] / errors[k]).log2()),
                None => String::new(),
            };
            lines.push(vec![
                kind.name().to_owned(),
                digits(density),
                pixels.to_string(),
                digits(errors[0]),
                order(0),
                digits(errors[1]),
                order(1),
            ]);
            before = Some(errors);
        }
    }
    let heads = ["sensor", "density", "pixels", "median", "order", "p95", "order"];
    table::print(&heads, &lines);
    say(
        "\nDistances in mm from the exact circles, noise-free; order: how often the error halves with each doubling.",
    );
    Ok(())
}

/// Median and 95 % quantile of the distances of the curves' nodes and units' middles from the
/// nearest circle.
fn errors(
    scene: &PreparedScene,
    planes: impl IntoIterator<Item = (PlaneIndex, Vec<Curve>)>,
) -> [f64; 2] {
    let mut errors = Vec::new();
    for (index, curves) in planes {
        let height = scene.description.planes.station(index);
        let frame = scene.description.planes.frame(index);
        let radii = radii(height);
        let error = |p: &Point2| {
            let at = frame.world_from_plane(p);
            let off = radii.iter().map(|r| (at.x.hypot(at.y) - r).abs());
            off.fold(f64::INFINITY, f64::min)
        };
        for unit in curves.iter().flat_map(Curve::units) {
            let middle = nalgebra::center(&unit.start, &unit.end);
            errors.extend([error(&unit.start), error(&middle)]);
        }
    }
    errors.sort_unstable_by(f64::total_cmp);
    let quantile = |q: f64| {
        errors.get(((errors.len() as f64 - 1.0) * q) as usize).copied().unwrap_or(f64::NAN)
    };
    [quantile(0.5), quantile(0.95)]
}

/// Radii of the circles in which the plane at a height cuts the solids.
fn radii(height: f64) -> Vec<f64> {
    let half = |radius: f64| (radius * radius - height * height).sqrt();
    let (ball, tube) = (half(BALL), half(TUBE));
    [ball, RING + tube, RING - tube].into_iter().filter(|r| !r.is_nan()).collect()
}
