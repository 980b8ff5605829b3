//! All planes in space: the picture that shows what a model is of.
//!
//! An axonometric view with the guide upright, drawn from the far plane to the near one. A piece of
//! curve is drawn strongly where one looks at it from the free side and faintly where one looks
//! through the solid at it: that hides the far side of an object, and the near walls of a room.
//! Closed sections are filled, so that each covers what lies behind it.

use super::canvas::{self, PathData, escaped};
use super::regions;
use super::ruler::{round_down, tidy};
use super::simplify::simplified;
use std::io::{self, Write};
use transect_geometry::{Curve, Envelope, PlaneFrame, PlaneIndex, Point2, Point3, Vector3};
use transect_model::{Model, Section};

/// Steps of drawn coordinates per pixel: 0.05 px.
const STEPS: f64 = 20.0;
/// Vertices that move a line by less than this many pixels are left out.
const TOLERANCE: f64 = 0.1;
/// Left, top, right and bottom of the room for the drawing, as distances from the picture's edges.
const MARGINS: (f64, f64, f64, f64) = (40.0, 92.0, 200.0, 60.0);

/// From where the model is looked at, and how large the picture is.
#[derive(Debug, Clone, PartialEq)]
pub struct OverviewOptions {
    /// The picture's heading.
    pub title: String,
    /// Direction to the viewer around the guide: 0 along the planes' x axis, 90 along y.
    pub azimuth_deg: f64,
    /// Height of the viewer above the planes; between 0 and 90.
    pub elevation_deg: f64,
    /// Width in pixels.
    pub width: f64,
    /// Height in pixels.
    pub height: f64,
}

impl Default for OverviewOptions {
    /// From the front right of the planes' axes and above, 1400 × 1000 pixels.
    fn default() -> Self {
        Self {
            title: "Cross-section model".to_owned(),
            azimuth_deg: -60.0,
            elevation_deg: 30.0,
            width: 1400.0,
            height: 1000.0,
        }
    }
}

/// Writes the overview of a model.
///
/// # Errors
/// What `out` says.
pub fn write_overview(
    model: &Model,
    options: &OverviewOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    let (width, height) = (options.width, options.height);
    let title = escaped(&options.title);
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"Helvetica, Arial, sans-serif\" \
         font-size=\"16\" fill=\"#222\">\n<title>{title}</title>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>"
    )?;
    let camera = Camera::fitting(model, options);
    write_planes(&drawn_planes(model, &camera), camera.line_width(model) * STEPS, out)?;
    write_heading(model, options, out)?;
    write_ramp(model, options, out)?;
    camera.write_axes(model, options, out)?;
    writeln!(out, "</svg>")
}

/// All that is seen through the solid, then plane after plane; `thick` is in steps.
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

/// A parallel projection from the world to the picture.
struct Camera {
    /// World directions of the picture's right and up, and towards the viewer.
    right: Vector3,
    up: Vector3,
    towards: Vector3,
    /// World point drawn at `middle`.
    centre: Point3,
    middle: Point2,
    /// Pixels per length unit across the direction of view.
    scale: f64,
}

impl Camera {
    fn looking(model: &Model, options: &OverviewOptions) -> Self {
        let frame = model.planes().frame(PlaneIndex(0));
        let (sin, cos) = options.azimuth_deg.to_radians().sin_cos();
        let (sin_up, cos_up) = options.elevation_deg.to_radians().sin_cos();
        let level = frame.x_axis() * cos + frame.y_axis() * sin;
        Self {
            right: frame.y_axis() * cos - frame.x_axis() * sin,
            up: frame.normal() * cos_up - level * sin_up,
            towards: level * cos_up + frame.normal() * sin_up,
            centre: first_point(model).unwrap_or(Point3::origin()),
            middle: Point2::origin(),
            scale: 1.0,
        }
    }

    /// The camera for which the model fills the picture.
    fn fitting(model: &Model, options: &OverviewOptions) -> Self {
        let mut camera = Self::looking(model, options);
        let mut around: Option<Envelope> = None;
        for (index, section) in model.sections() {
            let frame = model.planes().frame(index);
            let nodes = section.curves().flat_map(Curve::nodes);
            let points = nodes.map(|n| camera.place(&frame.world_from_plane(&n.position)));
            for p in points {
                let point = Envelope { min: p, max: p };
                around = Some(around.map_or(point, |a| a.merged(&point)));
            }
        }
        let Some(around) = around else { return camera };
        let (left, top, right, bottom) = MARGINS;
        let (width, height) = (options.width - left - right, options.height - top - bottom);
        let size = around.size();
        let scale = (width / size.x).min(height / size.y);
        camera.scale = if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
        let drawn_middle = (around.min.coords + around.max.coords) * (0.5 * camera.scale);
        let middle = Point2::new(left + 0.5 * width, top + 0.5 * height);
        camera.middle = middle - drawn_middle;
        camera
    }

    /// Place in the picture, in pixels, y down.
    fn place(&self, in_world: &Point3) -> Point2 {
        // From a point of the model: far from the origin the differences are what is exact.
        let d = in_world - self.centre;
        self.middle
            + self.scale * transect_geometry::Vector2::new(self.right.dot(&d), -self.up.dot(&d))
    }

    /// As wide as neighbouring planes leave room for.
    fn line_width(&self, model: &Model) -> f64 {
        let spacing = model.planes().interval()
            * self.scale
            * self.up.dot(&model.planes().guide().direction());
        (0.3 * spacing).clamp(0.5, 1.8)
    }

    /// The world's axes in the lower left corner, with their true length.
    fn write_axes(
        &self,
        model: &Model,
        options: &OverviewOptions,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let length = round_down(80.0 / self.scale);
        let origin = Point2::new(110.0, options.height - 110.0);
        let mut lowest = origin.y;
        let axes = [("X", Vector3::x()), ("Y", Vector3::y()), ("Z", Vector3::z())];
        for (name, axis) in axes {
            let d = axis * (length * self.scale);
            let tip = (origin.x + d.dot(&self.right), origin.y - d.dot(&self.up));
            let style = "stroke=\"#222\" stroke-width=\"1.4\"";
            canvas::line(out, (origin.x, origin.y), tip, style)?;
            let beyond = |from: f64, to: f64| from + 1.18 * (to - from);
            let at = (beyond(origin.x, tip.0), beyond(origin.y, tip.1) + 5.0);
            canvas::text(out, at, "text-anchor=\"middle\"", name)?;
            lowest = lowest.max(at.1);
        }
        let label = format!("each {} {}", tidy(length, length), model.unit());
        let at = (origin.x, lowest + 24.0);
        canvas::text(out, at, "text-anchor=\"middle\" font-size=\"14\" fill=\"#666\"", &label)
    }
}

fn first_point(model: &Model) -> Option<Point3> {
    let (index, section) = model.sections().next()?;
    let node = section.curves().next()?.nodes().first()?;
    Some(model.planes().frame(index).world_from_plane(&node.position))
}

/// What is drawn of one plane.
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
    let draw = |(index, section)| drawn_plane(model, camera, index, section, range);
    let mut planes: Vec<_> = model.sections().map(draw).collect();
    if camera.towards.dot(&model.planes().guide().direction()) < 0.0 {
        planes.reverse();
    }
    planes
}

/// First and last station that has curves.
fn station_range(model: &Model) -> (f64, f64) {
    let station = |(index, _)| model.planes().station(index);
    let first = model.sections().next().map(station);
    let last = model.sections().next_back().map(station);
    first.zip(last).unwrap_or((0.0, 0.0))
}

fn drawn_plane(
    model: &Model,
    camera: &Camera,
    index: PlaneIndex,
    section: &Section,
    (first, last): (f64, f64),
) -> DrawnPlane {
    let frame = model.planes().frame(index);
    let along = (model.planes().station(index) - first) / (last - first);
    let mut drawn = DrawnPlane {
        colour: Colour::ramp(if along.is_finite() { along } else { 0.0 }),
        area: PathData::new(STEPS),
        front: PathData::new(STEPS),
        back: PathData::new(STEPS),
    };
    let curves: Vec<&Curve> = section.curves().collect();
    let filled = regions::filled(&curves);
    for (number, curve) in curves.iter().enumerate() {
        let line = Line::of(curve, &frame, camera);
        if filled.contains(&number) {
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

/// A colour by red, green and blue from 0 to 255.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Colour([f64; 3]);

/// Viridis (van der Walt and Smith, 2015) without its light end, which would vanish on white: equal
/// steps look equally large, also to the colour-blind.
const RAMP: [[f64; 3]; 8] = [
    [68.0, 1.0, 84.0],
    [70.0, 50.0, 127.0],
    [54.0, 92.0, 141.0],
    [39.0, 127.0, 142.0],
    [31.0, 161.0, 135.0],
    [74.0, 194.0, 109.0],
    [122.0, 209.0, 81.0],
    [159.0, 201.0, 40.0],
];

impl Colour {
    /// The colour at a place of the ramp, from 0 to 1.
    pub(super) fn ramp(at: f64) -> Self {
        let at = at.clamp(0.0, 1.0) * (RAMP.len() - 1) as f64;
        let below = (at.floor() as usize).min(RAMP.len() - 2);
        let pair = RAMP.get(below).zip(RAMP.get(below + 1));
        let (low, high) = pair.unwrap_or((&[0.0; 3], &[0.0; 3]));
        let share = at - below as f64;
        let mut mixed = [0.0; 3];
        for (m, (a, b)) in mixed.iter_mut().zip(low.iter().zip(high)) {
            *m = a + (b - a) * share;
        }
        Self(mixed)
    }

    fn lightened(self, share: f64) -> Self {
        Self(self.0.map(|c| c + (255.0 - c) * share))
    }
}

impl std::fmt::Display for Colour {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [r, g, b] = self.0.map(|c| c.round() as u8);
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

fn write_heading(model: &Model, options: &OverviewOptions, out: &mut dyn Write) -> io::Result<()> {
    canvas::text(out, (40.0, 46.0), "font-size=\"26\" font-weight=\"bold\"", &options.title)?;
    let (planes, unit) = (model.sections().len(), model.unit());
    let interval = model.planes().interval();
    let open: usize = model.sections().map(|(_, s)| s.open_curve_count()).sum();
    let counts = format!(
        "{planes} planes every {} {unit} · {} curves, {open} of them open · {} nodes",
        tidy(interval, interval * 1e-3),
        model.curve_count(),
        model.node_count()
    );
    canvas::text(out, (40.0, 72.0), "fill=\"#555\"", &counts)
}

/// The colours by station, at the right edge.
fn write_ramp(model: &Model, options: &OverviewOptions, out: &mut dyn Write) -> io::Result<()> {
    let (x, top, height) = (options.width - 150.0, 140.0, options.height - 280.0);
    writeln!(out, "<linearGradient id=\"r\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">")?;
    for stop in 0..RAMP.len() {
        let at = stop as f64 / (RAMP.len() - 1) as f64;
        writeln!(out, "<stop offset=\"{at:.4}\" stop-color=\"{}\"/>", Colour::ramp(at))?;
    }
    writeln!(
        out,
        "</linearGradient><rect x=\"{x}\" y=\"{top}\" width=\"18\" height=\"{height}\" \
         fill=\"url(#r)\"/>"
    )?;
    let (first, last) = station_range(model);
    let unit = model.unit();
    canvas::text(out, (x, top - 16.0), "", &format!("station [{unit}]"))?;
    let labels = if last > first { 5 } else { 1 };
    for label in 0..labels {
        let at = f64::from(label) / f64::from(labels.max(2) - 1);
        let station = tidy(first + at * (last - first), model.planes().interval() * 1e-2);
        let y = top + height * (1.0 - at);
        canvas::line(out, (x + 18.0, y), (x + 24.0, y), "stroke=\"#222\"")?;
        canvas::text(out, (x + 30.0, y + 5.5), "", &station)?;
    }
    Ok(())
}
