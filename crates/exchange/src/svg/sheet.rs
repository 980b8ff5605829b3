//! One A3 sheet per plane, true to scale.
//!
//! Plane coordinates are drawn x to the right and y up, seen against the plane's normal, so that
//! the solid is on the left of every curve. All sheets of a model have the same scale and window:
//! leafing through them shows what changes. Known solid is filled ([`Section::known_solid`]); other
//! curves have ticks on their solid side; dots mark open ends.

use super::canvas::{self, PathData};
use super::ruler::{round_down, round_up, tidy, vector};
use super::simplify::simplified;
use std::io::{self, Write};
use transect_geometry::{Curve, Envelope, PlaneIndex, Point2, Vector2};
use transect_model::{CurveIndex, Model, Section};

/// Width and height of the paper, in millimetres. Source: ISO 216, A3 in landscape. On other paper
/// the stated scale is wrong.
const PAPER_WIDTH: f64 = 420.0;
const PAPER_HEIGHT: f64 = 297.0;
/// The drawing's window on the paper, in millimetres. Chosen by hand: the numbers of the grid stand
/// left of it, the title and the scale below. A larger window covers them.
const LEFT: f64 = 26.0;
const TOP: f64 = 12.0;
const RIGHT: f64 = 408.0;
const BOTTOM: f64 = 256.0;
const WIDTH: f64 = RIGHT - LEFT;
const HEIGHT: f64 = BOTTOM - TOP;
/// Least part of the window's sides that stays free around the curves. Chosen by hand: ticks of
/// outer curves stay inside. Doubled, drawings are a tenth smaller.
const FREE: f64 = 0.04;
/// Drawings smaller than this many millimetres are enlarged. Chosen by hand: a quarter of the
/// window. Doubled, fewer parts are drawn at their own size.
const SMALLEST: f64 = 60.0;
/// Steps of drawn coordinates per millimetre. Theory: 0.01 mm is a tenth of the thinnest line.
/// Doubled, files are larger.
const STEPS: f64 = 100.0;
/// Vertices that move a line by less than this many millimetres are left out. Theory: 0.1 px of
/// 96 dpi, a quarter of the thinnest line. Doubled, bends look like corners.
const TOLERANCE: f64 = 0.026;
/// Distance between the ticks on the solid side, and their length, in millimetres. Chosen by hand:
/// ticks are apart from each other, and short curves have some. Doubled, small holes have none.
const TICK_SPACING: f64 = 3.0;
const TICK_LENGTH: f64 = 1.6;
/// Least distance of grid lines on paper, in millimetres. Chosen by hand: the numbers beside the
/// lines do not touch. Doubled, large sheets have few lines.
const GRID: f64 = 20.0;

/// The common scale and window of a model's sheets.
#[derive(Debug, Clone)]
pub struct Sheets<'a> {
    model: &'a Model,
    /// Millimetres on paper per length unit.
    mm_per_unit: f64,
    /// Scale as 1 : reduction; below 1 for an enlargement.
    reduction: f64,
    /// Plane coordinates of the window's centre.
    centre: Point2,
}

impl<'a> Sheets<'a> {
    /// Chooses scale and window: 1:1 if the model fits and is not tiny, else the next 1, 2 or 5
    /// times a power of ten.
    pub fn new(model: &'a Model) -> Self {
        let nothing = Envelope { min: Point2::origin(), max: Point2::origin() };
        let envelope = model.envelope().unwrap_or(nothing);
        let mm = envelope.size() * (model.unit().in_metres() * 1000.0);
        let free = 1.0 - 2.0 * FREE;
        let needed = (mm.x / (WIDTH * free)).max(mm.y / (HEIGHT * free));
        let reduction = match needed {
            n if n > 1.0 => round_up(n),
            n if n > 0.0 && mm.amax() < SMALLEST => round_up(n),
            _ => 1.0,
        };
        Self {
            model,
            mm_per_unit: model.unit().in_metres() * 1000.0 / reduction,
            reduction,
            centre: envelope.min + envelope.size() * 0.5,
        }
    }

    /// The scale as drawings state it, such as `1:50`.
    pub fn scale(&self) -> String {
        if self.reduction >= 1.0 {
            format!("1:{}", tidy(self.reduction, 1.0))
        } else {
            format!("{}:1", tidy(1.0 / self.reduction, 1.0))
        }
    }

    /// Writes the sheet of one plane. A plane without curves gives a sheet with 0 curves in its
    /// legend.
    ///
    /// # Errors
    /// An error of `out`.
    pub fn write(&self, plane: PlaneIndex, out: &mut dyn Write) -> io::Result<()> {
        let (width, height) = (PAPER_WIDTH, PAPER_HEIGHT);
        writeln!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"Helvetica, Arial, sans-serif\" \
             font-size=\"3.2\" fill=\"#222\">"
        )?;
        let number = plane.0;
        let station = self.station(plane);
        let unit = self.model.unit();
        writeln!(out, "<title>Section plane {number}, station {station} {unit}</title>")?;
        writeln!(out, "<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>")?;
        self.write_grid(out)?;
        let section = self.model.section(plane);
        if let Some(section) = section {
            self.write_curves(section, out)?;
        }
        self.write_frame(out)?;
        self.write_legend(plane, section, out)?;
        writeln!(out, "</svg>")
    }

    fn station(&self, plane: PlaneIndex) -> String {
        let planes = self.model.planes();
        tidy(planes.station(plane), planes.interval() * 1e-3)
    }

    /// Place on paper, in millimetres.
    fn on_paper(&self, p: &Point2) -> Point2 {
        let d = (p - self.centre) * self.mm_per_unit;
        Point2::new(0.5 * (LEFT + RIGHT) + d.x, 0.5 * (TOP + BOTTOM) - d.y)
    }

    fn write_curves(&self, section: &Section, out: &mut dyn Write) -> io::Result<()> {
        let curves: Vec<&Curve> = section.curves().collect();
        let lines: Vec<Vec<Point2>> = curves.iter().map(|c| self.line(c)).collect();
        let filled = section.known_solid();
        let (mut area, mut outline) = (PathData::new(STEPS), PathData::new(STEPS));
        let (mut ticks, mut ends) = (PathData::new(STEPS), PathData::new(STEPS));
        for (number, (curve, line)) in curves.iter().zip(&lines).enumerate() {
            outline.polyline(line, curve.is_closed());
            if filled.contains(&CurveIndex(number)) {
                area.polyline(line, true);
            } else {
                add_ticks(line, curve.is_closed(), &mut ticks);
            }
            let open_ends = [line.first(), line.last()].into_iter().flatten();
            for end in open_ends.filter(|_| !curve.is_closed()) {
                ends.polyline([end], false);
            }
        }
        writeln!(
            out,
            "<clipPath id=\"w\"><rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{WIDTH}\" \
             height=\"{HEIGHT}\"/></clipPath>\n<g clip-path=\"url(#w)\">\
             <g transform=\"scale({})\" stroke-linejoin=\"round\" stroke-linecap=\"round\">",
            1.0 / STEPS
        )?;
        area.write("fill=\"#dbe7f3\" fill-rule=\"nonzero\"", out)?;
        ticks.write("fill=\"none\" stroke=\"#7d9cbc\" stroke-width=\"20\"", out)?;
        outline.write("fill=\"none\" stroke=\"#12304f\" stroke-width=\"35\"", out)?;
        ends.write("fill=\"none\" stroke=\"#d1495b\" stroke-width=\"120\"", out)?;
        writeln!(out, "</g></g>")
    }

    /// A curve on paper, without the vertices that make no visible difference.
    fn line(&self, curve: &Curve) -> Vec<Point2> {
        let points: Vec<Point2> =
            curve.nodes().iter().map(|n| self.on_paper(&n.position)).collect();
        let kept = simplified(&points, curve.is_closed(), TOLERANCE);
        kept.iter().filter_map(|&i| points.get(i).copied()).collect()
    }

    /// Distance of grid lines, in the length unit.
    fn grid_step(&self) -> f64 {
        round_up(GRID / self.mm_per_unit)
    }

    fn write_grid(&self, out: &mut dyn Write) -> io::Result<()> {
        let thin = "stroke=\"#e4e4e4\" stroke-width=\"0.15\"";
        for (label, x) in self.grid_lines(self.centre.x, WIDTH) {
            let x = 0.5 * (LEFT + RIGHT) + x;
            canvas::line(out, (x, TOP), (x, BOTTOM), thin)?;
            let style = "text-anchor=\"middle\" font-size=\"2.8\"";
            canvas::text(out, (x, BOTTOM + 4.5), style, &label)?;
        }
        for (label, y) in self.grid_lines(self.centre.y, HEIGHT) {
            let y = 0.5 * (TOP + BOTTOM) - y;
            canvas::line(out, (LEFT, y), (RIGHT, y), thin)?;
            let style = "text-anchor=\"end\" font-size=\"2.8\"";
            canvas::text(out, (LEFT - 1.5, y + 1.0), style, &label)?;
        }
        Ok(())
    }

    /// Labels of the grid lines across a window, with their distance from its centre on paper.
    fn grid_lines(&self, centre: f64, width: f64) -> Vec<(String, f64)> {
        let step = self.grid_step();
        let half = 0.5 * width / self.mm_per_unit;
        let first = ((centre - half) / step).ceil();
        let count = ((centre + half) / step).floor() - first;
        // At least 20 mm apart, so that no window has more than a few dozen.
        let numbers = (0..=count.clamp(0.0, 100.0) as u32).map(|i| first + f64::from(i));
        let line = |n: f64| (tidy(n * step, step), (n * step - centre) * self.mm_per_unit);
        numbers.map(line).collect()
    }

    fn write_frame(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "<rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"none\" \
             stroke=\"#222\" stroke-width=\"0.3\"/>"
        )?;
        let unit = self.model.unit();
        let (centre, middle) = (0.5 * (LEFT + RIGHT), 0.5 * (TOP + BOTTOM));
        let turned = format!("text-anchor=\"middle\" transform=\"rotate(-90 8 {middle})\"");
        let x_label = format!("x [{unit}]");
        canvas::text(out, (centre, BOTTOM + 9.5), "text-anchor=\"middle\"", &x_label)?;
        canvas::text(out, (8.0, middle), &turned, &format!("y [{unit}]"))
    }

    fn write_legend(
        &self,
        plane: PlaneIndex,
        section: Option<&Section>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let (number, unit) = (plane.0, self.model.unit());
        let (row_1, row_2, row_3) = (275.0, 281.5, 287.0);
        let number = tidy(number as f64, 1.0);
        let title = format!("Section plane {number} · station {} {unit}", self.station(plane));
        canvas::text(out, (26.0, row_1), "font-size=\"5\" font-weight=\"bold\"", &title)?;
        let open = section.map_or(0, Section::open_curve_count);
        let closed = section.map_or(0, |s| s.curves().len()) - open;
        let count = format!("{closed} closed and {open} open curves · lengths in {unit}");
        canvas::text(out, (26.0, row_2), "", &count)?;
        let key = "blue area or ticks: solid side · red dots: open ends";
        canvas::text(out, (26.0, row_3), "fill=\"#666\"", key)?;
        let frame = self.model.planes().frame(plane);
        let (x, y) = (vector(&frame.x_axis()), vector(&frame.y_axis()));
        canvas::text(out, (190.0, row_2), "", &format!("x = world {x} · y = world {y}"))?;
        let normal = format!("seen against the normal, world {}", vector(&frame.normal()));
        canvas::text(out, (190.0, row_3), "fill=\"#666\"", &normal)?;
        self.write_scale_bar((408.0, row_2), out)
    }

    /// A bar that ends at a place, with the scale above it.
    fn write_scale_bar(&self, (right, y): (f64, f64), out: &mut dyn Write) -> io::Result<()> {
        let length = round_down(60.0 / self.mm_per_unit);
        let mm = length * self.mm_per_unit;
        let label = format!("{} {}", tidy(length, length), self.model.unit());
        let scale = format!("scale {}", self.scale());
        canvas::text(out, (right, y - 6.5), "text-anchor=\"end\" font-size=\"5\"", &scale)?;
        let bold = "stroke=\"#222\" stroke-width=\"0.8\"";
        let thin = "stroke=\"#222\" stroke-width=\"0.3\"";
        canvas::line(out, (right - mm, y), (right, y), thin)?;
        canvas::line(out, (right - mm, y), (right - 0.5 * mm, y), bold)?;
        for x in [right - mm, right - 0.5 * mm, right] {
            canvas::line(out, (x, y - 1.0), (x, y + 1.0), thin)?;
        }
        canvas::text(out, (right, y + 5.0), "text-anchor=\"end\"", &label)
    }
}

/// Short strokes on the left of a line, which is its solid side; paper has y down.
fn add_ticks(line: &[Point2], closed: bool, ticks: &mut PathData) {
    let mut ahead = 0.5 * TICK_SPACING;
    let closing = line.first().filter(|_| closed);
    let ends = line.iter().skip(1).chain(closing);
    for (a, b) in line.iter().zip(ends) {
        let d = b - a;
        let unit_length = d.norm();
        let Some(along) = d.try_normalize(0.0) else { continue };
        // Left of the direction, leaning back by 45° so that ticks do not look like a wall.
        let tick = (Vector2::new(along.y, -along.x) - along) * (TICK_LENGTH * 0.5f64.sqrt());
        while ahead <= unit_length {
            let foot = a + along * ahead;
            ticks.polyline([&foot, &(foot + tick)], false);
            ahead += TICK_SPACING;
        }
        ahead -= unit_length;
    }
}
