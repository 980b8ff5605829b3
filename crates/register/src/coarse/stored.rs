//! A coarse copy as a model store keeps it.
//!
//! **Problem.** A store judges the poses of views whose images may be gone. Their sensors cannot be
//! written: a sensor may be any implementation of the trait.
//!
//! **Idea.** Rays stand for the sensor: the middle ray of every cell, and a lattice of rays by
//! which points are looked up; see `lattice.rs`. Grids of points have no inverse, and need no
//! lattice; see `by_points.rs`.

use super::facets::Facets;
use super::lattice::{Lattice, Starts};
use super::patch::StoredPatch;
use super::{ByPoints, Cell, CoarseView, Lookup, Seen};
use serde::{Deserialize, Serialize};
use transect_device::{ImageSize, Isometry3, Ray, Vector3};

/// A coarse copy without the name and the pose of its view, which the store has elsewhere. The
/// order of the fields is the layout in the store.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct StoredCopy {
    /// Rows and columns of the image.
    image: [usize; 2],
    step: usize,
    share: f64,
    sigma: f64,
    /// Of sensors with an inverse.
    lattice: Option<Lattice>,
    /// Of the cells with a sample.
    starts: Starts,
    /// Row by row.
    cells: Vec<Option<StoredCell>>,
}

/// A cell with a sample.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct StoredCell {
    direction: [f32; 3],
    seen: Seen,
    patch: Option<StoredPatch>,
}

impl CoarseView {
    /// The copy as a store keeps it; [`StoredCopy::restore`] reads it.
    pub fn stored(&self) -> StoredCopy {
        let cell = |(k, cell): (usize, &Cell)| {
            let direction = self.ray(k)?.direction.map(|c| c as f32).into();
            Some(StoredCell { direction, seen: cell.seen?, patch: cell.patch })
        };
        StoredCopy {
            image: [self.image.rows, self.image.cols],
            step: self.step,
            share: self.share,
            sigma: self.sigma,
            lattice: match &self.lookup {
                Lookup::Inverse(frame) => Lattice::of(frame.as_ref(), self.image, self.step),
                Lookup::Stored(_, lattice) => Some(lattice.clone()),
                Lookup::Points(_) => None,
            },
            starts: Starts::of(&self.rays().collect::<Vec<_>>()),
            cells: self.cells.iter().enumerate().map(cell).collect(),
        }
    }
}

impl StoredCopy {
    /// The copy of the view with this name and pose. `None` if its parts do not fit each other, or
    /// numbers are not finite: a file may hold anything.
    pub fn restore(self, name: &str, world_from_sensor: Isometry3) -> Option<CoarseView> {
        let image = ImageSize { rows: self.image[0], cols: self.image[1] };
        let cells_of = |count: usize| (self.step > 0).then(|| count.div_ceil(self.step));
        let size = ImageSize { rows: cells_of(image.rows)?, cols: cells_of(image.cols)? };
        let finite =
            self.cells.iter().flatten().all(StoredCell::is_finite) && self.starts.is_finite();
        let shares = (0.0..=1.0).contains(&self.share) && self.sigma.is_finite();
        let fits = finite
            && shares
            && size.rows.checked_mul(size.cols)? == self.cells.len()
            && self.lattice.as_ref().is_none_or(|lattice| lattice.is_of(image));
        if !fits {
            return None;
        }
        let rays = self.rays();
        let cells: Vec<Cell> = self.cells.iter().copied().map(Cell::from).collect();
        let lookup = match self.lattice {
            Some(lattice) => Lookup::Stored(rays, lattice),
            None => {
                let patches = cells.iter().zip(&rays).enumerate().filter_map(|(k, (cell, ray))| {
                    Some((k, cell.patch?.patch(ray.as_ref()?)?.point()))
                });
                Lookup::Points(ByPoints::new(patches.collect(), rays, size.cols))
            }
        };
        Some(CoarseView {
            name: name.to_owned(),
            world_from_sensor,
            image,
            size,
            step: self.step,
            share: self.share,
            cells,
            facets: Facets::default(),
            lookup,
            sigma: self.sigma,
            prior: None,
        })
    }

    /// The ray of every cell with a sample.
    fn rays(&self) -> Vec<Option<Ray>> {
        let mut seen = 0..;
        let ray = |cell: &Option<StoredCell>| {
            let cell = cell.as_ref()?;
            let start = self.starts.get(seen.next()?)?;
            let direction = Vector3::from(cell.direction.map(f64::from)).try_normalize(0.0)?;
            Some(Ray { start, direction })
        };
        self.cells.iter().map(ray).collect()
    }
}

impl StoredCell {
    fn is_finite(&self) -> bool {
        let Self { direction: [x, y, z], seen, patch } = self;
        let numbers = [x, y, z, &seen.nearest, &seen.farthest];
        let of_patch = patch.as_ref().is_none_or(StoredPatch::is_finite);
        of_patch && numbers.into_iter().all(|number| number.is_finite())
    }
}

impl From<Option<StoredCell>> for Cell {
    fn from(stored: Option<StoredCell>) -> Self {
        stored.map_or_else(Self::default, |cell| Self { seen: Some(cell.seen), patch: cell.patch })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use transect_device::{RangeImage, View};
    use transect_sensors::{Intrinsics, Pinhole};

    #[test]
    fn a_copy_whose_parts_do_not_fit_is_none() {
        let size = ImageSize { rows: 48, cols: 64 };
        let camera = Pinhole::new(size, Intrinsics { fx: 60.0, fy: 60.0, cx: 31.5, cy: 23.5 });
        let image = RangeImage::from_values(size, vec![2.0; size.pixels()]).unwrap();
        let pose = Isometry3::identity();
        let view = View::new("v", image, Arc::new(camera.unwrap()), pose, Some(0.001)).unwrap();
        let copy = CoarseView::quick(&view).stored();
        let restored = |change: fn(&mut StoredCopy)| {
            let mut changed = copy.clone();
            change(&mut changed);
            changed.restore("v", pose).is_some()
        };
        assert!(restored(|_| ()));
        assert!(!restored(|c| c.step = 0));
        assert!(!restored(|c| c.image[0] += 40));
        assert!(!restored(|c| c.cells.truncate(9)));
        assert!(!restored(|c| c.cells[3].as_mut().unwrap().seen.nearest = f32::NAN));
        assert!(!restored(|c| c.cells[3].as_mut().unwrap().direction[1] = f32::INFINITY));
        assert!(!restored(|c| c.starts = Starts::One([f64::NAN; 3])));
        let restored = copy.clone().restore("v", pose).unwrap();
        assert_eq!(restored.stored().cells.len(), copy.cells.len());
    }
}
