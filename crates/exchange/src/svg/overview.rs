//! All planes in space: an overview of the whole model.
//!
//! An axonometric view with the guide upright, drawn from the far plane to the near one. A piece of
//! curve is drawn strongly if the viewer is on its free side, and faintly if the viewer looks
//! through the solid. This hides the far side of an object, and the near walls of a room. Closed
//! sections are filled, so that each covers the planes behind it.

use super::camera::Camera;
use super::canvas::{self, PathData};
use super::options::OverviewOptions;
use super::ramp::{self, Colour, Stations};
use super::ruler::tidy;
use super::simplify::simplified;
use std::io::{self, Write};
use transect_geometry::{Curve, Guide, PlaneFrame, PlaneIndex, Point2, Point3};
use transect_model::{CurveIndex, Model, Section};

/// Steps of drawn coordinates per pixel. Theory: a step of 0.05 px cannot be seen. Doubled, files
/// are larger.
const STEPS: f64 = 20.0;
/// Vertices that move a line by less than this many pixels are left out. Theory: a tenth of a pixel
/// cannot be seen. Doubled, bends look like corners where a viewer enlarges them.
const TOLERANCE: f64 = 0.1;

/// Writes the overview of a model.
///
/// # Errors
/// An error of `out`.
pub fn write_overview(
    model: &Model,
    options: &OverviewOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    options.write_opening(out)?;
    let planes = model.planes();
    let camera = Camera::fitting(planes, nodes(model), options);
    write_planes(&drawn_planes(model, &camera), camera.line_width(planes) * STEPS, out)?;
    write_heading(model, options, out)?;
    ramp::write_ramp(&station_range(model), model.unit(), options, out)?;
    camera.write_axes(model.unit(), options, out)?;
    writeln!(out, "</svg>")
}

/// Every node of a model, in the world.
fn nodes(model: &Model) -> impl Iterator<Item = Point3> + '_ {
    model.sections().flat_map(|(index, section)| {
        let frame = model.planes().frame(index);
        let nodes = section.curves().flat_map(Curve::nodes);
        nodes.map(move |n| frame.world_from_plane(&n.position))
    })
}

/// First the pieces seen through the solid, then plane after plane; `thick` is in steps.
fn write_planes(planes: &[DrawnPlane], thick: f64, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "<g transform=\"scale({})\" fill=\"none\" stroke-linejoin=\"round\" \
         stroke-linecap=\"round\">",
        1.0 / STEPS
    )?;
    writeln!(out, "<g stroke-width=\"{:.0}\" stroke-opacity=\"0.45\">", 0.6 * thick)?;
    for plane in planes {
        plane.back.write(&format!("stroke=\"{}\"", plane.colour.lightened(0.55)), out)?;
    }
    writeln!(out, "</g><g stroke-width=\"{thick:.0}\">")?;
    for plane in planes {
        let (fill, rim) = (plane.colour.lightened(0.78), plane.colour.lightened(0.5));
        let style = format!("fill=\"{fill}\" fill-opacity=\"0.9\" stroke=\"{rim}\"");
        plane.area.write(&format!("{style} stroke-width=\"{:.0}\"", 0.4 * thick), out)?;
        plane.front.write(&format!("stroke=\"{}\"", plane.colour), out)?;
    }
    writeln!(out, "</g></g>")
}

/// The paths of one plane.
struct DrawnPlane {
    colour: Colour,
    /// Solid area.
    area: PathData,
    /// Pieces of curve seen from the free side.
    front: PathData,
    /// Pieces seen through the solid.
    back: PathData,
}

/// The planes from the far one to the near one.
fn drawn_planes(model: &Model, camera: &Camera) -> Vec<DrawnPlane> {
    let range = station_range(model);
    let mut order: Vec<_> = model.sections().collect();
    match model.planes().guide() {
        Guide::Straight(guide) if camera.towards.dot(&guide.direction()) < 0.0 => order.reverse(),
        Guide::Straight(_) => (),
        Guide::Curved(_) => {
            let nearness = |k: PlaneIndex| camera.nearness(&model.planes().frame(k).origin());
            order.sort_by(|(a, _), (b, _)| nearness(*a).total_cmp(&nearness(*b)));
        }
    }
    let draw = |(index, section)| drawn_plane(model, camera, index, section, &range);
    order.into_iter().map(draw).collect()
}

/// The stations of the planes with curves.
fn station_range(model: &Model) -> Stations {
    let station = |(index, _)| model.planes().station(index);
    let first = model.sections().next().map(station);
    let last = model.sections().next_back().map(station);
    let (first, last) = first.zip(last).unwrap_or((0.0, 0.0));
    Stations { first, last, step: model.planes().interval() * 1e-2 }
}

fn drawn_plane(
    model: &Model,
    camera: &Camera,
    index: PlaneIndex,
    section: &Section,
    range: &Stations,
) -> DrawnPlane {
    let frame = model.planes().frame(index);
    let along = range.share(model.planes().station(index));
    let mut drawn = DrawnPlane {
        colour: Colour::ramp(if along.is_finite() { along } else { 0.0 }),
        area: PathData::new(STEPS),
        front: PathData::new(STEPS),
        back: PathData::new(STEPS),
    };
    let filled = section.known_solid();
    for (number, curve) in section.curves().enumerate() {
        let line = Line::of(curve, &frame, camera);
        if filled.contains(&CurveIndex(number)) {
            drawn.area.polyline(line.vertices.iter().map(|v| &v.place), true);
        }
        line.split(&mut drawn);
    }
    drawn
}

/// A vertex of a drawn curve.
struct Vertex {
    place: Point2,
    /// Whether the piece that begins here is seen from the free side.
    from_free_side: bool,
}

struct Line {
    vertices: Vec<Vertex>,
    closed: bool,
}

impl Line {
    fn of(curve: &Curve, frame: &PlaneFrame, camera: &Camera) -> Self {
        let nodes = curve.nodes();
        let closed = curve.is_closed();
        let places: Vec<Point2> =
            nodes.iter().map(|n| camera.place(&frame.world_from_plane(&n.position))).collect();
        let kept = simplified(&places, closed, TOLERANCE);
        let next = kept.iter().skip(1).chain(kept.first());
        let (x, y) = (camera.towards.dot(&frame.x_axis()), camera.towards.dot(&frame.y_axis()));
        let vertex = |(&i, &j): (&usize, &usize)| {
            let (a, b) = (nodes.get(i)?.position, nodes.get(j)?.position);
            let d = b - a;
            // The free side is on the right: the normal towards it is (d.y, -d.x).
            Some(Vertex { place: *places.get(i)?, from_free_side: d.y * x - d.x * y > 0.0 })
        };
        Self { vertices: kept.iter().zip(next).filter_map(vertex).collect(), closed }
    }

    /// Adds each piece to the front or the back lines.
    fn split(&self, drawn: &mut DrawnPlane) {
        let closing = self.vertices.first().filter(|_| self.closed);
        let ends = self.vertices.iter().skip(1).chain(closing);
        let mut before = None;
        for (a, b) in self.vertices.iter().zip(ends) {
            let path = if a.from_free_side { &mut drawn.front } else { &mut drawn.back };
            if before != Some(a.from_free_side) {
                path.finish();
                path.move_to(&a.place);
            }
            path.line_to(&b.place);
            before = Some(a.from_free_side);
        }
        drawn.front.finish();
        drawn.back.finish();
    }
}

fn write_heading(model: &Model, options: &OverviewOptions, out: &mut dyn Write) -> io::Result<()> {
    canvas::text(out, (40.0, 46.0), "font-size=\"26\" font-weight=\"bold\"", &options.title)?;
    let (planes, unit) = (model.sections().len(), model.unit());
    let interval = model.planes().interval();
    // Where planes were inserted the interval is the smallest of several.
    let every = if model.selected().is_some() { "no nearer than" } else { "every" };
    let open: usize = model.sections().map(|(_, s)| s.open_curve_count()).sum();
    let counts = format!(
        "{planes} planes {every} {} {unit} · {} curves, {open} of them open · {} nodes",
        tidy(interval, interval * 1e-3),
        model.curve_count(),
        model.node_count()
    );
    canvas::text(out, (40.0, 72.0), "fill=\"#555\"", &counts)
}
