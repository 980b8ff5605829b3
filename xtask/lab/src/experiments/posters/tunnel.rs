//! The bend tunnel: its profiles along the curved guide, and three of them flat.

use super::projection::{Projection, stroke};
use super::{FAINT, INK, RAMP, VIEWS, nodes};
use crate::experiments::trial;
use crate::failure::Failure;
use transect_exchange::svg::{Anchor, Figure, Mark};
use transect_geometry::{PlaneIndex, Point2, Vector2};
use transect_model::Model;
use transect_workflow::simulation::SensorPlan;

/// Planes whose profiles are drawn flat: with the pipe, in the bend, and behind it.
const FLAT: [i64; 3] = [12, 36, 58];

/// Metres of the guide between labels, and between the points that it is drawn by.
const LABELS: f64 = 5.0;
const STEP: f64 = 0.25;

/// Where the observer stands, in degrees: no profile is seen edge-on.
const AZIMUTH: f64 = -112.0;
const ELEVATION: f64 = 42.0;

/// Place of the labels beside the axis, outside the lining, in metres.
const OUTSIDE: f64 = -4.4;

/// Size of the drawing in space, in pixels.
const SPACE: [f64; 2] = [800.0, 560.0];

/// Draws the poster.
pub fn draw() -> Result<Figure, Failure> {
    let scene = trial::bundled("bend_tunnel")?;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let planes = &scene.description.planes;
    let model = trial::scene_model(&scene, &views)?;
    let mut figure = Figure::new(
        "Profiles of a tunnel along its axis",
        format!(
            "The bundled bend tunnel, from {} scans with 2 mm of noise: {} planes, every {} m along the \
             axis. The bend has a radius of 15 m.",
            views.len(),
            model.sections().len(),
            planes.interval()
        ),
        [1120.0, 630.0],
    );
    let projection = in_space(&mut figure, &model)?;
    for view in &views {
        let at = projection.place(&view.world_from_sensor().translation.vector.into());
        figure.circle(
            at,
            5.0,
            &format!("fill=\"{}\" stroke=\"#fff\" stroke-width=\"1.5\"", VIEWS[1]),
        );
    }
    for (k, plane) in FLAT.into_iter().enumerate() {
        flat(&mut figure, &model, PlaneIndex(plane), Point2::new(860.0, 205.0 * k as f64 + 10.0));
    }
    figure.legend(Mark::Line(RAMP[1]), "profiles, by station: first");
    figure.legend(Mark::Line(RAMP[7]), "last");
    figure.legend(Mark::Line(INK), "profiles that the right side shows");
    figure.legend(Mark::Dashed(FAINT), "guide, with its stations");
    figure.legend(Mark::Dot(VIEWS[1]), "scanner");
    figure.legend(Mark::Remark, "No scanner saw the wall behind the pipe (6.24 m).");
    Ok(figure)
}

/// The profiles and the guide in space, from the far one to the near one.
fn in_space(figure: &mut Figure, model: &Model) -> Result<Projection, Failure> {
    let planes = model.planes();
    let guide = planes.guide();
    let guide = guide.curved().ok_or_else(|| Failure::because("the tunnel's guide is straight"))?;
    let projection = Projection::from_side(AZIMUTH, ELEVATION);
    let projection = projection.fitting(nodes(model), Point2::new(0.0, 10.0), SPACE);
    let last = guide.length();
    let colour = |station: f64| RAMP[(station / last * (RAMP.len() - 1) as f64).round() as usize];
    let mut order: Vec<_> = model.sections().collect();
    // Profiles that are higher up in the picture are farther away.
    let depth = |k: PlaneIndex| projection.place(&planes.frame(k).origin()).y;
    order.sort_by(|(a, _), (b, _)| depth(*a).total_cmp(&depth(*b)));
    for (index, section) in order {
        let lines = projection.lines(&planes.frame(index), section.curves());
        let (width, colour) = match FLAT.contains(&index.0) {
            true => (2.8, INK),
            false => (1.2, colour(planes.station(index))),
        };
        figure.path(&lines, width, &stroke(colour));
    }
    let at = |station: f64| projection.place(&guide.frame(station).origin());
    let count = (last / STEP) as usize;
    let axis: Vec<Point2> = (0..=count).map(|k| at(k as f64 * STEP)).collect();
    figure.line(
        &axis,
        false,
        &format!("fill=\"none\" stroke=\"{FAINT}\" stroke-width=\"1.6\" stroke-dasharray=\"7 5\""),
    );
    for k in 0..=(last / LABELS) as usize {
        let station = k as f64 * LABELS;
        let (place, frame) = (at(station), guide.frame(station));
        let beside = frame.world_from_plane(&Point2::new(OUTSIDE, 0.0));
        let beside = projection.place(&beside);
        figure.line(&[place, beside], false, &format!("stroke=\"{INK}\" stroke-width=\"0.8\""));
        figure.circle(place, 3.5, &format!("fill=\"#fff\" stroke=\"{INK}\" stroke-width=\"1.4\""));
        let text = format!("{station:.0} m");
        figure.text(beside + Vector2::new(4.0, 8.0), Anchor::Start, 14.0, INK, &text);
    }
    figure.scale_bar(Point2::new(340.0, SPACE[1] + 30.0), [projection.scale, 140.0], "m");
    Ok(projection)
}

/// A profile in its own plane.
fn flat(figure: &mut Figure, model: &Model, index: PlaneIndex, at: Point2) {
    let Some(section) = model.section(index) else { return };
    let frame = model.planes().frame(index);
    let nodes = section.curves().flat_map(transect_geometry::Curve::nodes);
    let nodes = nodes.map(|n| frame.world_from_plane(&n.position));
    let projection = Projection::onto(&frame).fitting(nodes, at, [200.0, 150.0]);
    let lines = projection.lines(&frame, section.curves());
    figure.path(&lines, 2.2, &stroke(INK));
    let origin = projection.place(&frame.origin());
    figure.circle(origin, 3.0, &format!("fill=\"{FAINT}\""));
    let text = format!("station {:.2} m", model.planes().station(index));
    figure.text(Point2::new(at.x, at.y + 172.0), Anchor::Start, 14.0, INK, &text);
    figure.scale_bar(Point2::new(at.x + 120.0, at.y + 167.0), [projection.scale, 60.0], "m");
}
