//! A floor plan of the room: the space that each of four scanners looked through, and the section
//! of all of them.

use super::projection::{Projection, stroke};
use super::{FAINT, INK, SOLID, VIEWS};
use crate::experiments::trial;
use crate::failure::Failure;
use transect_device::{Pixel, View};
use transect_exchange::svg::{Anchor, Figure, Mark, Raster};
use transect_geometry::{Curve, PlaneFrame, PlaneIndex, Point2};
use transect_partial::{Method, partial_model};
use transect_workflow::simulation::SensorPlan;

/// The plane, 0.73 m above the floor, through the table's top.
const PLANE: PlaneIndex = PlaneIndex(14);

/// The drawn part of the plane in metres: the room and its walls.
const CORNERS: [[f64; 2]; 2] = [[-0.25, -0.25], [6.25, 5.25]];

/// Width and height of the plan of all views, and of that of one, in pixels.
const WHOLE: [f64; 2] = [611.0, 517.0];
const ONE: [f64; 2] = [260.0, 220.0];

/// Metres between the places of the plane that are looked for in the images.
const STEP: f64 = 0.025;

/// A plan of the plane.
struct Plan {
    frame: PlaneFrame,
    projection: Projection,
    at: Point2,
    size: [f64; 2],
}

/// Draws the poster.
pub fn draw() -> Result<Figure, Failure> {
    let scene = trial::bundled("room")?;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let (unit, planes) = (scene.description.unit, &scene.description.planes);
    let frame = planes.frame(PLANE);
    let model = trial::scene_model(&scene, &views)?;
    let mut figure = Figure::new(
        "One section from four corners",
        "The bundled room at 0.73 m. Each scanner saw what its corner shows; together they saw \
         both sides of the pillar, the table, the chair and the cactus.",
        [WHOLE[0] + 40.0 + 2.0 * ONE[0] + 30.0, WHOLE[1] + 70.0],
    );
    let whole = Plan::new(&frame, Point2::new(0.0, 30.0), WHOLE);
    let curves: Vec<&Curve> = model.section(PLANE).into_iter().flat_map(|s| s.curves()).collect();
    heading(&mut figure, &whole, INK, "all four scans fused");
    let seen_by = |p: &Point2| views.iter().filter(|view| is_free(view, &frame, p)).count();
    let shades = [[0xe3; 3], [0xd2, 0xe3, 0xf0], [0xe1, 0xed, 0xf5], [0xef, 0xf5, 0xfa], [0xff; 3]];
    whole.raster(&mut figure, |p| shades[seen_by(p).min(4)]);
    let lines = whole.projection.lines(&frame, curves.iter().copied());
    let solid: Vec<_> = lines.iter().filter(|(_, closed)| *closed).cloned().collect();
    figure.path(&solid, 0.0, &format!("fill=\"{SOLID}\""));
    figure.path(&lines, 2.2, &stroke(INK));
    for (k, view) in views.iter().enumerate() {
        let (right, below) = (k % 2, k / 2);
        let at = Point2::new(
            WHOLE[0] + 40.0 + right as f64 * (ONE[0] + 30.0),
            30.0 + below as f64 * (WHOLE[1] - ONE[1]),
        );
        one_view(&mut figure, &Plan::new(&frame, at, ONE), (view, VIEWS[k]), planes)?;
        whole.station(&mut figure, view, VIEWS[k], 7.0);
    }
    let scale = Point2::new(0.0, 30.0 + WHOLE[1] + 22.0);
    figure.scale_bar(scale, [whole.projection.scale, 120.0], unit.symbol());
    figure.legend(Mark::Line(INK), "fused curve, solid on its left");
    figure.legend(Mark::Line(VIEWS[0]), "curve of one view, in its colour");
    figure.legend(Mark::Area("#d2e3f0"), "free space that one view saw; lighter: more views");
    figure.legend(Mark::Area(SOLID), "inside of a closed curve");
    figure.legend(Mark::Area("#e3e3e3"), "no view saw into it");
    figure.legend(Mark::Dot(VIEWS[1]), "scanner, 400 × 400 pixels, noise of 2 mm");
    Ok(figure)
}

/// One view's curves.
fn one_view(
    figure: &mut Figure,
    plan: &Plan,
    (view, colour): (&View, &'static str),
    planes: &transect_geometry::PlaneFamily,
) -> Result<(), Failure> {
    heading(figure, plan, colour, view.name());
    let free = tint(colour);
    plan.raster(figure, |p| if is_free(view, &plan.frame, p) { free } else { [0xe3; 3] });
    let found = partial_model(view, planes, &Method::default())?;
    let of_plane = found.planes.iter().filter(|p| p.plane == PLANE);
    let curves = of_plane.flat_map(|p| p.curves.iter().map(|c| &c.curve));
    let lines = plan.projection.lines(&plan.frame, curves);
    figure.path(
        &lines,
        2.2,
        &format!("fill=\"none\" stroke=\"{colour}\" stroke-linecap=\"round\""),
    );
    plan.station(figure, view, colour, 6.0);
    Ok(())
}

fn heading(figure: &mut Figure, plan: &Plan, colour: &str, text: &str) {
    figure.text(
        plan.at - transect_geometry::Vector2::new(0.0, 8.0),
        Anchor::Start,
        16.0,
        colour,
        text,
    );
}

/// A colour mixed with four parts of white.
fn tint(colour: &str) -> [u8; 3] {
    let part = |at: usize| colour.get(at..at + 2).and_then(|hex| u8::from_str_radix(hex, 16).ok());
    [1, 3, 5].map(|at| 204 + part(at).unwrap_or(0) / 5)
}

/// Whether a view looked through a place of the plane.
fn is_free(view: &View, frame: &PlaneFrame, p: &Point2) -> bool {
    let in_sensor = view.world_from_sensor().inverse_transform_point(&frame.world_from_plane(p));
    let Some(place) = view.frame().device_point(&in_sensor) else { return false };
    let size = view.image().size();
    let nearest = |x: f64, count: usize| (x.round() as usize).min(count.saturating_sub(1));
    let inside = |x: f64, count: usize| x > -0.5 && x < count as f64 - 0.5;
    if !inside(place.row, size.rows) || !inside(place.col, size.cols) {
        return false;
    }
    // The pixels around it: a missing one says nothing.
    let (row, col) = (nearest(place.row, size.rows), nearest(place.col, size.cols));
    let around = [(0, 0), (0, 1), (1, 0), (1, 1)];
    let seen = around.iter().find_map(|(i, j)| view.image().get(Pixel::new(row + i, col + j)));
    seen.is_some_and(|seen| place.d3 < f64::from(seen))
}

impl Plan {
    fn new(frame: &PlaneFrame, at: Point2, size: [f64; 2]) -> Self {
        let corners = CORNERS.map(|c| frame.world_from_plane(&Point2::from(c)));
        let projection = Projection::onto(frame).fitting(corners.into_iter(), at, size);
        Self { frame: *frame, projection, at, size }
    }

    /// Colours the plan by the places of the plane.
    fn raster(&self, figure: &mut Figure, colour: impl Fn(&Point2) -> [u8; 3]) {
        let [low, high] = CORNERS;
        let count = |axis: usize| ((high[axis] - low[axis]) / STEP).round() as usize;
        let middle = |k: usize| (k as f64 + 0.5) * STEP;
        let place = |row, col| Point2::new(low[0] + middle(col), high[1] - middle(row));
        let raster = Raster::new(count(1), count(0), |row, col| colour(&place(row, col)));
        figure.raster(&raster, self.at, self.size);
        figure.rectangle(self.at, self.size, &stroke(FAINT));
    }

    fn station(&self, figure: &mut Figure, view: &View, colour: &str, radius: f64) {
        let at = self.projection.place(&view.world_from_sensor().translation.vector.into());
        figure.circle(at, radius, &format!("fill=\"{colour}\" stroke=\"#fff\" stroke-width=\"2\""));
    }
}
