//! The sweep: row by row, pairs emit crossings and cells link them.

use super::cell::{self, Corner, Shape};
use super::crossing::{Base, Crossing, solve};
use transect_device::{Pixel, View};
use transect_partial::SectionAxes;
use transect_partial::one_pass::Seen;

/// No crossing.
pub(super) const NONE: u32 = u32::MAX;

/// All crossings of a view, each knowing the one that follows it.
#[derive(Debug, Default)]
pub(super) struct Linked {
    pub crossings: Vec<Crossing>,
    /// Number of the crossing that follows, or [`NONE`].
    pub next: Vec<u32>,
    /// Whether a crossing follows another one.
    pub has_previous: Vec<bool>,
}

/// What is kept of one row of pixels.
#[derive(Debug, Clone)]
struct Row {
    /// Level of each pixel, NaN where missing.
    levels: Vec<f32>,
    /// `ceil` of the level; plane k sees a pixel high if its ceiling exceeds k.
    ceilings: Vec<i32>,
    /// Each pixel's pair with its left neighbour.
    left: Pairs,
    /// Each pixel's pair with the one above.
    up: Pairs,
}

#[derive(Debug, Clone)]
struct Pairs {
    unbroken: Vec<bool>,
    bases: Vec<Base>,
}

impl Row {
    fn new(cols: usize) -> Self {
        let pairs = Pairs { unbroken: vec![false; cols], bases: vec![Base::NONE; cols] };
        let (levels, ceilings) = (vec![f32::NAN; cols], vec![0; cols]);
        Self { levels, ceilings, left: pairs.clone(), up: pairs }
    }
}

/// Finds and links all crossings of a view.
pub(super) fn sweep(view: &View, axes: &SectionAxes, seen: &Seen) -> Linked {
    let size = view.frame().size();
    let mut sweep = Sweep { view, axes, seen, linked: Linked::default() };
    let (mut above, mut row) = (Row::new(size.cols), Row::new(size.cols));
    for i in 0..size.rows {
        sweep.read_row(i, &mut row);
        sweep.emit(i, &above, &mut row);
        sweep.linked.grow();
        if i > 0 {
            sweep.link_cells(i, &above, &row);
        }
        std::mem::swap(&mut above, &mut row);
    }
    sweep.linked
}

struct Sweep<'a> {
    view: &'a View,
    axes: &'a SectionAxes,
    seen: &'a Seen,
    linked: Linked,
}

impl Sweep<'_> {
    fn read_row(&mut self, i: usize, row: &mut Row) {
        let cols = row.levels.len();
        let here = i * cols..(i + 1) * cols;
        row.levels.copy_from_slice(&self.seen.levels[here.clone()]);
        for (ceiling, level) in row.ceilings.iter_mut().zip(&row.levels) {
            *ceiling = level.ceil() as i32;
        }
        row.left.unbroken.copy_from_slice(&self.seen.left[here.clone()]);
        row.up.unbroken.copy_from_slice(&self.seen.up[here]);
    }

    /// Numbers and solves the crossings of all pairs of a row.
    fn emit(&mut self, i: usize, above: &Row, row: &mut Row) {
        let cols = row.ceilings.len();
        for j in 0..cols {
            let here = Pixel::new(i, j);
            if row.left.unbroken[j] {
                let before = if j == 0 { cols - 1 } else { j - 1 };
                let ceilings = (row.ceilings[before], row.ceilings[j]);
                row.left.bases[j] = self.cross((Pixel::new(i, before), here), ceilings);
            }
            if row.up.unbroken[j] {
                let ceilings = (above.ceilings[j], row.ceilings[j]);
                row.up.bases[j] = self.cross((Pixel::new(i - 1, j), here), ceilings);
            }
        }
    }

    fn cross(&mut self, pair: (Pixel, Pixel), ceilings: (i32, i32)) -> Base {
        let (low, high) = (ceilings.0.min(ceilings.1), ceilings.0.max(ceilings.1));
        if low == high {
            return Base::NONE;
        }
        let first = self.linked.crossings.len();
        solve(self.view, self.axes, pair, (low, high), &mut self.linked.crossings);
        Base { first: first as u32, low }
    }

    fn link_cells(&mut self, i: usize, above: &Row, row: &Row) {
        let cols = row.ceilings.len();
        let first = usize::from(!self.view.frame().columns_wrap());
        for j in first..cols {
            let before = if j == 0 { cols - 1 } else { j - 1 };
            let cell = Cell::gather(i, (before, j), above, row);
            match cell::shape(cell.unbroken) {
                Shape::Whole => self.linked.link(&cell),
                Shape::Without(corner) => self.link_triangle(cell, corner),
                Shape::Broken => {}
            }
        }
    }

    /// Links the three valid corners of a cell; a crossing of the diagonal ends or begins a curve.
    fn link_triangle(&mut self, mut cell: Cell, missing: Corner) {
        let triangle = cell::triangle(missing);
        let (onto, across) = (triangle.onto as usize, triangle.across as usize);
        cell.ceilings[missing as usize] = cell.ceilings[onto];
        let pair = (cell.pixels[onto], cell.pixels[across]);
        let ceilings = (cell.ceilings[onto], cell.ceilings[across]);
        let base = self.cross(pair, ceilings);
        self.linked.grow();
        let diagonal = triangle.diagonal as usize;
        (cell.bases[diagonal], cell.unbroken[diagonal]) = (base, true);
        self.linked.link(&cell);
    }
}

/// Four neighbouring pixels; arrays in the order of [`cell::Corner`] and [`cell::Edge`].
struct Cell {
    pixels: [Pixel; 4],
    levels: [f32; 4],
    ceilings: [i32; 4],
    unbroken: [bool; 4],
    bases: [Base; 4],
}

impl Cell {
    fn gather(i: usize, (before, j): (usize, usize), above: &Row, row: &Row) -> Self {
        Self {
            pixels: [(i - 1, before), (i - 1, j), (i, before), (i, j)]
                .map(|(r, c)| Pixel::new(r, c)),
            levels: [above.levels[before], above.levels[j], row.levels[before], row.levels[j]],
            ceilings: [
                above.ceilings[before],
                above.ceilings[j],
                row.ceilings[before],
                row.ceilings[j],
            ],
            unbroken: [
                above.left.unbroken[j],
                row.up.unbroken[before],
                row.up.unbroken[j],
                row.left.unbroken[j],
            ],
            bases: [above.left.bases[j], row.up.bases[before], row.up.bases[j], row.left.bases[j]],
        }
    }

    /// Whether the mean of the corners exceeds a level (saddles only, where no corner is missing).
    fn middle_exceeds(&self, level: i32) -> bool {
        self.levels.iter().map(|l| f64::from(*l)).sum::<f64>() > 4.0 * f64::from(level)
    }

    fn code(&self, level: i32) -> usize {
        let bit = |(k, ceiling): (usize, &i32)| usize::from(*ceiling > level) << k;
        self.ceilings.iter().enumerate().map(bit).sum()
    }

    fn span(&self) -> std::ops::Range<i32> {
        let [a, b, c, d] = self.ceilings;
        a.min(b).min(c.min(d))..a.max(b).max(c.max(d))
    }
}

impl Linked {
    /// Makes room for the links of new crossings.
    fn grow(&mut self) {
        self.next.resize(self.crossings.len(), NONE);
        self.has_previous.resize(self.crossings.len(), false);
    }

    fn link(&mut self, cell: &Cell) {
        for level in cell.span() {
            let links = cell::links(cell.code(level), || cell.middle_exceeds(level));
            for &(from, to) in links {
                let (from, to) = (from as usize, to as usize);
                if cell.unbroken[from] && cell.unbroken[to] {
                    let (from, to) = (cell.bases[from].number(level), cell.bases[to].number(level));
                    self.next[from as usize] = to;
                    self.has_previous[to as usize] = true;
                }
            }
        }
    }
}
