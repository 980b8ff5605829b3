//! The cell whose ray passes a point, in a grid of points without an inverse mapping.
//!
//! **Idea.** Neighbouring rays have nearly the same direction. The point is moved along the ray of
//! the nearest patch to the depth of that patch; the nearest patch to the moved point is the next
//! guess, and it no longer changes after a few steps.

use super::Sampled;
use rstar::{RTree, primitives::GeomWithData};
use transect_device::{Point3, Ray};

/// Most guesses. No unit. Chosen by hand: the guesses stop as soon as they settle. Doubled, points
/// between two cells are looked up for longer.
const GUESSES: usize = 6;

/// The patches of a view by place.
#[derive(Debug, Clone)]
pub(super) struct ByPoints {
    tree: RTree<GeomWithData<[f64; 3], usize>>,
    /// The ray of every cell with a sample.
    rays: Vec<Option<Ray>>,
}

impl ByPoints {
    pub(super) fn new(cells: &[Option<Sampled>]) -> Self {
        let placed = cells.iter().enumerate().filter_map(|(k, cell)| {
            let patch = cell.as_ref()?.patch.as_ref()?;
            Some(GeomWithData::new(patch.point().into(), k))
        });
        let rays = cells.iter().map(|cell| cell.as_ref().map(|cell| cell.ray)).collect();
        Self { tree: RTree::bulk_load(placed.collect()), rays }
    }

    /// The ray of a cell.
    pub(super) fn ray(&self, cell: usize) -> Option<Ray> {
        self.rays.get(cell).copied().flatten()
    }

    /// The cell; one whose patch is nearest if the guesses do not settle.
    pub(super) fn cell_of(&self, in_sensor: &Point3) -> Option<usize> {
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
}
