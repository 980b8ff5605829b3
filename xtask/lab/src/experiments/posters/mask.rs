//! The face mask after each of its four views.

use super::projection::{Lines, Projection, stroke};
use super::{FAINT, VIEWS, nodes};
use crate::experiments::trial;
use crate::failure::Failure;
use transect_exchange::svg::{Anchor, Figure, Mark};
use transect_geometry::{Curve, Point2};
use transect_model::Model;
use transect_workflow::simulation::SensorPlan;

/// Every so many planes are drawn.
const EVERY: usize = 2;

/// Distance from the former curves from which on a piece counts as new, in millimetres. Chosen by
/// hand: many times the noise, and less than the smallest gap that one sees.
const NEW: f64 = 0.8;

/// Where the observer stands, in degrees: above the face, so that the nose stands out.
const AZIMUTH: f64 = -68.0;
const ELEVATION: f64 = 38.0;

/// Width and height of the drawing of one step, and the space between two, in pixels.
const STEP: [f64; 2] = [268.0, 345.0];
const BETWEEN: f64 = 22.0;

/// Draws the poster.
pub fn draw() -> Result<Figure, Failure> {
    let scene = trial::bundled("face_mask")?;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let mut figure = Figure::new(
        "A face mask grows view by view",
        "Four depth images with 0.05 mm of noise, on sections 2 mm apart; every second one is \
         drawn. Each view closes gaps that the others could not see.",
        [4.0 * STEP[0] + 3.0 * BETWEEN, STEP[1] + 90.0],
    );
    let model = |k| trial::scene_model(&scene, &views[..=k]);
    let models: Vec<Model> =
        (0..views.len().min(VIEWS.len())).map(model).collect::<Result<_, _>>()?;
    let Some(last) = models.last() else { return Ok(figure) };
    let projection = Projection::from_side(AZIMUTH, ELEVATION);
    for (k, (view, model)) in views.iter().zip(&models).enumerate() {
        let at = Point2::new(k as f64 * (STEP[0] + BETWEEN), 50.0);
        let name = if k == 0 { view.name().to_owned() } else { format!("+ {}", view.name()) };
        figure.text(Point2::new(at.x, 16.0), Anchor::Start, 18.0, VIEWS[k], &name);
        let length = format!("{:.1} m of curves", 1e-3 * model.length());
        figure.text(Point2::new(at.x, 36.0), Anchor::Start, 14.0, FAINT, &length);
        let before = k.checked_sub(1).and_then(|k| models.get(k));
        let projection = projection.clone().fitting(nodes(last), at, STEP);
        step(&mut figure, (before, model), VIEWS[k], &projection);
        let scale = Point2::new(at.x, at.y + STEP[1] + 24.0);
        figure.scale_bar(scale, [projection.scale, 110.0], "mm");
    }
    for (view, colour) in views.iter().zip(VIEWS) {
        figure.legend(Mark::Line(colour), format!("new by the view “{}”", view.name()));
    }
    figure.legend(Mark::Line("#b9c0c4"), "known from the views before");
    Ok(figure)
}

/// The model after a view, its new pieces in colour.
fn step(
    figure: &mut Figure,
    (before, model): (Option<&Model>, &Model),
    colour: &str,
    projection: &Projection,
) {
    let (mut former, mut new) = (Lines::new(), Lines::new());
    for (index, section) in model.sections().filter(|(k, _)| k.0.rem_euclid(EVERY as i64) == 0) {
        let known: Vec<&Curve> =
            before.and_then(|m| m.section(index)).into_iter().flat_map(|s| s.curves()).collect();
        let is_known = |p: &Point2| known.iter().any(|c| c.foot(p).distance < NEW);
        let frame = model.planes().frame(index);
        let place = |p: &Point2| projection.place(&frame.world_from_plane(p));
        for unit in section.curves().flat_map(Curve::units) {
            let middle = nalgebra::center(&unit.start, &unit.end);
            let lines = if is_known(&middle) { &mut former } else { &mut new };
            let (start, end) = (place(&unit.start), place(&unit.end));
            match lines.last_mut().filter(|(points, _)| points.last() == Some(&start)) {
                Some((points, _)) => points.push(end),
                None => lines.push((vec![start, end], false)),
            }
        }
    }
    figure.path(&former, 1.1, "fill=\"none\" stroke=\"#b9c0c4\"");
    figure.path(&new, 1.5, &stroke(colour));
}
