//! Points of a plane, hashed into square cells, for gathering neighbours.
//!
//! **Problem.** Sections are long and thin, and a node may lie far from all others. A table of all
//! cells of their extent would be nearly empty, and as large as that extent.
//!
//! **Idea.** Column `c` of row `r` has slot `(c + r stride) mod n`. There are two to four slots per
//! point, whatever the extent. The cells of a row lie side by side, so the points of a row are one
//! run. Different cells may share a slot: callers test distances.
//!
//! **No point is met twice.** The stride is the golden section of `n`, rounded. So any `h`
//! successive rows begin at least `0.38 n / h` slots from each other, less half a slot for each
//! (Swierczkowski, 1958). Rows of `w` cells overlap only if `w > 0.38 n / h - h / 2`. A query of so
//! many cells visits all points once.

use transect_geometry::{Envelope, Point2, Vector2};

/// The golden section of a circle of 2³².
const GOLDEN: u32 = 0x9e37_79b9;

/// Points sorted into square cells. Neighbours come in an order that depends on the points alone.
#[derive(Debug)]
pub(crate) struct PointGrid {
    origin: Point2,
    per_length: f64,
    /// Largest column and row in use.
    last: Cell,
    /// How much farther each row begins, in slots.
    stride: u32,
    /// Where each slot begins in `items`; one entry more than there are slots, a power of two.
    starts: Vec<u32>,
    items: Vec<Numbered>,
}

/// Column and row.
type Cell = (u32, u32);

/// A point of the grid.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Numbered {
    pub place: Point2,
    pub number: u32,
}

impl PointGrid {
    /// Sorts points into cells of the given size.
    pub fn new(points: &[Point2], cell: f64) -> Self {
        let around = Envelope::around(points)
            .unwrap_or(Envelope { min: Point2::origin(), max: Point2::origin() });
        let size = around.size();
        // Smaller cells than this could not be numbered.
        let least = size.x.max(size.y) / f64::from(u32::MAX - 1);
        let per_length = 1.0 / cell.max(least).max(f64::MIN_POSITIVE);
        let bits = (2 * points.len()).max(2).next_power_of_two().trailing_zeros().min(31);
        let mut grid = Self {
            origin: around.min,
            per_length,
            last: (u32::MAX, u32::MAX),
            stride: (GOLDEN >> (31 - bits)).div_ceil(2),
            starts: vec![0; (1 << bits) + 1],
            items: Vec::new(),
        };
        grid.last = grid.cell(&(around.max - around.min));
        grid.sort(points);
        grid
    }

    fn sort(&mut self, points: &[Point2]) {
        let slots: Vec<u32> =
            points.iter().map(|p| self.slot(self.cell(&(p - self.origin)))).collect();
        for &slot in &slots {
            self.starts[slot as usize] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        // Each is where its slot ends. Places are taken from there, last point first: begins
        // remain.
        let empty = Numbered { place: Point2::origin(), number: 0 };
        self.items = vec![empty; points.len()];
        for (number, (&slot, &place)) in slots.iter().zip(points).enumerate().rev() {
            let end = &mut self.starts[slot as usize];
            *end -= 1;
            self.items[*end as usize] = Numbered { place, number: number as u32 };
        }
    }

    /// The cell at an offset from the origin, or the nearest one in use.
    fn cell(&self, offset: &Vector2) -> Cell {
        // A cast from below 0 or above the largest number gives that bound.
        let along = |v: f64, last: u32| ((v * self.per_length) as u32).min(last);
        (along(offset.x, self.last.0), along(offset.y, self.last.1))
    }

    fn slot(&self, (column, row): Cell) -> u32 {
        row.wrapping_mul(self.stride).wrapping_add(column) & self.mask()
    }

    fn mask(&self) -> u32 {
        self.starts.len() as u32 - 2
    }

    /// The grid of the same points, numbered in the order of [`order`](Self::order).
    pub fn renumbered(mut self) -> Self {
        for (number, item) in self.items.iter_mut().enumerate() {
            item.number = number as u32;
        }
        self
    }

    /// The numbers of all points, sorted by cells: neighbours follow each other.
    pub fn order(&self) -> impl Iterator<Item = usize> {
        self.items.iter().map(|item| item.number as usize)
    }

    /// Calls `visit` with the number of every point within a radius, and where it is from `centre`.
    pub fn within(&self, centre: &Point2, radius: f64, mut visit: impl FnMut(usize, Vector2)) {
        let squared = radius * radius;
        self.around(centre, &Vector2::repeat(radius), move |k, from_centre| {
            if from_centre.norm_squared() <= squared {
                visit(k, from_centre);
            }
        });
    }

    /// Calls `visit` with every point that may lie in the rectangle of the given half-widths around
    /// `centre`: all that do, and others.
    pub fn around(&self, centre: &Point2, half: &Vector2, mut visit: impl FnMut(usize, Vector2)) {
        self.runs_around(centre, half, |points| {
            points.iter().for_each(|p| visit(p.number as usize, p.place - centre));
        });
    }

    /// The same by runs of points: those of a row of cells lie one after another.
    pub fn runs_around(&self, centre: &Point2, half: &Vector2, mut visit: impl FnMut(&[Numbered])) {
        let d = centre - self.origin;
        let (first, last) = (self.cell(&(d - half)), self.cell(&(d + half)));
        let (columns, rows) = (u64::from(last.0 - first.0) + 1, u64::from(last.1 - first.1) + 1);
        // With 3/8 for 0.38, and both sides times 8 h.
        if rows.saturating_mul(rows + 2 * columns).saturating_mul(4) > 3 * u64::from(self.mask()) {
            return visit(&self.items);
        }
        let circle = self.mask() as usize + 1;
        for row in first.1..=last.1 {
            let from = self.slot((first.0, row)) as usize;
            let to = from + columns as usize;
            let start = |slot: usize| self.starts[slot] as usize;
            visit(&self.items[start(from)..start(to.min(circle))]);
            if to > circle {
                // The row goes on where the circle begins.
                visit(&self.items[..start(to - circle)]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_grid_finds_what_a_scan_of_all_points_finds(
            points in prop::collection::vec((-5.0..5.0, -50.0..5.0), 0..60),
            centre in (-7.0..7.0, -60.0..7.0), radius in 0.0..20.0, cell in 0.01..10.0,
        ) {
            let points: Vec<_> = points.into_iter().map(|(x, y)| Point2::new(x, y)).collect();
            let centre = Point2::new(centre.0, centre.1);
            let mut found = Vec::new();
            PointGrid::new(&points, cell).within(&centre, radius, |k, _| found.push(k));
            found.sort_unstable();
            let near = |k: &usize| (points[*k] - centre).norm_squared() <= radius * radius;
            let expected: Vec<_> = (0..points.len()).filter(near).collect();
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn a_point_far_from_all_others_makes_no_cell_larger() {
        let mut points: Vec<_> = (0..1000).map(|k| Point2::new(f64::from(k), 0.0)).collect();
        points.push(Point2::new(1e9, -1e9));
        let mut visited = 0;
        let half = Vector2::repeat(2.0);
        PointGrid::new(&points, 2.0).around(&points[500], &half, |_, _| visited += 1);
        // Five lie in the rectangle; its cells reach less than a cell farther on each side.
        assert!((5..=8).contains(&visited), "{visited}");
    }
}
