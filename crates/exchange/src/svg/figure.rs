//! Figures of single steps: a heading, a sentence, a drawing in pixels, and a legend beside it.

use super::canvas::{self, PathData, escaped};
use super::raster::Raster;
use super::ruler::{round_down, tidy};
use super::simplify::simplified;
use std::fmt::Write as _;
use std::io::{self, Write};
use transect_geometry::Point2;

/// Free space left of the drawing, and around everything, in pixels. Chosen by hand,
/// for the look of the page. Doubled, the page is wider.
const LEFT: f64 = 56.0;
const EDGE: f64 = 28.0;
/// Width of the legend in pixels, and characters that fit into one of its lines. Chosen by hand:
/// 36 characters of 15 px are 8 px wide or less. More characters run out of the page.
const LEGEND: f64 = 300.0;
const LEGEND_CHARACTERS: usize = 36;
/// Height of a line of text, in pixels. Chosen by hand: 1.4 times the size of the letters.
/// Doubled, legends are twice as high.
const LINE: f64 = 21.0;
/// Width of a drawing from which on the legend stands below it, in pixels. Chosen by hand: a page
/// with a legend beside such a drawing would be too wide to read on a screen.
const WIDE: f64 = 1000.0;
/// Steps of the coordinates of a path per pixel, and the distance in pixels by which a vertex must
/// move the path to stay in it.
const STEPS: f64 = 20.0;
const TOLERANCE: f64 = 0.1;

/// A figure with a legend. Places are in pixels from the drawing's upper left corner, y down.
///
/// Attributes are those of SVG, such as `stroke="#222" fill="none"`.
#[derive(Debug, Clone)]
pub struct Figure {
    title: String,
    caption: String,
    /// Width and height of the drawing.
    size: [f64; 2],
    body: String,
    legend: Vec<(Mark, String)>,
}

/// The sign of an entry in a legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A line of a colour.
    Line(&'static str),
    /// A dashed line of a colour.
    Dashed(&'static str),
    /// A dot of a colour.
    Dot(&'static str),
    /// An area of a colour.
    Area(&'static str),
    /// A text, such as a number that stands in the drawing.
    Text(&'static str),
    /// No sign: a remark.
    Remark,
}

/// Which part of a text stands at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Its beginning.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

impl Figure {
    /// A figure whose drawing has a width and a height, with a sentence below its heading.
    pub fn new(title: impl Into<String>, caption: impl Into<String>, size: [f64; 2]) -> Self {
        let (title, caption) = (title.into(), caption.into());
        Self { title, caption, size, body: String::new(), legend: Vec::new() }
    }

    /// The heading.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The sentence below the heading.
    pub fn caption(&self) -> &str {
        &self.caption
    }

    /// Adds an entry to the legend.
    pub fn legend(&mut self, mark: Mark, text: impl Into<String>) {
        self.legend.push((mark, text.into()));
    }

    /// Draws a line through points; a closed one returns to its first point.
    pub fn line<'a>(
        &mut self,
        points: impl IntoIterator<Item = &'a Point2>,
        closed: bool,
        attributes: &str,
    ) {
        let element = if closed { "polygon" } else { "polyline" };
        let _ = write!(self.body, "<{element} points=\"");
        for p in points {
            let _ = write!(self.body, "{:.2},{:.2} ", p.x, p.y);
        }
        let _ = writeln!(self.body, "\" {attributes}/>");
    }

    /// Draws lines and rings as one path with a width in pixels. Where it is filled, a ring that
    /// runs clockwise is a hole. Vertices that would not move the path visibly are left out.
    pub fn path(&mut self, lines: &[(Vec<Point2>, bool)], width: f64, attributes: &str) {
        let mut path = PathData::new(STEPS);
        for (points, closed) in lines {
            let kept = simplified(points, *closed, TOLERANCE);
            path.polyline(kept.iter().filter_map(|&k| points.get(k)), *closed);
        }
        let mut element = Vec::new();
        let style =
            format!("transform=\"scale({})\" stroke-width=\"{:.0}\"", 1.0 / STEPS, width * STEPS);
        // Writing into memory cannot fail.
        let _ =
            path.write(&format!("{style} stroke-linejoin=\"round\" {attributes}"), &mut element);
        self.body += &String::from_utf8_lossy(&element);
    }

    /// Draws a circle.
    pub fn circle(&mut self, at: Point2, radius: f64, attributes: &str) {
        let (x, y) = (at.x, at.y);
        let circle = format!("cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.2}\"");
        let _ = writeln!(self.body, "<circle {circle} {attributes}/>");
    }

    /// Draws a rectangle by its upper left corner.
    pub fn rectangle(&mut self, at: Point2, [width, height]: [f64; 2], attributes: &str) {
        let corner = format!("x=\"{:.2}\" y=\"{:.2}\"", at.x, at.y);
        let size = format!("width=\"{width:.2}\" height=\"{height:.2}\"");
        let _ = writeln!(self.body, "<rect {corner} {size} {attributes}/>");
    }

    /// Draws a line with a head at its end.
    pub fn arrow(&mut self, from: Point2, to: Point2, width: f64, colour: &str) {
        let Some(along) = (to - from).try_normalize(0.0) else { return };
        let across = transect_geometry::Vector2::new(-along.y, along.x);
        let neck = to - along * (4.0 * width);
        let style = format!("stroke=\"{colour}\" stroke-width=\"{width}\" fill=\"none\"");
        self.line([&from, &neck], false, &style);
        let head = [to, neck + across * (2.0 * width), neck - across * (2.0 * width)];
        self.line(&head, true, &format!("fill=\"{colour}\""));
    }

    /// Writes a text of a size in pixels.
    pub fn text(&mut self, at: Point2, anchor: Anchor, size: f64, colour: &str, content: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let style = format!("text-anchor=\"{anchor}\" font-size=\"{size:.1}\" fill=\"{colour}\"");
        let (x, y, content) = (at.x, at.y, escaped(content));
        let _ = writeln!(self.body, "<text x=\"{x:.2}\" y=\"{y:.2}\" {style}>{content}</text>");
    }

    /// Draws a raster, stretched to a width and a height.
    pub fn raster(&mut self, raster: &Raster, at: Point2, [width, height]: [f64; 2]) {
        let Some(address) = raster.data_address() else { return };
        let corner = format!("x=\"{:.2}\" y=\"{:.2}\"", at.x, at.y);
        let size = format!("width=\"{width:.2}\" height=\"{height:.2}\"");
        let _ = writeln!(
            self.body,
            "<image {corner} {size} preserveAspectRatio=\"none\" \
             style=\"image-rendering:pixelated\" href=\"{address}\"/>"
        );
    }

    /// Draws a bar of a round length, at most so many pixels long, with its label beside it.
    pub fn scale_bar(&mut self, at: Point2, [scale, longest]: [f64; 2], unit: &str) {
        let length = round_down(longest / scale);
        let end = Point2::new(at.x + length * scale, at.y);
        let style = "stroke=\"#222\" stroke-width=\"1.4\"";
        self.line(&[at, end], false, style);
        for x in [at.x, end.x] {
            self.line(&[Point2::new(x, at.y - 4.0), Point2::new(x, at.y + 4.0)], false, style);
        }
        let label = format!("{} {unit}", tidy(length, length));
        self.text(Point2::new(end.x + 10.0, at.y + 5.0), Anchor::Start, 14.0, "#222", &label);
    }

    /// Draws only what lies in a rectangle, as long as `draw` draws.
    pub fn clipped(&mut self, at: Point2, size: [f64; 2], draw: impl FnOnce(&mut Self)) {
        let name = format!("clip{}", self.body.len());
        let _ = writeln!(self.body, "<clipPath id=\"{name}\">");
        self.rectangle(at, size, "");
        let _ = writeln!(self.body, "</clipPath><g clip-path=\"url(#{name})\">");
        draw(self);
        let _ = writeln!(self.body, "</g>");
    }

    /// Makes what `draw` draws appear at a time and stay, in a picture that repeats.
    pub fn appearing(&mut self, [at, of]: [f64; 2], draw: impl FnOnce(&mut Self)) {
        let share = at / of;
        let _ = writeln!(
            self.body,
            "<g opacity=\"1\"><animate attributeName=\"opacity\" dur=\"{of}s\" calcMode=\"discrete\" \
             repeatCount=\"indefinite\" keyTimes=\"0;{share:.4};1\" values=\"0;1;1\"/>"
        );
        draw(self);
        let _ = writeln!(self.body, "</g>");
    }

    /// Writes the figure as an SVG file.
    ///
    /// # Errors
    /// An error of `out`.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let is_wide = self.size[0] >= WIDE;
        let beside = if is_wide { 0.0 } else { EDGE + LEGEND };
        let width = LEFT + self.size[0] + beside + EDGE;
        let caption = wrapped(&self.caption, ((width - 2.0 * EDGE) / 7.6) as usize);
        let top = EDGE + 30.0 + LINE * caption.len() as f64 + 32.0;
        let entries: Vec<_> = self
            .legend
            .iter()
            .map(|(mark, text)| (mark, wrapped(text, LEGEND_CHARACTERS)))
            .collect();
        let columns = if is_wide { (self.size[0] / (LEGEND + EDGE)) as usize } else { 1 };
        let parts: Vec<_> = entries.chunks(entries.len().div_ceil(columns).max(1)).collect();
        let legend = parts.iter().map(|part| legend_height(part)).fold(0.0, f64::max);
        let (legend_at, bottom) = match is_wide {
            true => ((LEFT, top + self.size[1] + EDGE), top + self.size[1] + EDGE + legend),
            false => ((LEFT + self.size[0] + EDGE, top), top + self.size[1].max(legend + LINE)),
        };
        let height = bottom + 1.6 * EDGE;
        writeln!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" \
             viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"Helvetica, Arial, sans-serif\" \
             font-size=\"15\" fill=\"#222\">\n<title>{}</title>\n\
             <rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"#fff\"/>",
            escaped(&self.title)
        )?;
        let heading = "font-size=\"24\" font-weight=\"bold\"";
        canvas::text(out, (EDGE, EDGE + 22.0), heading, &self.title)?;
        for (line, y) in caption.iter().zip(0..) {
            let at = (EDGE, EDGE + 50.0 + LINE * f64::from(y));
            canvas::text(out, at, "fill=\"#555\"", line)?;
        }
        writeln!(out, "<g transform=\"translate({LEFT:.2} {top:.2})\">\n{}</g>", self.body)?;
        for (part, column) in parts.iter().zip(0..) {
            let x = legend_at.0 + f64::from(column) * (LEGEND + EDGE);
            write_legend(part, (x, legend_at.1), out)?;
        }
        writeln!(out, "</svg>")
    }
}

fn legend_height(entries: &[(&Mark, Vec<String>)]) -> f64 {
    entries.iter().map(|(_, lines)| LINE * lines.len() as f64 + 9.0).sum()
}

fn write_legend(
    entries: &[(&Mark, Vec<String>)],
    (x, top): (f64, f64),
    out: &mut dyn Write,
) -> io::Result<()> {
    let mut y = top + 14.0;
    for (mark, lines) in entries {
        let middle = y - 5.0;
        let ends = ((x, middle), (x + 26.0, middle));
        match mark {
            Mark::Line(colour) => {
                canvas::line(
                    out,
                    ends.0,
                    ends.1,
                    &format!("stroke=\"{colour}\" stroke-width=\"3\""),
                )?;
            }
            Mark::Dashed(colour) => {
                let dashes = "stroke-width=\"2.5\" stroke-dasharray=\"6 4\"";
                canvas::line(out, ends.0, ends.1, &format!("stroke=\"{colour}\" {dashes}"))?;
            }
            Mark::Dot(colour) => {
                let at = format!("cx=\"{:.2}\" cy=\"{middle:.2}\"", x + 13.0);
                writeln!(out, "<circle {at} r=\"5\" fill=\"{colour}\"/>")?;
            }
            Mark::Area(colour) => {
                let at = format!("x=\"{x:.2}\" y=\"{:.2}\"", middle - 8.0);
                let style = format!("fill=\"{colour}\" stroke=\"#999\"");
                writeln!(out, "<rect {at} width=\"26\" height=\"16\" {style}/>")?;
            }
            Mark::Text(text) => {
                let style = "text-anchor=\"middle\" font-weight=\"bold\"";
                canvas::text(out, (x + 13.0, y), style, text)?;
            }
            Mark::Remark => (),
        }
        let indent = if **mark == Mark::Remark { 0.0 } else { 36.0 };
        for line in lines {
            canvas::text(out, (x + indent, y), "", line)?;
            y += LINE;
        }
        y += 9.0;
    }
    Ok(())
}

/// Lines of at most so many characters, broken between words.
fn wrapped(text: &str, characters: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let fits =
            |line: &&mut String| line.chars().count() + 1 + word.chars().count() <= characters;
        match lines.last_mut().filter(fits) {
            Some(line) => {
                line.push(' ');
                line.push_str(word);
            }
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_has_its_heading_its_legend_and_whole_elements() {
        let mut figure = Figure::new("1 · A <title>", "One sentence & another.", [200.0, 100.0]);
        for mark in [Mark::Line("#111"), Mark::Dashed("#222"), Mark::Dot("#333")] {
            figure.legend(mark, "a text that is longer than one line of the legend can hold");
        }
        figure.legend(Mark::Area("#444"), "an area");
        figure.legend(Mark::Text("3"), "a code");
        figure.clipped(Point2::origin(), [50.0, 50.0], |figure| {
            figure.line(&[Point2::new(0.0, 0.0), Point2::new(9.0, 9.0)], false, "stroke=\"#222\"");
        });
        figure.appearing([1.0, 4.0], |f| {
            f.arrow(Point2::origin(), Point2::new(9.0, 0.0), 2.0, "#f00")
        });
        figure.raster(
            &Raster::new(2, 2, |r, _| Raster::shade(r as f64)),
            Point2::origin(),
            [9.0; 2],
        );
        let mut out = Vec::new();
        figure.write(&mut out).unwrap();
        let svg = String::from_utf8(out).unwrap();
        assert!(svg.contains("1 · A &lt;title&gt;") && svg.contains("One sentence &amp; another."));
        assert!(svg.contains("keyTimes=\"0;0.2500;1\""));
        let opened =
            svg.matches('<').count() - svg.matches("</").count() - svg.matches("/>").count();
        assert_eq!(opened, svg.matches("</").count());
        assert!(!svg.contains("NaN"), "{svg}");
        assert!(wrapped("a text that is longer than ten", 10).iter().all(|l| l.len() <= 10));
    }

    #[test]
    fn a_path_keeps_the_vertices_that_move_it() {
        let mut figure = Figure::new("", "", [100.0; 2]);
        let line = [[0.0, 0.0], [5.0, 0.01], [10.0, 0.0], [10.0, 10.0]].map(Point2::from).to_vec();
        figure.path(&[(line, true), (Vec::new(), false)], 2.0, "fill=\"none\"");
        assert!(figure.body.contains("stroke-width=\"40\""), "{}", figure.body);
        assert!(figure.body.contains("d=\"M0 0l200 0 0 200z\""), "{}", figure.body);
    }

    #[test]
    fn the_legend_of_a_wide_figure_is_below_it() {
        let place = |width: f64| {
            let mut figure = Figure::new("", "", [width, 50.0]);
            figure.legend(Mark::Remark, "here");
            let mut out = Vec::new();
            figure.write(&mut out).unwrap();
            let svg = String::from_utf8(out).unwrap();
            let (before, _) = svg.split_once("\" >here<").unwrap();
            let y = before.rsplit_once("y=\"").unwrap().1.to_owned();
            y.parse::<f64>().unwrap()
        };
        assert!(place(WIDE) > place(WIDE - 1.0) + 50.0);
    }
}
