//! A coarse copy of a view: patches of its surface, and the free space before them.
//!
//! **Problem.** Every question about poses compares all pairs of views. Whole images are too large
//! to keep, and their samples too noisy to compare.
//!
//! **Steps.**
//! 1. The image is divided into square cells, at most [`CELLS`] of them.
//! 2. Each cell keeps its nearest and farthest sample along one of its rays, and the [`Patch`]
//!    through its samples if they are one smooth surface; see `sampled.rs`. In a rough cell each
//!    pixel keeps the plane through its neighbours; see `facets.rs`.
//! 3. A point is looked up by the device frame's inverse. Point grids have none; there, the cell
//!    whose ray passes the point is found from the samples, see `by_points.rs`.

mod by_points;
mod facets;
mod lattice;
mod names;
mod patch;
mod sampled;
mod stored;

pub use patch::Patch;
pub use stored::StoredCopy;

use crate::prior::{PosePrior, PriorError};
use crate::tuning::{CELLS, LEAST_AHEAD, LEAST_STEP, QUICK_CELLS};
use by_points::ByPoints;
pub(crate) use facets::FacetMeeting;
use facets::Facets;
use lattice::{Lattice, Place};
use names::with_long_numbers;
use patch::StoredPatch;
use sampled::{Sampled, Sampling};
use std::sync::Arc;
use transect_device::{
    DepthOffsets, DeviceFrame, DevicePoint, ImageSize, Isometry3, Pixel, Point3, Ray, Vector3, View,
};
use transect_image::RangeNoise;

/// A coarse copy of a view, a few thousand cells in place of its pixels.
#[derive(Debug, Clone)]
pub struct CoarseView {
    name: String,
    world_from_sensor: Isometry3,
    image: ImageSize,
    /// Rows and columns of cells.
    size: ImageSize,
    /// Pixels along the side of a cell.
    step: usize,
    /// Cells of this copy over those of a full one.
    share: f64,
    /// Row-major.
    cells: Vec<Cell>,
    /// Of rough cells. A store does not keep them.
    facets: Facets,
    lookup: Lookup,
    sigma: f64,
    prior: Option<PosePrior>,
}

#[derive(Debug, Clone)]
enum Lookup {
    Inverse(Arc<dyn DeviceFrame>),
    Points(ByPoints),
    /// The rays of the cells with a sample, and the lattice that a store keeps for the sensor.
    Stored(Vec<Option<Ray>>, Lattice),
}

/// The measurements of a cell of pixels, packed: a view has thousands of cells.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Cell {
    seen: Option<Seen>,
    patch: Option<StoredPatch>,
}

/// The depths of a cell, in the model's length unit. Rounding widens them.
#[derive(Debug, Clone, Copy, serde::Serialize, serde::Deserialize)]
struct Seen {
    /// Rows and columns from the cell's corner to the pixel whose ray stands for those of all.
    middle: (u16, u16),
    /// Distances of the nearest and the farthest sample from the ray's start, along the ray.
    nearest: f32,
    farthest: f32,
    /// Whether nearly every pixel has a sample; see [`LEAST_WHOLE`].
    whole: bool,
}

/// A point over a patch of a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchMeeting {
    /// Number of the cell that holds the patch, row by row.
    pub cell: usize,
    /// Signed distance of the point from the patch's surface, positive on the sensor's side.
    pub distance: f64,
    /// Unit normal of the surface there, in the sensor frame, on the sensor's side.
    pub normal: Vector3,
    /// Standard deviation of the patch along its normal from noise alone.
    pub sigma: f64,
}

impl CoarseView {
    /// The coarse copy of a view.
    pub fn new(view: &View) -> Self {
        let shares_noise = RangeNoise::of_fewer_rows(view).is_mostly_shared();
        Self::with_cells(view, CELLS, |_| 1, !shares_noise)
    }

    /// A copy that is enough to judge poses, and not to refine them. It is far cheaper: a quarter
    /// of the cells, each with 4 to 6 of its pixels a side.
    pub fn quick(view: &View) -> Self {
        // Few samples show no fold, and shared noise takes time to find.
        Self::with_cells(view, QUICK_CELLS, |step| (step - 1) / (LEAST_STEP - 1), false)
    }

    /// A copy of about so many cells, which take every `stride`th pixel. `folds`: whether patches
    /// state what noise does not explain of their samples.
    fn with_cells(view: &View, cells: usize, stride: impl Fn(usize) -> usize, folds: bool) -> Self {
        let image = view.image().size();
        let step_of = |cells: usize| {
            let step = (image.pixels() as f64 / cells as f64).sqrt().ceil() as usize;
            step.max(LEAST_STEP)
        };
        let (step, full) = (step_of(cells), step_of(CELLS));
        let stride = stride(step);
        let size = ImageSize { rows: image.rows.div_ceil(step), cols: image.cols.div_ceil(step) };
        let sampling = Sampling { view, noise: RangeNoise::of_pixels(view), step, stride, folds };
        let corner = |k: usize| Pixel::new(k / size.cols * step, k % size.cols * step);
        let cell = |k: usize| Sampled::new(&sampling, corner(k));
        // On one thread: views are copied side by side, and a thread that waits for a part of its
        // view would begin another one.
        let cells: Vec<Option<Sampled>> = (0..size.pixels()).map(cell).collect();
        let stored = |k: usize| {
            let Some(Sampled { seen, ray, .. }) = cells[k] else { return Cell::default() };
            let near = around(k, 1, size, view.frame().columns_wrap());
            let patch = steadied(&cells, k, near).map(|patch| StoredPatch::new(&patch, &ray));
            Cell { seen: Some(seen), patch }
        };
        let rough = |cell: &Option<Sampled>| folds && cell.as_ref().is_some_and(|cell| cell.rough);
        let rough: Vec<bool> = cells.iter().map(rough).collect();
        let middle = cells.iter().flatten().find_map(|cell| Some(cell.patch?.point()));
        let facets = Facets::new(&sampling, size, middle.unwrap_or_else(Point3::origin), &rough);
        Self {
            name: view.name().to_owned(),
            world_from_sensor: *view.world_from_sensor(),
            image,
            size,
            step,
            share: (full as f64 / step as f64).powi(2),
            cells: (0..cells.len()).map(stored).collect(),
            lookup: Lookup::new(view, &cells, &facets, size.cols),
            facets,
            sigma: sampling.noise.length(),
            prior: None,
        }
    }

    /// The same copy at another pose.
    pub fn with_pose(self, world_from_sensor: Isometry3) -> Self {
        Self { world_from_sensor, ..self }
    }

    /// The same copy without the error of its depth camera, which hardly varies within a cell.
    /// Without facets: those serve refinement alone, which finds that error.
    pub fn corrected(self, offsets: &DepthOffsets) -> Self {
        let size = self.size;
        let correct = |(k, cell): (usize, &Cell)| -> Option<Cell> {
            let along_z = self.ray(k)?.direction.z;
            let of_cell = offsets.at(size, size.pixel(k)) * along_z;
            let (scale, offset) = (offsets.scale() as f32, of_cell as f32);
            let shifted = |depth: f32| depth / (scale.recip() + offset * depth);
            let seen = cell.seen.map(|seen| Seen {
                nearest: shifted(seen.nearest).next_down(),
                farthest: shifted(seen.farthest).next_up(),
                ..seen
            });
            Some(Cell { seen, patch: cell.patch.map(|patch| patch.shifted(scale, offset)) })
        };
        let cells = self.cells.iter().enumerate();
        let cells = cells.map(|cell| correct(cell).unwrap_or_default()).collect();
        Self { cells, facets: Facets::default(), ..self }
    }

    /// The same copy of a view whose scan states how far its pose may be wrong.
    ///
    /// # Errors
    /// [`PriorError::OfView`] if a number of the prior is not finite or below 1e-12.
    pub fn with_prior(self, prior: Option<PosePrior>) -> Result<Self, PriorError> {
        match prior.filter(|prior| !prior.is_sound()) {
            Some(prior) => Err(PriorError::OfView { view: self.name, prior }),
            None => Ok(Self { prior, ..self }),
        }
    }

    /// How far the view's own pose may be wrong, if its scan states it.
    pub fn prior(&self) -> Option<PosePrior> {
        self.prior
    }

    /// The name of the view.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The pose that the view was given: world coordinates from sensor coordinates.
    pub fn world_from_sensor(&self) -> &Isometry3 {
        &self.world_from_sensor
    }

    /// The place of the view among the views of a scan, whatever order they come in: by name, where
    /// `view2` is before `view10`, and views of one name by the bits of their poses.
    pub(crate) fn rank(&self) -> (String, String, [[u64; 4]; 4]) {
        let pose = self.world_from_sensor.to_homogeneous().map(f64::to_bits).data.0;
        (with_long_numbers(&self.name), self.name.clone(), pose)
    }

    /// Rows and columns of cells.
    pub fn size(&self) -> ImageSize {
        self.size
    }

    /// Pixels along the side of a cell.
    pub fn step(&self) -> usize {
        self.step
    }

    /// Whether all rays run forward along z, as those of a camera do.
    pub(crate) fn looks_forward(&self) -> bool {
        self.rays().all(|ray| ray.direction.z > 0.0)
    }

    /// How many cells of this copy are as large as `cells` of a full one.
    pub(crate) fn as_many_as(&self, cells: usize) -> usize {
        (cells as f64 * self.share).ceil() as usize
    }

    /// Range noise of the view along its rays, at its median pixel, in the model's length unit.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// The patches in the sensor frame, each with the number of its cell, row by row.
    pub fn patches(&self) -> impl Iterator<Item = (usize, Patch)> {
        (0..self.cells.len()).filter_map(|k| Some((k, self.patch(k)?)))
    }

    /// Whether nearly every pixel of a cell has a sample.
    pub(crate) fn is_whole(&self, cell: usize) -> bool {
        self.cell(cell).and_then(|cell| cell.seen).is_some_and(|seen| seen.whole)
    }

    fn patch(&self, cell: usize) -> Option<Patch> {
        self.patch_of(&self.cell(cell)?, cell)
    }

    fn patch_of(&self, copy: &Cell, cell: usize) -> Option<Patch> {
        copy.patch?.patch(&self.ray_through(copy.seen?, cell)?)
    }

    /// The ray that stands for those of all pixels of a cell.
    pub(crate) fn ray(&self, cell: usize) -> Option<Ray> {
        self.ray_through(self.cells.get(cell)?.seen?, cell)
    }

    fn ray_through(&self, seen: Seen, cell: usize) -> Option<Ray> {
        let (row, col) = seen.middle;
        match &self.lookup {
            Lookup::Inverse(frame) => frame.ray(Pixel::new(
                cell / self.size.cols * self.step + usize::from(row),
                cell % self.size.cols * self.step + usize::from(col),
            )),
            Lookup::Points(points) => points.ray(cell),
            Lookup::Stored(rays, _) => rays.get(cell).copied().flatten(),
        }
    }

    fn rays(&self) -> impl Iterator<Item = Ray> {
        (0..self.cells.len()).filter_map(|k| self.ray(k))
    }

    /// The patch that a sensor-frame point lies over; `None` where the view has none.
    pub fn meeting(&self, in_sensor: &Point3) -> Option<PatchMeeting> {
        self.meeting_in(self.cell_of(in_sensor)?, in_sensor)
    }

    /// The patch of a cell, with a point whose ray passes the cell.
    pub(crate) fn meeting_in(&self, cell: usize, in_sensor: &Point3) -> Option<PatchMeeting> {
        self.meeting_with(&self.cell(cell)?, cell, in_sensor)
    }

    /// The same with a copy of the cell.
    pub(crate) fn meeting_with(
        &self,
        copy: &Cell,
        cell: usize,
        in_sensor: &Point3,
    ) -> Option<PatchMeeting> {
        let patch = self.patch_of(copy, cell)?;
        let (distance, sigma) = patch.distance(in_sensor)?;
        Some(PatchMeeting { cell, distance, normal: patch.steady_normal(), sigma })
    }

    /// The facets of the cells without a smooth surface.
    pub(crate) fn facets(&self) -> &Facets {
        &self.facets
    }

    /// A cell as it is kept.
    pub(crate) fn cell(&self, cell: usize) -> Option<Cell> {
        self.cells.get(cell).copied()
    }

    /// How far a sensor-frame point, whose ray passes the cell, lies in front of all that the view
    /// measured around that ray. The view looked through it, so no surface is there.
    ///
    /// `None` unless the cell and all around it are whole and farther away: rays between surfaces
    /// say nothing.
    pub(crate) fn free_in_front(&self, cell: usize, in_sensor: &Point3) -> Option<f64> {
        let ray = self.ray(cell)?;
        let before = |around| self.before(around, &ray, in_sensor);
        self.around(cell, 1).map(before).reduce(|a, b| Some(a?.min(b?))).flatten()
    }

    /// How far a point on a ray is in front of what a cell near that ray measured; `None` unless
    /// the cell is whole and the point is in front.
    ///
    /// Seen obliquely, a wall's nearest sample in a cell lies far before the rest of it. So a point
    /// is also in front if it lies before the plane of the cell's patch, by more than the patch's
    /// radius. Without this, a scanner in a room passes for right if it is 0.1 to 0.5 m off.
    fn before(&self, cell: usize, ray: &Ray, in_sensor: &Point3) -> Option<f64> {
        let copy = self.cell(cell)?;
        let seen = copy.seen.filter(|seen| seen.whole)?;
        let before = f64::from(seen.nearest) - (in_sensor - ray.start).dot(&ray.direction);
        if before > 0.0 {
            return Some(before);
        }
        let patch = self.patch_of(&copy, cell)?;
        let normal = patch.steady_normal();
        let height = (in_sensor - patch.point()).dot(&normal);
        let incidence = -ray.direction.dot(&normal);
        (height > patch.radius() && incidence > 0.0).then(|| height / incidence)
    }

    /// The cells within so many rows and columns of one, itself among them. In an image that turns
    /// around once, the first column follows the last one.
    pub(crate) fn around(&self, cell: usize, reach: usize) -> impl Iterator<Item = usize> {
        let wraps = match &self.lookup {
            Lookup::Inverse(frame) => frame.columns_wrap(),
            Lookup::Points(points) => points.wraps(),
            Lookup::Stored(_, lattice) => lattice.wraps(),
        };
        around(cell, reach, self.size, wraps)
    }

    /// Rows and columns of the image.
    pub(crate) fn image_size(&self) -> ImageSize {
        self.image
    }

    /// The rays of the first and the last pixel, if the view is one of a depth camera. All rays of
    /// such a view start in the origin of the sensor frame and run along its z axis. Views of one
    /// camera have the same ones.
    pub(crate) fn camera(&self) -> Option<[Vector3; 2]> {
        let Lookup::Inverse(frame) = &self.lookup else { return None };
        let last = Pixel::new(self.image.rows.checked_sub(1)?, self.image.cols.checked_sub(1)?);
        let ahead = |ray: &Ray| ray.start == Point3::origin() && ray.direction.z > LEAST_AHEAD;
        let all_ahead = self.rays().all(|ray| ahead(&ray));
        let rays = [frame.ray(Pixel::new(0, 0))?, frame.ray(last)?];
        (all_ahead && rays.iter().all(ahead)).then(|| rays.map(|ray| ray.direction))
    }

    /// The cell whose rays pass a sensor-frame point.
    pub(crate) fn cell_of(&self, in_sensor: &Point3) -> Option<usize> {
        let at = match &self.lookup {
            Lookup::Inverse(frame) => {
                let DevicePoint { row, col, .. } = frame.device_point(in_sensor)?;
                Place { row, col }
            }
            Lookup::Points(points) => return points.cell_of(in_sensor),
            Lookup::Stored(_, lattice) => lattice.place_of(in_sensor)?,
        };
        let inside = at.row > -0.5 && at.col > -0.5;
        let (row, col) = ((at.row + 0.5) as usize, (at.col + 0.5) as usize);
        let inside = inside && row < self.image.rows && col < self.image.cols;
        inside.then(|| row / self.step * self.size.cols + col / self.step)
    }
}

/// The cells within so many rows and columns of one, as far as the image reaches. `wraps`: the
/// first column follows the last one.
fn around(cell: usize, reach: usize, size: ImageSize, wraps: bool) -> impl Iterator<Item = usize> {
    let (row, col) = (cell / size.cols, cell % size.cols);
    let rows = row.saturating_sub(reach)..(row + reach + 1).min(size.rows);
    let cols = if wraps {
        let first = col + size.cols - reach.min(size.cols);
        first..first + (2 * reach + 1).min(size.cols)
    } else {
        col.saturating_sub(reach)..(col + reach + 1).min(size.cols)
    };
    rows.flat_map(move |row| cols.clone().map(move |col| row * size.cols + col % size.cols))
}

/// The patch of a cell with the normal that those around it make steady.
fn steadied(
    cells: &[Option<Sampled>],
    k: usize,
    around: impl Iterator<Item = usize>,
) -> Option<Patch> {
    let patch = |k: usize| cells.get(k)?.as_ref()?.patch.as_ref();
    let mut steadied = *patch(k)?;
    steadied.steady(around.filter(|other| *other != k).filter_map(patch));
    Some(steadied)
}

impl Lookup {
    fn new(view: &View, cells: &[Option<Sampled>], facets: &Facets, cols: usize) -> Self {
        let frame = view.shared_frame();
        let point = |cell: &Option<Sampled>| Some(cell.as_ref()?.patch.as_ref()?.point());
        let points = cells.iter().enumerate();
        let points =
            points.filter_map(|(k, cell)| Some((k, point(cell).or_else(|| facets.middle(k))?)));
        let points: Vec<(usize, Point3)> = points.collect();
        if points.first().is_none_or(|(_, p)| frame.device_point(p).is_some()) {
            return Self::Inverse(frame);
        }
        let rays = cells.iter().map(|cell| cell.as_ref().map(|cell| cell.ray)).collect();
        Self::Points(ByPoints::new(points, rays, cols))
    }
}
