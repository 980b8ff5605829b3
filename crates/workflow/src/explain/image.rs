//! Figures of a range image: the whole image as a raster, and a window of it pixel by pixel.

use super::palette;
use std::ops::Range;
use transect_device::{ImageSize, Pixel, View};
use transect_exchange::svg::{Anchor, Figure, Mark, Raster};
use transect_geometry::{Point2, Vector2};

/// Largest width and height of a drawing, in pixels of the figure. Chosen by hand: figure and
/// legend fit on a screen of 1280 × 720 px. Doubled, they do not.
const WIDTH: f64 = 880.0;
const HEIGHT: f64 = 560.0;

/// Largest side of a cell, in pixels of the figure. Chosen by hand: a code fits into a cell.
/// Doubled, windows of few cells fill the page.
const LARGEST_CELL: f64 = 30.0;

/// Rows and columns of a window that shows codes. Chosen by hand: cells are large enough for a
/// code. Doubled, the codes cannot be read.
pub const WINDOW: [usize; 2] = [20, 34];

/// Weight of the commoner of two things in the choice of a window. Chosen by hand: rare things come
/// first. Doubled, common things weigh twice as much.
const COMMON_SHARE: f64 = 0.1;

/// A part of an image, drawn with cells of one size.
#[derive(Debug, Clone)]
pub struct Window {
    pub rows: Range<usize>,
    pub cols: Range<usize>,
    /// Side of a cell.
    cell: f64,
}

impl Window {
    /// The whole image.
    pub fn whole(size: ImageSize) -> Self {
        Self::of(0..size.rows, 0..size.cols, 8.0)
    }

    fn of(rows: Range<usize>, cols: Range<usize>, largest: f64) -> Self {
        let cell = (WIDTH / cols.len().max(1) as f64).min(HEIGHT / rows.len().max(1) as f64);
        Self { rows, cols, cell: cell.min(largest) }
    }

    /// A window of a number of rows and columns around a pixel, inside the image.
    pub fn around(middle: Pixel, [rows, cols]: [usize; 2], size: ImageSize) -> Self {
        let range = |at: usize, count: usize, all: usize| {
            let count = count.min(all);
            let from = at.saturating_sub(count / 2).min(all - count);
            from..from + count
        };
        let rows = range(middle.row, rows, size.rows);
        Self::of(rows, range(middle.col, cols, size.cols), LARGEST_CELL)
    }

    /// The window of a size that has most of two things to show, and has them in its middle.
    /// `score` tells how much a pixel shows of either; the rarer one decides.
    pub fn best(size: ImageSize, shape: [usize; 2], score: impl Fn(Pixel) -> [f64; 2]) -> Self {
        // Sums over all pixels above and left of a place.
        let stride = size.cols + 1;
        let mut sums = vec![Vector2::zeros(); (size.rows + 1) * stride];
        for p in size.all_pixels() {
            let at = (p.row + 1) * stride + p.col + 1;
            let here = Vector2::from(score(p));
            sums[at] = here + sums[at - 1] + sums[at - stride] - sums[at - stride - 1];
        }
        let within = |window: &Self| {
            let at = |row: usize, col: usize| sums[row * stride + col];
            let (rows, cols) = (&window.rows, &window.cols);
            let sum = at(rows.end, cols.end) - at(rows.start, cols.end) - at(rows.end, cols.start)
                + at(rows.start, cols.start);
            sum.min() + COMMON_SHARE * sum.sum()
        };
        let every = |p: &Pixel| p.row.is_multiple_of(2) && p.col.is_multiple_of(2);
        let windows = size.all_pixels().filter(every).map(|p| Self::around(p, shape, size));
        let best = windows.map(|w| (within(&w), w)).max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, window)) = best else { return Self::whole(size) };
        let weighed = window.pixels().map(|p| (Vector2::from(score(p)).sum(), p));
        let mut middle = (0.0, Vector2::zeros());
        for (weight, p) in weighed {
            middle.0 += weight;
            middle.1 += Vector2::new(p.row as f64, p.col as f64) * weight;
        }
        let place = middle.1 / middle.0;
        if !place.sum().is_finite() {
            return window;
        }
        let middle = Pixel::new(place.x.round() as usize, place.y.round() as usize);
        Self::around(middle, shape, size)
    }

    /// Width and height of the drawing.
    pub fn size(&self) -> [f64; 2] {
        [self.cols.len() as f64 * self.cell, self.rows.len() as f64 * self.cell]
    }

    pub fn cell(&self) -> f64 {
        self.cell
    }

    pub fn contains(&self, p: Pixel) -> bool {
        self.rows.contains(&p.row) && self.cols.contains(&p.col)
    }

    /// The pixels of the window.
    pub fn pixels(&self) -> impl Iterator<Item = Pixel> + '_ {
        self.rows.clone().flat_map(|row| self.cols.clone().map(move |col| Pixel::new(row, col)))
    }

    /// The place of a row and a column; whole numbers are pixel centres.
    pub fn place(&self, row: f64, col: f64) -> Point2 {
        let along = |at: f64, from: usize| (at - from as f64 + 0.5) * self.cell;
        Point2::new(along(col, self.cols.start), along(row, self.rows.start))
    }

    pub fn centre(&self, p: Pixel) -> Point2 {
        self.place(p.row as f64, p.col as f64)
    }

    /// The place between two pixels of a window; `None` across the seam of a full circle.
    pub fn between(&self, [a, b]: [Pixel; 2], share: f64) -> Option<Point2> {
        let beside = a.row.abs_diff(b.row) <= 1 && a.col.abs_diff(b.col) <= 1;
        let [a, b] = [self.centre(a), self.centre(b)];
        beside.then(|| a + (b - a) * share)
    }

    /// Fills every pixel with a colour: in rectangles where pixels are large, which viewers do not
    /// blur.
    pub fn fill(&self, figure: &mut Figure, colour: impl Fn(Pixel) -> [u8; 3]) {
        if self.cell < LARGEST_CELL / 3.0 {
            return self.fill_raster(figure, colour);
        }
        let half = 0.5 * self.cell;
        for row in self.rows.clone() {
            let mut from = self.cols.start;
            while from < self.cols.end {
                let here = colour(Pixel::new(row, from));
                let same = |col: &usize| colour(Pixel::new(row, *col)) == here;
                let count = (from..self.cols.end).take_while(same).count();
                let at = self.place(row as f64, from as f64) - Vector2::new(half, half);
                let size = [count as f64 * self.cell + 0.3, self.cell + 0.3];
                let [r, g, b] = here;
                figure.rectangle(at, size, &format!("fill=\"#{r:02x}{g:02x}{b:02x}\""));
                from += count;
            }
        }
    }

    fn fill_raster(&self, figure: &mut Figure, colour: impl Fn(Pixel) -> [u8; 3]) {
        let [rows, cols] = [self.rows.len(), self.cols.len()];
        let at = |row, col| colour(Pixel::new(self.rows.start + row, self.cols.start + col));
        figure.raster(&Raster::new(rows, cols, at), Point2::origin(), self.size());
    }

    /// Lines between the pixels.
    pub fn grid(&self, figure: &mut Figure) {
        let ([width, height], thin) = (self.size(), "stroke=\"#ffffff\" stroke-width=\"0.8\"");
        for row in 1..self.rows.len() {
            let y = row as f64 * self.cell;
            figure.line(&[Point2::new(0.0, y), Point2::new(width, y)], false, thin);
        }
        for col in 1..self.cols.len() {
            let x = col as f64 * self.cell;
            figure.line(&[Point2::new(x, 0.0), Point2::new(x, height)], false, thin);
        }
    }

    /// The frame, with numbers of rows and columns.
    pub fn frame(&self, figure: &mut Figure) {
        let (size, frame) = (self.size(), "fill=\"none\" stroke=\"#222\"");
        figure.rectangle(Point2::origin(), size, frame);
        let numbers = |range: &Range<usize>| {
            let step = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000]
                .into_iter()
                .find(|step| range.len() / step <= 10)
                .unwrap_or(2000);
            range.clone().filter(move |k| k % step == 0).collect::<Vec<_>>()
        };
        for row in numbers(&self.rows) {
            let y = self.place(row as f64, 0.0).y + 4.0;
            figure.text(Point2::new(-6.0, y), Anchor::End, 12.0, "#555", &row.to_string());
        }
        for col in numbers(&self.cols) {
            let at = Point2::new(self.place(0.0, col as f64).x, size[1] + 15.0);
            figure.text(at, Anchor::Middle, 12.0, "#555", &col.to_string());
        }
        figure.text(Point2::new(-6.0, -7.0), Anchor::End, 12.0, "#555", "row");
        let at = Point2::new(0.5 * size[0], size[1] + 31.0);
        figure.text(at, Anchor::Middle, 12.0, "#555", "column");
    }

    /// The outline of another window in this one.
    pub fn outline(&self, figure: &mut Figure, other: &Self) {
        let half = |k: usize| k as f64 - 0.5;
        let at = self.place(half(other.rows.start), half(other.cols.start));
        let end = self.place(half(other.rows.end), half(other.cols.end));
        let style = format!("fill=\"none\" stroke=\"{}\" stroke-width=\"2.5\"", palette::FOUND);
        figure.rectangle(at, [end.x - at.x, end.y - at.y], &style);
    }

    /// The border between a pixel and the neighbour that its code compares it with.
    pub fn border(&self, p: Pixel, is_up: bool) -> [Point2; 2] {
        let (at, half) = (self.centre(p), 0.5 * self.cell);
        let corner = Point2::new(at.x - half, at.y - half);
        let along = if is_up { [self.cell, 0.0] } else { [0.0, self.cell] };
        [corner, Point2::new(corner.x + along[0], corner.y + along[1])]
    }
}

/// Draws a whole range image with its legend.
pub fn range_image(figure: &mut Figure, view: &View) {
    let size = view.image().size();
    let value = |p: Pixel| view.image().get(p).map(f64::from);
    let (window, shade) = (Window::whole(size), shades(size.all_pixels().filter_map(value)));
    window.fill(figure, |p| shade(value(p)));
    window.frame(figure);
    figure.legend(Mark::Area("#440154"), "smallest value: near");
    figure.legend(Mark::Area("#9fc928"), "largest value: far");
    figure.legend(Mark::Area(palette::MISSING), "missing pixel");
    figure.legend(Mark::Remark, format!("{} rows × {} columns", size.rows, size.cols));
}

/// The values of an image between dark (near) and light (far); `None` is missing.
pub fn shades(values: impl Iterator<Item = f64>) -> impl Fn(Option<f64>) -> [u8; 3] {
    let finite = values.filter(|v| v.is_finite());
    let (low, high) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (v.min(a), v.max(b)));
    move |value| match value {
        Some(v) if v.is_finite() => {
            Raster::shade(((v - low) / (high - low).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0))
        }
        _ => palette::rgb(palette::MISSING),
    }
}
