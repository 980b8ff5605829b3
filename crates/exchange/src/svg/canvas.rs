//! Elements of an SVG file.

use std::fmt::Write as _;
use std::io::{self, Write};
use transect_geometry::Point2;

/// Widths of the four sides around a drawing.
pub(super) struct Margins {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

/// The data of a path: whole multiples of a step, each relative to the one before.
pub(super) struct PathData {
    text: String,
    steps_per_unit: f64,
    last: (i64, i64),
}

impl PathData {
    /// A path in a group that is scaled by one over `steps_per_unit`.
    pub(super) fn new(steps_per_unit: f64) -> Self {
        Self { text: String::new(), steps_per_unit, last: (0, 0) }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.text.is_empty()
    }

    fn quantised(&self, p: &Point2) -> (i64, i64) {
        let whole = |c: f64| (c * self.steps_per_unit).round() as i64;
        (whole(p.x), whole(p.y))
    }

    pub(super) fn move_to(&mut self, p: &Point2) {
        self.last = self.quantised(p);
        // Writing into a String cannot fail.
        let _ = write!(self.text, "M{} {}l", self.last.0, self.last.1);
    }

    pub(super) fn line_to(&mut self, p: &Point2) {
        let (x, y) = self.quantised(p);
        let (dx, dy) = (x - self.last.0, y - self.last.1);
        if (dx, dy) == (0, 0) {
            return;
        }
        self.last = (x, y);
        // A minus sign separates two numbers, so the blank can be left out.
        let before = if dx < 0 || self.text.ends_with('l') { "" } else { " " };
        let between = if dy < 0 { "" } else { " " };
        let _ = write!(self.text, "{before}{dx}{between}{dy}");
    }

    pub(super) fn close(&mut self) {
        self.finish();
        self.text.push('z');
    }

    /// Ends a line. A line without a second point becomes a dot of zero length.
    pub(super) fn finish(&mut self) {
        if self.text.ends_with('l') {
            self.text.push_str("0 0");
        }
    }

    /// A whole line through points.
    pub(super) fn polyline<'a>(
        &mut self,
        points: impl IntoIterator<Item = &'a Point2>,
        closed: bool,
    ) {
        let mut points = points.into_iter();
        let Some(first) = points.next() else { return };
        self.move_to(first);
        points.for_each(|p| self.line_to(p));
        if closed { self.close() } else { self.finish() }
    }

    /// Writes the element; an empty path writes no element.
    pub(super) fn write(&self, attributes: &str, out: &mut dyn Write) -> io::Result<()> {
        if self.is_empty() {
            return Ok(());
        }
        writeln!(out, "<path {attributes} d=\"{}\"/>", self.text)
    }
}

/// Text at a place, with `&`, `<`, `>` escaped.
pub(super) fn text(
    out: &mut dyn Write,
    at: (f64, f64),
    attributes: &str,
    content: &str,
) -> io::Result<()> {
    let (x, y) = at;
    writeln!(out, "<text x=\"{x:.2}\" y=\"{y:.2}\" {attributes}>{}</text>", escaped(content))
}

pub(super) fn line(
    out: &mut dyn Write,
    from: (f64, f64),
    to: (f64, f64),
    attributes: &str,
) -> io::Result<()> {
    let ((x1, y1), (x2, y2)) = (from, to);
    writeln!(
        out,
        "<line x1=\"{x1:.2}\" y1=\"{y1:.2}\" x2=\"{x2:.2}\" y2=\"{y2:.2}\" {attributes}/>"
    )
}

pub(super) fn escaped(content: &str) -> String {
    content.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
