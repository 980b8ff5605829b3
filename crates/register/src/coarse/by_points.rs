//! The cell whose ray passes a point, in a grid of points without an inverse mapping.
//!
//! **Idea.** Where all rays start at one place, the cell is that of the nearest direction. Four
//! grids of 256 × 512 points are refined in half the time that the guesses below take.
//!
//! Rays of other grids may cross. Neighbouring ones have nearly the same direction: the point is
//! moved along the ray of the nearest patch to the depth of that patch. The nearest patch to the
//! moved point is the next guess. It no longer changes after a few steps.
//!
//! A facet stands for a cell without a patch.

use rstar::{RTree, primitives::GeomWithData};
use transect_device::{Point3, Ray, Vector3, median};

/// Most guesses. No unit. Chosen by hand: the guesses stop as soon as they settle. Doubled, points
/// between two cells are looked up for longer.
const GUESSES: usize = 6;

/// The patches of a view by place, or by direction.
#[derive(Debug, Clone)]
pub(super) struct ByPoints {
    /// The patches, or their directions from the start of all rays.
    tree: RTree<GeomWithData<[f64; 3], usize>>,
    start: Option<Point3>,
    /// The ray of every cell with a sample.
    rays: Vec<Option<Ray>>,
    /// Tangent of the largest angle between the ray of each cell and a point of the cell.
    openings: Vec<f64>,
    wraps: bool,
}

impl ByPoints {
    /// The points of the patches, and of facets in cells without one, with the numbers of the
    /// cells. The ray of every cell with a sample. `cols` is the number of cells of a row.
    pub(super) fn new(points: Vec<(usize, Point3)>, rays: Vec<Option<Ray>>, cols: usize) -> Self {
        let start = common_start(&rays);
        let placed = points.into_iter().filter_map(|(k, point)| {
            let place = start.map_or(Some(point.coords), |start| direction(&start, &point));
            Some(GeomWithData::new(place?.into(), k))
        });
        let (openings, wraps) = (openings(&rays, cols), wraps(&rays, cols));
        Self { tree: RTree::bulk_load(placed.collect()), start, rays, openings, wraps }
    }

    /// Whether the first column follows the last one.
    pub(super) fn wraps(&self) -> bool {
        self.wraps
    }

    /// The ray of a cell.
    pub(super) fn ray(&self, cell: usize) -> Option<Ray> {
        self.rays.get(cell).copied().flatten()
    }

    /// The cell; one whose patch is nearest if the guesses do not settle. `None` beside all cells
    /// with a patch, such as outside the field of view.
    pub(super) fn cell_of(&self, in_sensor: &Point3) -> Option<usize> {
        let cell = match self.start {
            Some(start) => {
                Some(self.tree.nearest_neighbor(direction(&start, in_sensor)?.into())?.data)
            }
            None => self.guessed(in_sensor),
        };
        cell.filter(|&k| self.is_in(k, in_sensor))
    }

    fn guessed(&self, in_sensor: &Point3) -> Option<usize> {
        let mut moved = *in_sensor;
        let mut cell = None;
        for _ in 0..GUESSES {
            let near = self.tree.nearest_neighbor(moved.into())?;
            let k = near.data;
            if cell.replace(k) == Some(k) {
                break;
            }
            let ray = self.ray(k)?;
            let depth = (Point3::from(*near.geom()) - in_sensor).dot(&ray.direction);
            moved = in_sensor + ray.direction * depth;
        }
        cell
    }

    /// Whether a point lies among the rays of a cell.
    fn is_in(&self, cell: usize, in_sensor: &Point3) -> bool {
        let (Some(ray), Some(opening)) = (self.ray(cell), self.openings.get(cell)) else {
            return false;
        };
        let from_start = in_sensor - ray.start;
        let along = from_start.dot(&ray.direction);
        (from_start - ray.direction * along).norm() <= along * opening
    }
}

fn direction(start: &Point3, p: &Point3) -> Option<Vector3> {
    (p - start).try_normalize(0.0)
}

/// Where all rays start, if that is one place.
fn common_start(rays: &[Option<Ray>]) -> Option<Point3> {
    let mut starts = rays.iter().flatten().map(|ray| ray.start);
    let first = starts.next()?;
    starts.all(|start| start == first).then_some(first)
}

/// Whether the last cell of most rows lies beside the first one, at most as far as two neighbours
/// do. A store does not keep what the sensor says of this.
fn wraps(rays: &[Option<Ray>], cols: usize) -> bool {
    let angle = |row: &[Option<Ray>], a: usize, b: usize| {
        let [a, b] = [a, b].map(|k| row.get(k).copied().flatten());
        Some((a?.direction - b?.direction).norm())
    };
    let across = |row: &[Option<Ray>]| angle(row, 0, cols.checked_sub(1)?);
    let first = |row: &[Option<Ray>]| angle(row, 0, 1);
    let rows = || rays.chunks_exact(cols.max(1));
    let [across, beside] = [median(rows().filter_map(across)), median(rows().filter_map(first))];
    cols > 2 && across.zip(beside).is_some_and(|(across, beside)| across < 1.5 * beside)
}

/// How far each cell opens: as far as the rays of its farthest neighbour, so that cells of the grid
/// overlap. A cell without neighbours opens as far as the median cell.
fn openings(rays: &[Option<Ray>], cols: usize) -> Vec<f64> {
    let ray = |k: Option<usize>| k.and_then(|k| rays.get(k).copied().flatten());
    let of_cell = |k: usize| -> Option<f64> {
        let here = ray(Some(k))?;
        let beside = |is_there: bool, k: usize| is_there.then_some(k);
        let neighbours = [
            beside(!k.is_multiple_of(cols), k.wrapping_sub(1)),
            beside(k % cols + 1 < cols, k + 1),
            k.checked_sub(cols),
            Some(k + cols),
        ];
        let angles = neighbours.into_iter().filter_map(ray);
        angles.map(|other| (other.direction - here.direction).norm()).reduce(f64::max)
    };
    let openings: Vec<Option<f64>> = (0..rays.len()).map(of_cell).collect();
    let usual = median(openings.iter().flatten().copied()).unwrap_or(0.0);
    openings.into_iter().map(|opening| opening.unwrap_or(usual)).collect()
}
