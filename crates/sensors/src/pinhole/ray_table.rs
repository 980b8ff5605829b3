//! A camera with a ray per pixel, for any calibrated lens distortion.
//!
//! ```text
//!    (i, j)·-----·(i, j+1)        ray of pixel (i, j): a unit vector of its own
//!          |  ×  |                between pixels: the bilinear mix of the four rays around
//!  (i+1, j)·-----·(i+1, j+1)
//! ```
//!
//! Axes, unit, pixel centre, missing value and noise as for the [`Pinhole`](super::Pinhole): x
//! right, y down, z forward if the table is made so, all rays from the origin. `d3` is a depth or a
//! ray length. Missing: a pixel without a ray (outside the lens's circle) has no point. Handedness
//! is read from the table. A table that folds back on itself is refused: `F` would have two
//! answers.
//!
//! `F` looks for the cell which a point's direction passes through. It takes the best ray of an
//! ever finer grid of pixels, then the cells around it. Each is solved for its place by Newton's
//! method; 5 steps reach rounding, since a cell of rays is nearly flat. Outside all cells there is
//! no pixel: `None`. Cost: some hundred dot products per point. All rays must start in one point.

use crate::central::{central_extent, central_plane_value};
use crate::error::{SensorError, require};
use nalgebra::{Matrix2, Vector2};
use std::sync::Arc;
use transect_device::{
    DeviceFrame, DevicePoint, Handedness, ImageError, ImageSize, PinholeScale, Pixel, Point3, Ray,
    SensorPlane, Vector3,
};

/// Rays per side of the coarsest grid of pixels, where the search starts. Chosen by hand. Doubled,
/// a search takes four times as many dot products in its first round.
const COARSEST: usize = 16;
/// Largest distance from a cell, in pixels, at which a place counts as on its border. Chosen by
/// hand: far above the rounding of places, far below any calibration's accuracy. Doubling it
/// changes nothing visible.
const BORDER: f64 = 1e-9;
/// Most Newton steps; five reach rounding. Doubled, only hopeless searches take longer.
const NEWTON_STEPS: usize = 12;

/// The device frame of a camera given by its rays; see the module's page.
///
/// ```
/// use transect_device::{DeviceFrame, ImageSize, Pixel, Vector3};
/// use transect_sensors::{PinholeScale, RayTable};
///
/// let places = (0..12).map(|n| (f64::from(n % 4) - 1.5, f64::from(n / 4) - 1.0));
/// let rays = places.map(|(x, y)| Vector3::new(0.2 * x, 0.2 * y, 1.0)).collect();
/// let camera = RayTable::new(ImageSize { rows: 3, cols: 4 }, rays, PinholeScale::Depth)?;
/// let p = camera.point(Pixel::new(1, 3), 2.0).ok_or("no point")?;
/// assert!((p.x - 0.6).abs() < 1e-12 && p.y == 0.0 && (p.z - 2.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct RayTable {
    size: ImageSize,
    scale: PinholeScale,
    handedness: Handedness,
    /// Row-major directions that a value scales to its point; `None` where the lens has no ray.
    rays: Vec<Option<Vector3>>,
}

impl RayTable {
    /// A camera from one direction per pixel, row-major; of any length, not finite or zero where
    /// the pixel has no ray.
    ///
    /// # Errors
    /// [`SensorError::Image`] for a wrong number of rays. [`SensorError::BadParameter`], naming
    /// `rays`, if depths are asked for of rays that do not run forward, or the table folds back on
    /// itself. [`SensorError::NoSurface`] if no three neighbouring pixels have rays.
    pub fn new(
        size: ImageSize,
        directions: Vec<Vector3>,
        scale: PinholeScale,
    ) -> Result<Self, SensorError> {
        let (ImageSize { rows, cols }, found) = (size, directions.len());
        let pixels = rows.checked_mul(cols).ok_or(ImageError::AbsurdSize { rows, cols })?;
        if found != pixels {
            return Err(ImageError::WrongCount { size, found }.into());
        }
        let unit = |d: Vector3| d.try_normalize(0.0).filter(|d| d.iter().all(|c| c.is_finite()));
        let rays: Vec<Option<Vector3>> = directions.into_iter().map(unit).collect();
        let depth = scale == PinholeScale::Depth;
        if let Some(backward) = rays.iter().flatten().find(|r| depth && r.z <= 0.0) {
            require("rays", backward.z, false, "rays with z > 0, for values that are depths")?;
        }
        let rays = rays.into_iter().map(|r| Some(scale.per_value(r?))).collect();
        let mut table = Self { size, scale, handedness: Handedness::ColumnsRight, rays };
        let turns: Vec<f64> = size.all_pixels().filter_map(|p| table.turn(p)).collect();
        let first = *turns.first().ok_or(SensorError::NoSurface)?;
        table.handedness = Handedness::of(first);
        let folded = turns.iter().filter(|t| Handedness::of(**t) != table.handedness).count();
        require("rays", folded as f64, folded == 0, "no cells that fold back")?;
        Ok(table)
    }

    fn scaled(&self, row: usize, col: usize) -> Option<Vector3> {
        *self.rays.get(self.size.index(Pixel::new(row, col))?)?
    }

    /// Which way a corner of a cell turns, seen along its ray.
    fn turn(&self, Pixel { row, col }: Pixel) -> Option<f64> {
        let unit = |row, col| Some(self.scaled(row, col)?.normalize());
        let here = unit(row, col)?;
        let along_columns = here - unit(row, col.checked_sub(1)?)?;
        let along_rows = here - unit(row.checked_sub(1)?, col)?;
        Some(along_columns.cross(&along_rows).dot(&here))
    }

    /// The pixel whose ray is nearest to a unit direction, by ever finer grids.
    fn nearest(&self, direction: &Vector3) -> Option<Pixel> {
        let closeness = |p: &Pixel| Some(self.scaled(p.row, p.col)?.normalize().dot(direction));
        let best = |pixels: &mut dyn Iterator<Item = Pixel>| {
            let seen = pixels.filter_map(|p| Some((closeness(&p)?, p)));
            seen.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, p)| p)
        };
        let ImageSize { rows, cols } = self.size;
        let mut stride = rows.min(cols).div_ceil(COARSEST);
        let coarse_rows = (0..rows).step_by(stride);
        let mut coarse = coarse_rows
            .flat_map(|row| (0..cols).step_by(stride).map(move |col| Pixel::new(row, col)));
        let mut here = best(&mut coarse)?;
        loop {
            let next = best(&mut ring(here, stride))?;
            if next == here && stride == 1 {
                return Some(here);
            }
            // Half the stride as soon as this one finds no better ray.
            stride = if next == here { stride.div_ceil(2) } else { stride };
            here = next;
        }
    }

    /// Row and column within a cell which a unit direction passes through.
    fn in_cell(&self, row: usize, col: usize, direction: &Vector3) -> Option<(f64, f64)> {
        let corner = |r, c| Some(self.scaled(row + r, col + c)?.normalize());
        let (a, b) = (corner(0, 0)?, corner(0, 1)?);
        let (c, d) = (corner(1, 0)?, corner(1, 1)?);
        let (across, down, twist) = (b - a, c - a, a - b - c + d);
        // Two axes across the direction: the mixed ray must have no part along them.
        let e1 = direction.cross(&across).try_normalize(0.0)?;
        let e2 = direction.cross(&e1);
        let part = |v: &Vector3| Vector2::new(v.dot(&e1), v.dot(&e2));
        let mut place = Vector2::new(0.5, 0.5);
        for _ in 0..NEWTON_STEPS {
            let (i, j) = (place.x, place.y);
            let miss = part(&(a + across * j + down * i + twist * (i * j)));
            let slopes =
                Matrix2::from_columns(&[part(&(down + twist * j)), part(&(across + twist * i))]);
            let step = slopes.try_inverse()? * miss;
            place -= step;
            if step.norm() < 1e-14 {
                break;
            }
        }
        let inside = place.iter().all(|x| (-BORDER..=1.0 + BORDER).contains(x));
        inside.then_some((row as f64 + place.x, col as f64 + place.y))
    }

    /// Row and column which a unit direction passes through, among the cells around a pixel.
    fn around(&self, pixel: Pixel, direction: &Vector3) -> Option<(f64, f64)> {
        let from = |at: usize| at.saturating_sub(2)..at + 2;
        from(pixel.row)
            .flat_map(|row| from(pixel.col).map(move |col| (row, col)))
            .find_map(|(row, col)| self.in_cell(row, col, direction))
    }
}

/// A pixel and its eight neighbours at a distance, as far as indices go.
fn ring(center: Pixel, stride: usize) -> impl Iterator<Item = Pixel> {
    let steps = move |at: usize| {
        [at.checked_sub(stride), Some(at), at.checked_add(stride)].into_iter().flatten()
    };
    // The centre first and last: `max_by` keeps the last of equals, so ties stay where they are.
    let others =
        steps(center.row).flat_map(move |row| steps(center.col).map(move |c| Pixel::new(row, c)));
    others.chain(std::iter::once(center))
}

impl DeviceFrame for RayTable {
    fn size(&self) -> ImageSize {
        self.size
    }

    fn kind(&self) -> &'static str {
        "RayTable"
    }

    fn handedness(&self) -> Handedness {
        self.handedness
    }

    fn pinhole_scale(&self) -> Option<PinholeScale> {
        Some(self.scale)
    }

    fn ray(&self, pixel: Pixel) -> Option<Ray> {
        let direction = self.scaled(pixel.row, pixel.col)?.normalize();
        Some(Ray { start: Point3::origin(), direction })
    }

    fn point(&self, pixel: Pixel, d3: f64) -> Option<Point3> {
        Some(Point3::from(self.scaled(pixel.row, pixel.col)? * d3))
    }

    fn device_point(&self, in_sensor: &Point3) -> Option<DevicePoint> {
        let d3 = self.scale.value(in_sensor);
        let direction = in_sensor.coords.try_normalize(0.0)?;
        if !(d3.is_finite() && d3 > 0.0) {
            return None;
        }
        let (row, col) = self.around(self.nearest(&direction)?, &direction)?;
        Some(DevicePoint { row, col, d3 })
    }

    fn plane_value(&self, pixel: Pixel, plane: &SensorPlane) -> Option<f64> {
        central_plane_value(&self.scaled(pixel.row, pixel.col)?, plane)
    }

    fn halved(&self) -> Option<Arc<dyn DeviceFrame>> {
        let size = self.size.halved();
        let rays = size.all_pixels().map(|p| self.scaled(2 * p.row, 2 * p.col)).collect();
        Some(Arc::new(Self { size, rays, ..*self }))
    }

    /// Exact, ray by ray.
    fn extent(&self, direction: &Vector3, nearest: f64, farthest: f64) -> (f64, f64) {
        central_extent(self.rays.iter().flatten().copied(), direction, nearest, farthest)
    }
}
