//! The machined part: its sections as an exploded stack, and three of them with their areas.

use super::projection::{Lines, Projection, stroke};
use super::{FAINT, INK, RAMP, SOLID};
use crate::experiments::trial;
use crate::failure::Failure;
use transect_exchange::svg::{Anchor, Figure, Mark};
use transect_geometry::{Curve, PlaneIndex, Point2, Point3};
use transect_model::{CurveIndex, Model, Section};
use transect_workflow::simulation::SensorPlan;

/// Number of views: three rounds of the scene's stations, so that all of the keyway is seen.
const VIEWS: usize = 33;

/// Where the heights of the sections stand, in pixels from the left.
const LABELS: f64 = 655.0;

/// Every so many planes of the stack are drawn.
const EVERY: usize = 3;

/// Factor on the heights of the stack.
const OPENED: f64 = 3.0;

/// Stations of the sections that are drawn flat, in millimetres: hub, flange, pilot.
const FLAT: [f64; 3] = [30.27, 8.27, -1.73];

/// Draws the poster.
pub fn draw() -> Result<Figure, Failure> {
    let scene = trial::bundled("machined_part")?;
    let plan = SensorPlan { views: Some(VIEWS), ..SensorPlan::OWN };
    let views = scene.simulate(&plan)?.views;
    let model = trial::scene_model(&scene, &views)?;
    let mut figure = Figure::new(
        "A machined part as a stack of sections",
        format!(
            "The bundled flange from {VIEWS} depth images with 0.03 mm of noise. Left: every third of \
             {} sections, heights times {OPENED}. Right: three from above.",
            model.sections().len()
        ),
        [1180.0, 740.0],
    );
    stack(&mut figure, &model);
    for (k, station) in FLAT.iter().enumerate() {
        flat(&mut figure, &model, *station, Point2::new(800.0, k as f64 * 245.0));
    }
    figure.legend(Mark::Line(RAMP[1]), "lowest sections");
    figure.legend(Mark::Line(RAMP[6]), "highest sections");
    figure.legend(Mark::Area(SOLID), "solid, on the left of every curve");
    figure.legend(Mark::Dashed(FAINT), "guide, along which the planes lie");
    Ok(figure)
}

/// A section and its station.
struct Layer<'a> {
    index: PlaneIndex,
    station: f64,
    section: &'a Section,
}

fn stack(figure: &mut Figure, model: &Model) {
    let layer = |(index, section)| Layer { index, station: model.planes().station(index), section };
    let layers: Vec<Layer<'_>> = model.sections().map(layer).step_by(EVERY).collect();
    let (Some(first), Some(last)) = (layers.first(), layers.last()) else { return };
    let corners = |layer: &Layer<'_>| {
        let (around, z) = (layer.section.envelope(), layer.station);
        let radius = 0.5 * around.size().x;
        [-radius, radius].map(|x| [Point3::new(x, x, z), Point3::new(x, -x, z)])
    };
    let corners = layers.iter().flat_map(corners).flatten();
    let projection = Projection::from_side(-60.0, 30.0).exploded(OPENED).fitting(
        corners,
        Point2::new(0.0, 10.0),
        [640.0, 700.0],
    );
    let ends = [first.station - 6.0, last.station + 8.0];
    let ends = ends.map(|z| projection.place(&Point3::new(0.0, 0.0, z)));
    let dashes = format!("stroke=\"{FAINT}\" stroke-dasharray=\"7 5\"");
    figure.line(&ends, false, &dashes);
    for layer in &layers {
        let share = (layer.station - first.station) / (last.station - first.station);
        let colour = RAMP[(share * (RAMP.len() - 1) as f64).round() as usize];
        let lines = projection.lines(&model.planes().frame(layer.index), layer.section.curves());
        figure.path(&solid(layer.section, &lines), 0.0, "fill=\"#ffffff\" fill-opacity=\"0.75\"");
        let fill = format!("fill=\"{colour}\" fill-opacity=\"0.22\"");
        figure.path(&solid(layer.section, &lines), 0.0, &fill);
        figure.path(&lines, 1.8, &stroke(colour));
        label(figure, &lines, layer.station);
    }
    // Above the topmost section the guide stands before all of them.
    let top = projection.place(&Point3::new(0.0, 0.0, last.station));
    figure.line(&[top, ends[1]], false, &dashes);
    figure.scale_bar(Point2::new(0.0, 715.0), [projection.scale, 150.0], "mm");
}

/// The height of a layer, at the right of the stack.
fn label(figure: &mut Figure, lines: &Lines, station: f64) {
    let points = lines.iter().flat_map(|(points, _)| points);
    let Some(right) = points.max_by(|a, b| a.x.total_cmp(&b.x)) else { return };
    let at = Point2::new(LABELS, right.y);
    let near = Point2::new(right.x + 4.0, right.y);
    figure.line(&[near, at], false, &format!("stroke=\"{FAINT}\" stroke-width=\"0.7\""));
    figure.text(
        Point2::new(at.x + 6.0, at.y + 5.0),
        Anchor::Start,
        13.0,
        INK,
        &millimetres(station, 1),
    );
}

fn millimetres(length: f64, decimals: usize) -> String {
    format!("{length:.decimals$} mm").replace('-', "\u{2212}")
}

/// The curves whose inside or outside is known to be solid.
fn solid(section: &Section, lines: &Lines) -> Lines {
    let known = section.known_solid();
    let is_known = |k: &usize| known.contains(&CurveIndex(*k));
    lines.iter().enumerate().filter(|(k, _)| is_known(k)).map(|(_, line)| line.clone()).collect()
}

/// A section from above, with its area.
fn flat(figure: &mut Figure, model: &Model, station: f64, at: Point2) {
    let found = model.sections().find(|(k, _)| (model.planes().station(*k) - station).abs() < 0.1);
    let Some((index, section)) = found else { return };
    let frame = model.planes().frame(index);
    let corners = [[-62.0, -62.0], [62.0, 62.0]].map(|c| frame.world_from_plane(&Point2::from(c)));
    let projection = Projection::onto(&frame).fitting(corners.into_iter(), at, [228.0; 2]);
    let curves: Vec<&Curve> = section.curves().collect();
    let lines = projection.lines(&frame, curves.iter().copied());
    figure.path(&solid(section, &lines), 0.0, &format!("fill=\"{SOLID}\""));
    figure.path(&lines, 1.8, &stroke(INK));
    let area = section.measures().solid;
    let area = match area.most {
        Some(most) if most - area.least < 0.5 => format!("{:.0} mm²", area.estimate),
        Some(most) => format!("{:.0} to {most:.0} mm²", area.least),
        None => format!("at least {:.0} mm²", area.least),
    };
    let at = Point2::new(at.x + 238.0, at.y + 104.0);
    figure.text(at, Anchor::Start, 16.0, INK, &millimetres(station, 2));
    let below = Point2::new(at.x, at.y + 22.0);
    figure.text(below, Anchor::Start, 14.0, FAINT, &area);
}
