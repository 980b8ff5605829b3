//! The error by density of the sensors' grids, on a ball and a torus, whose sections are circles.
//!
//! Without noise the error comes from sampling alone: between two samples h apart, a curve of
//! radius R is a chord, off by up to h²/8R. Twice the density must leave a quarter of the error
//! (order 2).

use super::lab::Lab;
use super::trial;
use crate::failure::Failure;
use crate::statistics::quantile;
use crate::table::{cells, digits, say};
use transect_geometry::{Curve, Point2};
use transect_model::Model;
use transect_scene::Description;
use transect_workflow::simulation::{PreparedScene, SensorKind, SensorPlan};

/// Options of `experiments orders`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Number of times that the density is doubled, beginning with half of the sensors' usual one.
    #[arg(long, default_value_t = 3, value_name = "NUMBER", value_parser = clap::value_parser!(u8).range(1..=5))]
    doublings: u8,
}

/// Radius of the ball, of the torus around it, and of the torus's tube.
const BALL: f64 = 40.0;
const RING: f64 = 70.0;
const TUBE: f64 = 15.0;

/// Places of the sensors, in millimetres.
const STATIONS: [[f64; 3]; 3] =
    [[30.0, -250.0, 180.0], [-240.0, 130.0, 160.0], [230.0, 140.0, 170.0]];

/// Runs the experiment.
pub fn run(arguments: &Arguments, lab: &Lab) -> Result<(), Failure> {
    // Planes through both solids, off their symmetries.
    let text = format!(
        "name = \"ball and torus\"\nunit = \"mm\"\n\
         planes = {{ normal = [0, 0, 1], offset = 0.4, interval = 4 }}\n\
         [[solid]]\nshape = \"ball\"\nradius = {BALL}\nat = [0, 0, 0]\n\
         [[solid]]\nshape = \"torus\"\nradius = {RING}\ntube = {TUBE}\nat = [0, 0, 0]\n{}",
        STATIONS.map(|at| trial::camera(at, 100, 30.0)).concat()
    );
    let scene = PreparedScene::new(Description::parse(&text)?)?;
    let mut lines = Vec::new();
    for kind in SensorKind::ALL {
        let mut before: Option<[f64; 2]> = None;
        for doubling in 0..=arguments.doublings {
            let density = 0.5 * f64::from(1 << doubling);
            let plan = SensorPlan { density, ..SensorPlan::with(kind) };
            let views = scene.simulate(&plan)?.views;
            let errors = errors(&trial::scene_model(&scene, &views)?);
            let order = |k: usize| match before {
                Some(b) => format!("{:.2}", (b[k] / errors[k]).log2()),
                None => String::new(),
            };
            let [median, p95] = errors.map(digits);
            lines.push(cells(&format!(
                "{} | {} | {} | {median} | {} | {p95} | {}",
                kind.name(),
                digits(density),
                trial::pixels(&views),
                order(0),
                order(1)
            )));
            before = Some(errors);
        }
    }
    let heads = "sensor | density | pixels | median | order | p95 | order";
    lab.table("table", heads, lines)?;
    say(
        "Distances in mm from the exact circles, noise-free; order: how often the error halves with \
         each doubling.",
    );
    Ok(())
}

/// Median and 95 % quantile of the distances from the nearest circle, over the nodes of the curves
/// and the middles between them.
fn errors(model: &Model) -> [f64; 2] {
    let mut errors = Vec::new();
    for (index, section) in model.sections() {
        let frame = model.planes().frame(index);
        let radii = radii(model.planes().station(index));
        let error = |p: &Point2| {
            let at = frame.world_from_plane(p);
            let off = radii.iter().map(|r| (at.x.hypot(at.y) - r).abs());
            off.fold(f64::INFINITY, f64::min)
        };
        for unit in section.curves().flat_map(Curve::units) {
            let middle = nalgebra::center(&unit.start, &unit.end);
            errors.extend([error(&unit.start), error(&middle)]);
        }
    }
    [quantile(errors.clone(), 0.5), quantile(errors, 0.95)]
}

/// Radii of the circles in which the plane at a height cuts the solids.
fn radii(height: f64) -> Vec<f64> {
    let half = |radius: f64| (radius * radius - height * height).sqrt();
    let (ball, tube) = (half(BALL), half(TUBE));
    [ball, RING + tube, RING - tube].into_iter().filter(|r| !r.is_nan()).collect()
}
