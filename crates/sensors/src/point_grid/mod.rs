//! Organised grid of Cartesian points: structured scans that come as points, not as ranges.
//!
//! Each pixel has its own point, and a start of its ray, see [`RayStarts`]. `d3` is the distance of
//! the point from that start, in the model's length unit. Another value than the stored one moves
//! the point along the ray. A missing pixel between two samples has a ray between theirs. There is
//! no inverse mapping `F`, because the rays between the pixels are unknown.
//!
//! Axes: those of the scan, right-handed. Handedness is read from the grid: it is the side from
//! which most cells are seen. Missing: points with a coordinate that is not finite, points too far
//! away for `f32`, and the point (0, 0, 0), which structured formats write for "no return". A grid
//! whose last column lies beside its first is a full circle. Noise is an error along the ray.

mod carried_pinhole;
mod rotating_scan;

pub use carried_pinhole::CarriedPinhole;
pub use rotating_scan::{fit_viewpoint, step_variation, uneven_rays};

use crate::error::{SensorError, require};
use std::sync::Arc;
use transect_device::{
    DeviceFrame, DevicePoint, Handedness, ImageSize, LinearForm, MISSING_POINT, Neighbour,
    PairGeometry, Pixel, Point3, RangeImage, Ray, SensorPlane, Vector3, median,
};

/// The starts of a point grid's rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RayStarts {
    /// All at one point, in the sensor frame.
    Viewpoint(Point3),
    /// On a plane in front of the points, running along one direction away from the sensor.
    Parallel(Vector3),
    /// At a pinhole which the scan carries along x.
    CarriedPinhole(CarriedPinhole),
}

impl RayStarts {
    /// Distance of a point from its ray's start; not positive behind the start.
    fn distance(&self, p: &Point3, parallel_start: f64) -> f64 {
        match self {
            Self::Parallel(direction) => direction.dot(&p.coords) - parallel_start,
            _ => (p - self.start(p, parallel_start)).norm(),
        }
    }

    /// Start of the ray that ends in a point.
    fn start(&self, p: &Point3, parallel_start: f64) -> Point3 {
        match self {
            Self::Viewpoint(start) => *start,
            Self::Parallel(direction) => {
                p - direction * (direction.dot(&p.coords) - parallel_start)
            }
            Self::CarriedPinhole(pinhole) => pinhole.start(p),
        }
    }
}

/// Widest step from the last column to the first, over the usual step. Theory: a rotating lidar
/// ends its turn anywhere between two firings, so up to one may be missing (2 steps), and it moves
/// a little during a turn. Measured on two turns of a 32-ring lidar: 1.3 and 1.9. Doubled, grids of
/// five columns count as full circles.
const WIDEST_SEAM: f64 = 2.5;

/// The device frame of an organised point grid; see the module's page.
///
/// ```
/// use transect_device::{DeviceFrame, ImageSize, Pixel, Point3};
/// use transect_sensors::{PointGrid, RayStarts};
///
/// let points = (0..12).map(|n| Point3::new(f64::from(n % 4), f64::from(n / 4), 10.0)).collect();
/// let starts = RayStarts::Viewpoint(Point3::origin());
/// let (grid, image) = PointGrid::new(ImageSize { rows: 3, cols: 4 }, points, starts)?;
/// assert_eq!(image.get(Pixel::new(0, 0)), Some(10.0));
/// assert_eq!(grid.point(Pixel::new(0, 0), 10.0), Some(Point3::new(0.0, 0.0, 10.0)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct PointGrid {
    size: ImageSize,
    /// Row-major; NaN where a pixel has no ray. Missing pixels between two samples have a point
    /// between them, which is on their ray.
    points: Vec<Point3>,
    starts: RayStarts,
    /// Distance of every point from its ray's start. For parallel rays it may differ from the value
    /// by rounding.
    distances: Vec<f64>,
    /// The start of parallel rays, measured along them; every point lies beyond it.
    parallel_start: f64,
    /// Smallest and largest coordinates of the points.
    bounds: [(f64, f64); 3],
    handedness: Handedness,
    /// Whether the last column's neighbour is the first: a full circle.
    wraps: bool,
}

impl PointGrid {
    /// A grid of row-major points in the sensor frame, with the image of their distances.
    ///
    /// # Errors
    /// [`SensorError`] if the number of points is not that of the pixels, or the ray starts are not
    /// finite. Also if no three neighbouring points show which way round the grid is.
    pub fn new(
        size: ImageSize,
        mut points: Vec<Point3>,
        starts: RayStarts,
    ) -> Result<(Self, RangeImage), SensorError> {
        size.check()?;
        let starts = checked(starts)?;
        for p in &mut points {
            let missing = *p == Point3::origin() || !p.coords.iter().all(|c| c.is_finite());
            if missing {
                *p = MISSING_POINT;
            }
        }
        let parallel_start = parallel_start(&points, &starts);
        let distance = |p: &Point3| starts.distance(p, parallel_start) as f32;
        let image = RangeImage::from_values(size, points.iter().map(distance).collect())?;
        for (p, pixel) in points.iter_mut().zip(size.all_pixels()) {
            // A point too far for the image's numbers is missing there, so it is missing here.
            if image.get(pixel).is_none() {
                *p = MISSING_POINT;
            }
        }
        let handedness = Handedness::ColumnsRight;
        let distance = |p: &Point3| (p - starts.start(p, parallel_start)).norm();
        let distances = points.iter().map(distance).collect();
        let bounds = [0, 1, 2].map(|k| bounds(points.iter().map(|p| p[k])));
        let mut grid = Self {
            size,
            points,
            distances,
            starts,
            parallel_start,
            bounds,
            handedness,
            wraps: false,
        };
        grid.handedness = grid.read_handedness().ok_or(SensorError::NoSurface)?;
        grid.wraps = grid.read_wrap();
        grid.add_rays_between(&image);
        Ok((grid, image))
    }

    /// Gives missing pixels between two samples a ray between theirs, so that a value can be put
    /// there. Of the four lines through such a pixel the one counts whose samples lie at the most
    /// similar distances; the middle between others would be off the middle of their rays.
    fn add_rays_between(&mut self, image: &RangeImage) {
        /// Rows and columns to one of two opposite neighbours.
        const LINES: [(isize, isize); 4] = [(0, 1), (1, 0), (1, 1), (1, -1)];
        let sample = |from: Pixel, rows: isize, cols: isize| {
            let row = from.row.checked_add_signed(rows)?;
            let pixel = Pixel::new(row, from.col.checked_add_signed(cols)?);
            image.get(pixel).zip(self.stored(pixel))
        };
        let between = |pixel: Pixel| {
            let lines = LINES.iter().filter_map(|(rows, cols)| {
                let (a, b) = (sample(pixel, *rows, *cols)?, sample(pixel, -rows, -cols)?);
                Some(((a.0 - b.0).abs(), Point3::from((a.1.coords + b.1.coords) / 2.0)))
            });
            lines.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, middle)| middle)
        };
        let missing = self.size.all_pixels().enumerate().filter(|(_, p)| image.get(*p).is_none());
        let added: Vec<(usize, Point3)> =
            missing.filter_map(|(at, pixel)| Some((at, between(pixel)?))).collect();
        for (at, point) in added {
            self.points[at] = point;
            self.distances[at] = (point - self.starts.start(&point, self.parallel_start)).norm();
        }
    }

    /// A grid from a triangulation scanner that moves along x and looks along -z, with the lines of
    /// sight fitted to the grid itself (see [`CarriedPinhole::fit`]). Where they cannot be fitted,
    /// they are taken as parallel to -z.
    ///
    /// # Errors
    /// As [`PointGrid::new`].
    pub fn from_translated_scan(
        size: ImageSize,
        points: Vec<Point3>,
    ) -> Result<(Self, RangeImage), SensorError> {
        let fitted = CarriedPinhole::fit(size, &points).map(RayStarts::CarriedPinhole);
        Self::new(size, points, fitted.unwrap_or(RayStarts::Parallel(-Vector3::z())))
    }

    fn stored(&self, pixel: Pixel) -> Option<&Point3> {
        self.points.get(self.size.index(pixel)?).filter(|p| !p.x.is_nan())
    }

    /// The point of a value other than that of a stored point.
    #[inline]
    fn moved(&self, p: &Point3, distance: f64, d3: f64) -> Point3 {
        // The stored value is the distance rounded to f32, so it means the stored point.
        if d3 as f32 == distance as f32 {
            return *p;
        }
        let start = self.starts.start(p, self.parallel_start);
        start + (p - start) * (d3 / distance)
    }

    /// The stored points of a row, each with the point of the row's value; NaN where it is missing.
    fn points_of_row<'a>(
        &'a self,
        image: &'a RangeImage,
        row: usize,
    ) -> impl Iterator<Item = (&'a Point3, Point3)> {
        let pixels = row.saturating_mul(self.size.cols)..;
        let stored = self.points.get(pixels.clone()).unwrap_or_default();
        let distances = self.distances.get(pixels).unwrap_or_default();
        let samples = stored.iter().zip(distances).zip(image.row(row));
        samples.map(|((p, distance), d3)| {
            let missing = d3.is_nan() || p.x.is_nan();
            (p, if missing { MISSING_POINT } else { self.moved(p, *distance, f64::from(*d3)) })
        })
    }

    /// The side from which most cells are seen: the sign of (∂p/∂column × ∂p/∂row) · ray.
    fn read_handedness(&self) -> Option<Handedness> {
        let turns = self.size.all_pixels().filter_map(|pixel| self.cell_turn(pixel));
        // A cell seen edge-on has no side.
        let balance: i64 = turns.map(|t| i64::from(t > 0.0) - i64::from(t < 0.0)).sum();
        (balance != 0).then(|| Handedness::of(balance as f64))
    }

    /// Whether the last column lies beside the first, as neighbouring columns do: a full circle.
    fn read_wrap(&self) -> bool {
        let last = self.size.cols - 1;
        let step = |row: usize, a: usize, b: usize| {
            Some((self.stored(Pixel::new(row, a))? - self.stored(Pixel::new(row, b))?).norm())
        };
        let rows = 0..self.size.rows;
        let seams: Vec<f64> = rows.clone().filter_map(|r| step(r, last, 0)).collect();
        let beside = rows.flat_map(|r| [step(r, 0, 1), step(r, last - last.min(1), last)]);
        // With fewer than four columns, a seam looks like the columns' own steps.
        last >= 3
            && seams.len() >= 3
            && median(seams)
                .zip(median(beside.flatten()))
                .is_some_and(|(seam, step)| seam <= WIDEST_SEAM * step)
    }

    fn cell_turn(&self, pixel: Pixel) -> Option<f64> {
        let Pixel { row, col } = pixel;
        let here = self.stored(pixel)?;
        let along_columns = here - self.stored(Pixel::new(row, col.checked_sub(1)?))?;
        let along_rows = here - self.stored(Pixel::new(row.checked_sub(1)?, col))?;
        let ray = here - self.starts.start(here, self.parallel_start);
        Some(along_columns.cross(&along_rows).dot(&ray))
    }
}

/// Smallest and largest of some numbers, without NaN.
fn bounds(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    // Comparisons with NaN are false.
    numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), number| {
        (if number < low { number } else { low }, if number > high { number } else { high })
    })
}

fn checked(starts: RayStarts) -> Result<RayStarts, SensorError> {
    match starts {
        RayStarts::Viewpoint(p) => {
            let sum = p.coords.sum();
            require("viewpoint", sum, true, "a finite point")?;
            Ok(starts)
        }
        RayStarts::Parallel(d) => {
            let length = require("direction", d.norm(), d.norm() > 0.0, "a direction")?;
            Ok(RayStarts::Parallel(d / length))
        }
        RayStarts::CarriedPinhole(CarriedPinhole { y, z, slant }) => {
            require("pinhole", y + z + slant, true, "a finite place and slant")?;
            Ok(starts)
        }
    }
}

/// A place along parallel rays from which nearly every point lies ahead; those that do not are
/// missing.
fn parallel_start(points: &[Point3], starts: &RayStarts) -> f64 {
    /// Share of the points at either end that may be strays: a single one far away would take the
    /// resolution from all other distances.
    const STRAYS: f64 = 0.002;
    let RayStarts::Parallel(direction) = starts else { return 0.0 };
    let along = points.iter().map(|p| direction.dot(&p.coords));
    let mut along: Vec<f64> = along.filter(|a| a.is_finite()).collect();
    along.sort_by(f64::total_cmp);
    let stray = (STRAYS * along.len() as f64) as usize;
    let low = along.get(stray).copied().unwrap_or(0.0);
    let high = along.iter().rev().nth(stray).copied().unwrap_or(low);
    // One depth of the scene ahead of it, or one unit for a flat scene.
    low - if high > low { high - low } else { 1.0 }
}

impl DeviceFrame for PointGrid {
    fn size(&self) -> ImageSize {
        self.size
    }

    fn kind(&self) -> &'static str {
        "PointGrid"
    }

    fn handedness(&self) -> Handedness {
        self.handedness
    }

    fn columns_wrap(&self) -> bool {
        self.wraps
    }

    fn ray(&self, pixel: Pixel) -> Option<Ray> {
        let p = self.stored(pixel)?;
        let start = self.starts.start(p, self.parallel_start);
        Some(Ray { start, direction: (p - start).try_normalize(0.0)? })
    }

    fn point(&self, pixel: Pixel, d3: f64) -> Option<Point3> {
        let p = self.stored(pixel)?;
        let distance = self.distances.get(self.size.index(pixel)?)?;
        Some(self.moved(p, *distance, d3))
    }

    fn form_row(&self, image: &RangeImage, row: usize, form: &LinearForm, out: &mut [f32]) {
        for (value, (_, p)) in out.iter_mut().zip(self.points_of_row(image, row)) {
            *value = if p.x.is_nan() { f32::NAN } else { form.at(&p) as f32 };
        }
    }

    fn pair_row(
        &self,
        image: &RangeImage,
        row: usize,
        neighbour: Neighbour,
        out: &mut [PairGeometry],
    ) {
        out.fill(PairGeometry::MISSING);
        let cols = self.size.cols;
        let points = |row: usize| self.points_of_row(image, row).map(|(_, p)| p);
        let others: Vec<Point3> = match neighbour {
            Neighbour::Up => row.checked_sub(1).into_iter().flat_map(points).collect(),
            Neighbour::Left => {
                let mut before = MISSING_POINT;
                let mut others: Vec<Point3> =
                    points(row).map(|p| std::mem::replace(&mut before, p)).collect();
                if let (true, Some(first)) = (self.wraps, others.first_mut()) {
                    *first = before;
                }
                others
            }
        };
        let pairs = self.points_of_row(image, row).zip(&others).take(cols);
        for (pair, ((stored, p), other)) in out.iter_mut().zip(pairs) {
            if p.x.is_nan() || other.x.is_nan() {
                continue;
            }
            let along = stored - self.starts.start(stored, self.parallel_start);
            if let Some(ray) = along.try_normalize(0.0) {
                *pair = PairGeometry::between(&p, other, &ray);
            }
        }
    }

    fn device_point(&self, _in_sensor: &Point3) -> Option<DevicePoint> {
        None
    }

    fn plane_value(&self, pixel: Pixel, plane: &SensorPlane) -> Option<f64> {
        let ray = self.ray(pixel)?;
        let ahead = plane.offset - plane.normal.dot(&ray.start.coords);
        let value = ahead / plane.normal.dot(&ray.direction);
        (value.is_finite() && value > 0.0).then_some(value)
    }

    fn halved(&self) -> Option<Arc<dyn DeviceFrame>> {
        let size = self.size.halved();
        let whole = |p: Pixel| self.size.index(Pixel::new(2 * p.row, 2 * p.col));
        let places = size.all_pixels().filter_map(whole);
        let (points, distances) = places.map(|k| (self.points[k], self.distances[k])).unzip();
        let Self { starts, parallel_start, bounds, handedness, wraps, .. } = *self;
        let grid =
            Self { size, points, starts, distances, parallel_start, bounds, handedness, wraps };
        Some(Arc::new(grid))
    }

    /// Exact for the stored points, independent of the values: the points of a smoothed image may
    /// lie outside by their noise.
    fn extent(&self, direction: &Vector3, _nearest: f64, _farthest: f64) -> (f64, f64) {
        if let Some(k) =
            (0..3).find(|k| direction.iter().enumerate().all(|(j, d)| j == *k || *d == 0.0))
        {
            let (a, b) = (direction[k] * self.bounds[k].0, direction[k] * self.bounds[k].1);
            return (a.min(b), a.max(b));
        }
        bounds(self.points.iter().map(|p| direction.dot(&p.coords)))
    }
}
