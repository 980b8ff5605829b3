//! Known space: cells that rays crossed, cells with surface, and unknown cells.
//!
//! 1. A regular grid covers all sensors and all seen points.
//! 2. Cells with observed surface are occupied.
//! 3. Cells without surface that a ray crosses on its way to the surface are free.
//! 4. All other cells are unknown.
//!
//! Rays are walked through the cells as by Amanatides and Woo, "A fast voxel traversal algorithm"
//! (1987): the next cell is the one whose wall the ray reaches first.

use nalgebra::Vector3;
use transect_geometry::Point3;

/// Cells along the longest side of the grid. Chosen by hand: 96³ cells take 1 MB. Doubled, memory
/// and time grow eightfold and narrower passages count as free.
const LONGEST_SIDE: f64 = 96.0;

/// The state of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cell {
    /// No ray crossed it.
    Unknown,
    /// Rays crossed it and no surface was seen in it.
    Free,
    /// Surface was seen in it.
    Occupied,
}

/// The parts of space that rays crossed.
#[derive(Debug, Clone)]
pub struct KnownSpace {
    low: Point3,
    size: f64,
    counts: [usize; 3],
    cells: Vec<Cell>,
}

impl KnownSpace {
    /// The space of rays, each from a sensor to the surface point that it saw, in world
    /// coordinates.
    ///
    /// `None` if no ray has finite ends, or all ends are at one point.
    pub fn from_rays(rays: &[(Point3, Point3)]) -> Option<Self> {
        let finite = |(a, b): &&(Point3, Point3)| a.iter().chain(b.iter()).all(|c| c.is_finite());
        let rays: Vec<_> = rays.iter().filter(finite).collect();
        let mut ends = rays.iter().flat_map(|(a, b)| [a, b]);
        let first = *ends.next()?;
        let (low, high) = ends.fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
        let size = (high - low).max() / LONGEST_SIDE;
        if !(size.is_finite() && size > 0.0) {
            return None;
        }
        // One cell of margin on every side.
        let low = low - Vector3::repeat(size);
        let counts = ((high - low) / size).map(|n| n as usize + 2);
        let cells = vec![Cell::Unknown; counts.product()];
        let mut space = Self { low, size, counts: counts.into(), cells };
        for (_, seen) in &rays {
            space.set(seen, Cell::Occupied);
        }
        for (sensor, seen) in rays {
            space.clear_between(sensor, seen);
        }
        Some(space)
    }

    /// Side of a cell, in the length unit.
    pub fn cell_size(&self) -> f64 {
        self.size
    }

    /// The state of the cell that holds a point.
    pub fn at(&self, in_world: &Point3) -> Cell {
        let known = self.cell_of(in_world).and_then(|cell| self.number(cell));
        known.and_then(|n| self.cells.get(n)).copied().unwrap_or(Cell::Unknown)
    }

    /// The share of the way from one point to another that is known to be free, from 0 to 1. It is
    /// 0 if an observed surface lies in between, farther than `slack` from the second point.
    pub fn free_share(&self, from: &Point3, to: &Point3, slack: f64) -> f64 {
        let length = (to - from).norm();
        let stop = (length - slack).max(0.0);
        let (mut cells, mut free) = (0_u32, 0_u32);
        let clear = self.walk(from, to, |at, number| {
            let cell = self.cells.get(number).copied().unwrap_or(Cell::Unknown);
            cells += 1;
            free += u32::from(cell == Cell::Free || at >= stop);
            at >= stop || cell != Cell::Occupied
        });
        if clear && cells > 0 { f64::from(free) / f64::from(cells) } else { 0.0 }
    }

    /// Centres of every `stride`-th free cell in each direction, in order.
    pub fn free_places(&self, stride: usize) -> Vec<Point3> {
        let stride = stride.max(1);
        let [nx, ny, nz] = self.counts;
        let steps = |n: usize| (stride / 2..n).step_by(stride);
        let cells =
            steps(nz).flat_map(|z| steps(ny).flat_map(move |y| steps(nx).map(move |x| [x, y, z])));
        let centre =
            |cell: [usize; 3]| self.low + Vector3::from(cell.map(|c| c as f64 + 0.5)) * self.size;
        cells.map(centre).filter(|p| self.at(p) == Cell::Free).collect()
    }

    fn set(&mut self, p: &Point3, value: Cell) {
        let number = self.cell_of(p).and_then(|cell| self.number(cell));
        if let Some(cell) = number.and_then(|n| self.cells.get_mut(n)) {
            *cell = value;
        }
    }

    fn clear_between(&mut self, sensor: &Point3, seen: &Point3) {
        let mut crossed = Vec::new();
        self.walk(sensor, seen, |_, number| {
            crossed.push(number);
            true
        });
        for number in crossed {
            if let Some(cell @ Cell::Unknown) = self.cells.get_mut(number) {
                *cell = Cell::Free;
            }
        }
    }

    fn cell_of(&self, p: &Point3) -> Option<[usize; 3]> {
        let at = (p - self.low) / self.size;
        let inside = at.iter().zip(self.counts).all(|(&c, n)| c >= 0.0 && c < n as f64);
        inside.then(|| at.map(|c| c as usize).into())
    }

    fn number(&self, [x, y, z]: [usize; 3]) -> Option<usize> {
        let [nx, ny, nz] = self.counts;
        (x < nx && y < ny && z < nz).then(|| (z * ny + y) * nx + x)
    }

    /// Visits the cells from one point to another by number, with the distance at which each is
    /// entered, until `go_on` returns false. Returns whether the whole way was walked.
    fn walk(&self, from: &Point3, to: &Point3, mut go_on: impl FnMut(f64, usize) -> bool) -> bool {
        let (Some(mut cell), Some(last)) = (self.cell_of(from), self.cell_of(to)) else {
            return true;
        };
        let length = (to - from).norm();
        // Per axis: the distance between walls along the way, and that to the next wall.
        let step = [0, 1, 2].map(|k| length / ((to[k] - from[k]).abs() / self.size));
        let mut wall = [0, 1, 2].map(|k| {
            let at = (from[k] - self.low[k]) / self.size - cell[k] as f64;
            let share = if to[k] > from[k] { 1.0 - at } else { at };
            if step[k].is_finite() { share * step[k] } else { f64::INFINITY }
        });
        let mut entered = 0.0;
        let most = self.counts.iter().sum();
        for _ in 0..most {
            let Some(number) = self.number(cell) else { return true };
            if !go_on(entered, number) {
                return false;
            }
            let k = nearest_wall(&wall);
            if cell == last || wall[k] > length {
                return true;
            }
            entered = wall[k];
            wall[k] += step[k];
            cell[k] = if to[k] > from[k] { cell[k] + 1 } else { cell[k].wrapping_sub(1) };
        }
        true
    }
}

fn nearest_wall(wall: &[f64; 3]) -> usize {
    let nearer = |a: usize, b: usize| if wall[b] < wall[a] { b } else { a };
    nearer(nearer(0, 1), 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point(x: f64, y: f64, z: f64) -> Point3 {
        Point3::new(x, y, z)
    }

    /// A sensor at the origin sees a wall at x = 10.
    fn wall() -> KnownSpace {
        let wall = (-40..=40).flat_map(|y| (-40..=40).map(move |z| (y, z)));
        let seen = wall.map(|(y, z)| point(10.0, f64::from(y) * 0.1, f64::from(z) * 0.1));
        KnownSpace::from_rays(&seen.map(|p| (Point3::origin(), p)).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn space_before_a_wall_is_free_and_beside_the_rays_unknown() {
        let space = wall();
        assert_eq!(space.at(&point(5.0, 0.3, -0.7)), Cell::Free);
        assert_eq!(space.at(&point(10.0, 0.3, -0.7)), Cell::Occupied);
        assert_eq!(space.at(&point(1.0, 3.0, 0.0)), Cell::Unknown);
        assert_eq!(space.at(&point(50.0, 3.0, 0.0)), Cell::Unknown);
    }

    #[test]
    fn a_wall_hides_what_is_behind_it_but_not_what_is_before_it() {
        let (space, sensor) = (wall(), Point3::origin());
        assert_eq!(space.free_share(&sensor, &point(9.0, 0.0, 0.0), 0.0), 1.0);
        assert_eq!(space.free_share(&sensor, &point(10.0, 0.5, 0.5), 0.0), 0.0);
        assert_eq!(space.free_share(&sensor, &point(10.0, 0.5, 0.5), 0.5), 1.0, "within the slack");
    }

    #[test]
    fn a_way_through_unknown_space_counts_for_what_is_known_of_it() {
        // From the rays' cone straight up, out of it halfway: it is as wide as it is long times
        // 0.4.
        let share = wall().free_share(&point(5.0, 0.0, 0.0), &point(5.0, 3.9, 0.0), 0.0);
        assert!((share - 2.0 / 3.9).abs() < 0.05, "{share}");
    }

    #[test]
    fn rays_that_are_no_numbers_are_left_out() {
        let nan = point(f64::NAN, 0.0, 0.0);
        assert!(KnownSpace::from_rays(&[(nan, Point3::origin())]).is_none());
        assert!(KnownSpace::from_rays(&[(Point3::origin(), Point3::origin())]).is_none());
        assert!(KnownSpace::from_rays(&[]).is_none());
    }

    proptest! {
        /// The walk meets every cell that fine steps along the way meet: the slow way is the
        /// oracle.
        #[test]
        fn the_walk_misses_no_cell(
            from in prop::array::uniform3(0.0..10.0),
            to in prop::array::uniform3(0.0..10.0),
        ) {
            let corners = (point(0.0, 0.0, 0.0), point(10.0, 10.0, 10.0));
            let space = KnownSpace::from_rays(&[corners]).unwrap();
            let (from, to) = (Point3::from(from), Point3::from(to));
            let mut walked = Vec::new();
            space.walk(&from, &to, |_, number| { walked.push(number); true });
            for k in 0..=2000 {
                let p = from + (to - from) * (f64::from(k) / 2000.0);
                let number = space.cell_of(&p).and_then(|c| space.number(c)).unwrap();
                // A step within rounding of a wall may lie in either cell.
                let near = ((p - space.low) / space.size).iter().any(|c| (c - c.round()).abs() < 1e-9);
                prop_assert!(near || walked.contains(&number));
            }
        }
    }
}
