//! Errors of poses: the curves of all views before and after the poses are refined.

use super::INK;
use super::projection::{Projection, panel, stroke};
use crate::experiments::poses::{self, errors, moved};
use crate::experiments::trial;
use crate::failure::Failure;
use transect_device::View;
use transect_exchange::svg::{Anchor, Figure, Mark};
use transect_geometry::{Curve, PlaneFamily, PlaneIndex, Point2};
use transect_partial::{Method, partial_model};
use transect_scene::sections;
use transect_workflow::simulation::SensorPlan;

/// The drawn plane, through the hub and its keyway.
const PLANE: PlaneIndex = PlaneIndex(30);

/// The drawn part of the plane, in millimetres: the keyway.
const CORNERS: [[f64; 2]; 2] = [[6.0, -14.0], [38.0, 18.0]];

/// The drawn error of each pose, in degrees.
const DEGREES: f64 = 0.5;

const SIZE: [f64; 2] = [520.0, 520.0];
const BETWEEN: f64 = 40.0;

const COLOURS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#b5509c", "#c79a00", "#56a3d9"];

/// Draws the poster.
pub fn draw() -> Result<Figure, Failure> {
    let scene = trial::bundled(poses::SCENE)?;
    let planes = &scene.description.planes;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let given = moved(&scene, &views, DEGREES)?;
    let refined = trial::at_refined_poses(&given)?;
    let truth = sections(&scene.truth, planes)?.remove(&PLANE).unwrap_or_default();
    let mut figure = Figure::new(
        "Wrong poses, before and after refinement",
        format!(
            "The keyway of the machined part at {:.0} mm, as {} views see it one by one. Each pose \
             errs by {DEGREES}° and {DEGREES} mm about each axis.",
            planes.station(PLANE),
            views.len()
        ),
        [2.0 * SIZE[0] + BETWEEN, SIZE[1] + 70.0],
    );
    let medians = errors(&scene, &given)?;
    let parts = [("as given", &given), ("refined", &refined)];
    for (k, (name, views)) in parts.into_iter().enumerate() {
        let at = Point2::new(k as f64 * (SIZE[0] + BETWEEN), 30.0);
        figure.text(Point2::new(at.x, 16.0), Anchor::Start, 18.0, INK, name);
        part(&mut figure, (views, planes), &truth, at)?;
        let text = format!("median error of the fused sections: {:.2} mm", medians[k][0]);
        let below = Point2::new(at.x + SIZE[0], at.y + SIZE[1] + 27.0);
        figure.text(below, Anchor::End, 16.0, INK, &text);
    }
    figure.legend(Mark::Line(COLOURS[0]), "curve of one view; a colour per view");
    figure.legend(Mark::Dashed(INK), "true section");
    Ok(figure)
}

/// The curves of each view, and the true section.
fn part(
    figure: &mut Figure,
    (views, planes): (&[View], &PlaneFamily),
    truth: &[Curve],
    at: Point2,
) -> Result<(), Failure> {
    let frame = planes.frame(PLANE);
    let corners = CORNERS.map(|c| frame.world_from_plane(&Point2::from(c)));
    let projection = Projection::onto(&frame).fitting(corners.into_iter(), at, SIZE);
    let mut drawn = Vec::new();
    for view in views {
        let found = partial_model(view, planes, &Method::default())?;
        let of_plane = found.planes.iter().filter(|p| p.plane == PLANE);
        let curves: Vec<_> = of_plane.flat_map(|p| &p.curves).map(|c| c.curve.clone()).collect();
        drawn.push(projection.lines(&frame, &curves));
    }
    drawn.retain(|lines| !lines.is_empty());
    panel(figure, (at, SIZE), (projection.scale, "mm"), |figure| {
        for (lines, k) in drawn.iter().zip(0..) {
            let colour = COLOURS[k % COLOURS.len()];
            figure.path(lines, 2.0, &stroke(colour));
        }
        let truth = projection.lines(&frame, truth);
        let dashes = format!("fill=\"none\" stroke=\"{INK}\" stroke-dasharray=\"140 90\"");
        figure.path(&truth, 1.4, &dashes);
    });
    Ok(())
}
