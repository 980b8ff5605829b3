//! Posters: what the system does, drawn from its own results on the bundled scenes.

mod mask;
mod part;
mod poses;
pub mod projection;
mod room;
mod tunnel;

use super::lab::Lab;
use super::trial;
use crate::failure::Failure;
use crate::table::say;
use transect_exchange::svg::{Figure, OverviewOptions, write_overview};
use transect_geometry::{Curve, Point3};
use transect_model::Model;
use transect_workflow::simulation::SensorPlan;

/// Colours of views, after Okabe and Ito: readable for the colour-blind, too.
const VIEWS: [&str; 4] = ["#0072b2", "#d55e00", "#009e73", "#b5509c"];

/// Lines and texts.
pub const INK: &str = "#222222";
/// Lines and texts that stand back.
pub const FAINT: &str = "#8a8a8a";
/// The solid side of closed curves.
const SOLID: &str = "#dfe6ea";

/// Colours from the lowest to the highest station.
const RAMP: [&str; 8] =
    ["#440154", "#46327f", "#365c8d", "#277f8e", "#1fa187", "#4ac26d", "#7ad151", "#9fc928"];

/// Draws a poster.
type Draw = fn() -> Result<Figure, Failure>;

/// The posters by name.
const POSTERS: [(&str, Draw); 5] = [
    ("room", room::draw),
    ("part", part::draw),
    ("mask", mask::draw),
    ("tunnel", tunnel::draw),
    ("poses", poses::draw),
];

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    for (name, draw) in POSTERS {
        let figure = draw()?;
        lab.picture(name, |file| figure.write(file))?;
    }
    overview(lab)?;
    say(&format!("posters in {}", lab.folder()?.display()));
    Ok(())
}

/// Every node of the model, in the world.
fn nodes(model: &Model) -> impl Iterator<Item = Point3> + '_ {
    model.sections().flat_map(|(index, section)| {
        let frame = model.planes().frame(index);
        let nodes = section.curves().flat_map(Curve::nodes);
        nodes.map(move |n| frame.world_from_plane(&n.position))
    })
}

/// The overview of the bundled room, as `reconstruct` draws it.
fn overview(lab: &Lab) -> Result<(), Failure> {
    let scene = trial::bundled("room")?;
    let model = trial::scene_model(&scene, &scene.simulate(&SensorPlan::OWN)?.views)?;
    let mut options = OverviewOptions::default();
    options.title.clone_from(&scene.description.name);
    lab.picture("overview", |file| write_overview(&model, &options, file))
}
