//! A uniform grid over points of a plane, for gathering neighbours.

use transect_geometry::{Envelope, Point2, Vector2};

/// Points sorted into square cells. Neighbours come in an order that depends on the points alone.
#[derive(Debug)]
pub(crate) struct PointGrid {
    origin: Point2,
    cell: f64,
    columns: usize,
    rows: usize,
    /// Where each cell begins in `items`; one entry more than there are cells.
    starts: Vec<u32>,
    /// Numbers and places of the points, cell by cell.
    items: Vec<(u32, Point2)>,
}

impl PointGrid {
    /// Sorts points into cells of about the given size, larger if there would be too many.
    pub fn new(points: &[Point2], cell: f64) -> Self {
        let around = Envelope::around(points)
            .unwrap_or(Envelope { min: Point2::origin(), max: Point2::origin() });
        let size = around.size();
        // At most a few cells per point, whatever the extent of the plane.
        let most = (4 * points.len() + 16) as f64;
        let sparse = (size.x * size.y / most).sqrt().max(size.x.max(size.y) / most);
        let cell = cell.max(sparse).max(f64::MIN_POSITIVE);
        let columns = (size.x / cell) as usize + 1;
        let rows = (size.y / cell) as usize + 1;
        let mut grid =
            Self { origin: around.min, cell, columns, rows, starts: Vec::new(), items: Vec::new() };
        grid.sort(points);
        grid
    }

    fn sort(&mut self, points: &[Point2]) {
        let cells: Vec<usize> = points.iter().map(|p| self.cell_of(p)).collect();
        let mut starts = vec![0_u32; self.columns * self.rows + 1];
        for &c in &cells {
            starts[c + 1] += 1;
        }
        for c in 1..starts.len() {
            starts[c] += starts[c - 1];
        }
        let mut places = starts.clone();
        let mut items = vec![(0, Point2::origin()); points.len()];
        for (k, (&c, p)) in cells.iter().zip(points).enumerate() {
            items[places[c] as usize] = (k as u32, *p);
            places[c] += 1;
        }
        (self.starts, self.items) = (starts, items);
    }

    fn cell_of(&self, p: &Point2) -> usize {
        let (column, row) = (
            self.clamped(p.x - self.origin.x, self.columns),
            self.clamped(p.y - self.origin.y, self.rows),
        );
        row * self.columns + column
    }

    fn clamped(&self, offset: f64, count: usize) -> usize {
        ((offset / self.cell).max(0.0) as usize).min(count - 1)
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
        let columns =
            self.clamped(d.x - half.x, self.columns)..=self.clamped(d.x + half.x, self.columns);
        let rows = self.clamped(d.y - half.y, self.rows)..=self.clamped(d.y + half.y, self.rows);
        for row in rows {
            let first = self.starts[row * self.columns + columns.start()] as usize;
            let last = self.starts[row * self.columns + columns.end() + 1] as usize;
            for (k, p) in &self.items[first..last] {
                visit(*k as usize, p - centre);
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
}
