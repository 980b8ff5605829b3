//! A uniform grid over points of a plane, for gathering neighbours.
//!
//! Cells are hashed into about as many buckets as there are points, side by side in blocks of
//! [`BLOCK`] columns: a row of cells is a few runs of points. So the size of a cell never depends on
//! the extent of the plane: a long thin curve, or one node far from all others, costs nothing.

use transect_geometry::{Envelope, Point2, Vector2};

/// Columns of a block, as a power of two.
const BLOCK_BITS: u32 = 2;
const BLOCK: u32 = 1 << BLOCK_BITS;

/// Points sorted into square cells. Neighbours come in an order that depends on the points alone.
#[derive(Debug)]
pub(crate) struct PointGrid {
    origin: Point2,
    per_length: f64,
    /// Largest column and row in use.
    last: Cell,
    /// A block's first bucket has the top bits of a hash for its number.
    shift: u32,
    /// Where each bucket begins in `items`; one entry more than there are buckets.
    starts: Vec<u32>,
    items: Vec<Item>,
}

/// Column and row.
type Cell = (u32, u32);

#[derive(Debug, Clone, Copy)]
struct Item {
    point: Point2,
    /// Block and row.
    key: u64,
    number: u32,
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
        // Twice the points, as a steep curve fills but one column of its blocks.
        let blocks = (2 * points.len() / BLOCK as usize).next_power_of_two().max(2);
        let mut grid = Self {
            origin: around.min,
            per_length,
            last: (u32::MAX, u32::MAX),
            shift: 64 - blocks.trailing_zeros(),
            starts: vec![0; blocks * BLOCK as usize + 1],
            items: Vec::new(),
        };
        grid.last = grid.cell(&(around.max - around.min));
        grid.sort(points);
        grid
    }

    fn sort(&mut self, points: &[Point2]) {
        let cells: Vec<Cell> = points.iter().map(|p| self.cell(&(p - self.origin))).collect();
        for &c in &cells {
            let bucket = self.bucket(c);
            self.starts[bucket + 1] += 1;
        }
        for b in 1..self.starts.len() {
            self.starts[b] += self.starts[b - 1];
        }
        let mut places = self.starts.clone();
        let empty = Item { point: Point2::origin(), key: 0, number: 0 };
        self.items = vec![empty; points.len()];
        for (k, (&cell, &point)) in cells.iter().zip(points).enumerate() {
            let place = &mut places[self.bucket(cell)];
            let key = key(cell.0 >> BLOCK_BITS, cell.1);
            self.items[*place as usize] = Item { point, key, number: k as u32 };
            *place += 1;
        }
    }

    /// The cell at an offset from the origin, or the nearest one in use.
    fn cell(&self, offset: &Vector2) -> Cell {
        // A cast from below 0 or above the largest number gives that bound.
        let along = |v: f64, last: u32| ((v * self.per_length) as u32).min(last);
        (along(offset.x, self.last.0), along(offset.y, self.last.1))
    }

    fn bucket(&self, (column, row): Cell) -> usize {
        self.first_bucket(key(column >> BLOCK_BITS, row)) + (column % BLOCK) as usize
    }

    /// The bucket of a block's first column in a row.
    fn first_bucket(&self, key: u64) -> usize {
        // Fibonacci hashing twice, so that neighbouring rows do not follow each other.
        let mixed = (key ^ (key >> 29)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let hash = (mixed ^ (mixed >> 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> self.shift;
        (hash as usize) << BLOCK_BITS
    }

    /// Calls `visit` with the number of every point within a radius, and where it is from `centre`.
    pub fn within(&self, centre: &Point2, radius: f64, mut visit: impl FnMut(usize, Vector2)) {
        self.around(centre, &Vector2::repeat(radius), |k, from_centre| {
            if from_centre.norm_squared() <= radius * radius {
                visit(k, from_centre);
            }
        });
    }

    /// Calls `visit` with every point that may lie in the rectangle of the given half-widths around
    /// `centre`: all that do, and others of the same cells.
    pub fn around(&self, centre: &Point2, half: &Vector2, mut visit: impl FnMut(usize, Vector2)) {
        let d = centre - self.origin;
        let (first, last) = (self.cell(&(d - half)), self.cell(&(d + half)));
        let cells = (u64::from(last.0 - first.0) + 1) * (u64::from(last.1 - first.1) + 1);
        if cells > self.items.len() as u64 {
            return self.items.iter().for_each(|i| visit(i.number as usize, i.point - centre));
        }
        for row in first.1..=last.1 {
            for block in first.0 >> BLOCK_BITS..=last.0 >> BLOCK_BITS {
                let start = block << BLOCK_BITS;
                let key = key(block, row);
                let bucket = self.first_bucket(key);
                let from = self.starts[bucket + (first.0.max(start) - start) as usize];
                let to = self.starts[bucket + (last.0 - start).min(BLOCK - 1) as usize + 1];
                for i in &self.items[from as usize..to as usize] {
                    if i.key == key {
                        visit(i.number as usize, i.point - centre);
                    }
                }
            }
        }
    }
}

fn key(block: u32, row: u32) -> u64 {
    u64::from(block) << 32 | u64::from(row)
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
