//! The pixel whose ray passes a point, from the rays of some pixels.
//!
//! **Problem.** A copy that was read back from a store has no sensor to ask.
//!
//! **Idea.** Rays change smoothly over an image. Between the rays of a lattice of pixels, start and
//! direction are interpolated bilinearly. In each direction that errs by up to an eighth of the
//! squared angle between two rays of the lattice: by .04 pixels for 13 pixels of .1°, and by .2
//! pixels for 16 pixels of .35°. A cell has 13 or 16 pixels.
//!
//! **Steps.** The search begins at one of a few rays, the one that passes nearest to the point.
//! Steps of Gauss and Newton follow until they are shorter than [`CLOSE`].

use serde::{Deserialize, Serialize};
use transect_device::{DeviceFrame, ImageSize, Pixel, Point3, Ray, Vector3};

/// Length of the last step, in pixels. Chosen by hand: a tenth of the error of interpolating.
/// Doubled, points at the border of two cells change their cell more often.
const CLOSE: f64 = 0.01;

/// Most steps. No unit. Chosen by hand: a search from a near ray takes three or four. Halved, some
/// points of wide images are not found.
const STEPS: usize = 10;

/// Rows, and columns, of the rays at which a search may begin. No unit. Measured on a scanner that
/// turns around, by the test of this file: with 3 some points are not found, with 5 all of 20 000.
/// Doubled, a search takes half as long again.
const BEGINNINGS: usize = 5;

/// Rays of pixels in regular rows and columns, the first and the last ones of the image included.
/// The order of the fields is the layout in a store.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Lattice {
    rows: Vec<u32>,
    cols: Vec<u32>,
    /// Whether the first column follows the last one.
    wraps: bool,
    /// Row by row, in the sensor frame.
    directions: Vec<[f32; 3]>,
    starts: Starts,
}

/// Where rays start, in the sensor frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) enum Starts {
    /// All in one point, as those of most sensors.
    One([f64; 3]),
    /// Each in its own.
    Each(Vec<[f64; 3]>),
}

impl Starts {
    pub fn of(rays: &[Ray]) -> Self {
        let mut starts = rays.iter().map(|ray| <[f64; 3]>::from(ray.start));
        let first = starts.next().unwrap_or_default();
        if starts.all(|start| start == first) {
            return Self::One(first);
        }
        Self::Each(rays.iter().map(|ray| ray.start.into()).collect())
    }

    pub fn is_finite(&self) -> bool {
        let finite = |start: &[f64; 3]| start.iter().all(|c| c.is_finite());
        match self {
            Self::One(start) => finite(start),
            Self::Each(starts) => starts.iter().all(finite),
        }
    }

    pub fn get(&self, k: usize) -> Option<Point3> {
        match self {
            Self::One(start) => Some(Point3::from(*start)),
            Self::Each(starts) => starts.get(k).copied().map(Point3::from),
        }
    }
}

/// A place on an image, in pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub row: f64,
    pub col: f64,
}

/// A ray between those of the lattice, and what it changes by from row to row and column to column.
struct Between {
    start: Point3,
    direction: Vector3,
    /// Of the start and of the direction, for a row and for a column.
    changes: [(Vector3, Vector3); 2],
}

impl Lattice {
    /// The rays of every `step`th row and column; `None` if one is missing, or the image is too
    /// small.
    pub fn of(frame: &dyn DeviceFrame, image: ImageSize, step: usize) -> Option<Self> {
        let (rows, cols) = (places(image.rows, step)?, places(image.cols, step)?);
        let pixels = rows.iter().flat_map(|r| cols.iter().map(|c| (*r as usize, *c as usize)));
        let rays = pixels.map(|(r, c)| frame.ray(Pixel::new(r, c)));
        let rays = rays.collect::<Option<Vec<Ray>>>()?;
        let directions = rays.iter().map(|ray| ray.direction.map(|c| c as f32).into()).collect();
        let (wraps, starts) = (frame.columns_wrap(), Starts::of(&rays));
        Some(Self { rows, cols, wraps, directions, starts })
    }

    /// Whether it is one of an image of this size: what was read from a store may be anything.
    pub fn is_of(&self, image: ImageSize) -> bool {
        let fits = |places: &[u32], count: usize| {
            let last = places.last().is_some_and(|last| *last as usize + 1 == count);
            places.len() > 1 && last && places.is_sorted_by(|a, b| a < b)
        };
        let count = self.rows.len() * self.cols.len();
        let starts = match &self.starts {
            Starts::One(_) => count,
            Starts::Each(starts) => starts.len(),
        };
        let finite = self.directions.iter().flatten().all(|c| c.is_finite());
        finite
            && self.starts.is_finite()
            && fits(&self.rows, image.rows)
            && fits(&self.cols, image.cols)
            && (self.directions.len(), starts) == (count, count)
    }

    /// Whether the first column follows the last one.
    pub fn wraps(&self) -> bool {
        self.wraps
    }

    /// The place whose ray passes a point; `None` if there is none before the sensor and on the
    /// image, or half a pixel beside it.
    pub fn place_of(&self, in_sensor: &Point3) -> Option<Place> {
        let last = |places: &[u32]| places.last().map(|last| f64::from(*last));
        let (last_row, last_col) = (last(&self.rows)?, last(&self.cols)?);
        // A step too far leads back: beyond the image, rays are continued straight.
        let kept = |x: f64, last: f64| x.clamp(-0.25 * last - 1.0, 1.25 * last + 1.0);
        let around = |col: f64| (col + 0.5).rem_euclid(last_col + 1.0) - 0.5;
        let mut at = self.beginning(in_sensor)?;
        for _ in 0..STEPS {
            let (by, depth) = self.step(at, in_sensor)?;
            let (row, col) = (kept(at.row + by.row, last_row), at.col + by.col);
            at = Place { row, col: if self.wraps { around(col) } else { kept(col, last_col) } };
            if by.row.abs().max(by.col.abs()) < CLOSE {
                return (depth > 0.0).then_some(at);
            }
        }
        None
    }

    /// The lattice's ray, among a few, that passes nearest to the point.
    fn beginning(&self, in_sensor: &Point3) -> Option<Place> {
        let few = |count: usize| (0..count).step_by(count.div_ceil(BEGINNINGS));
        let nodes = few(self.rows.len()).flat_map(|i| few(self.cols.len()).map(move |j| (i, j)));
        let towards = |start: Point3| (in_sensor - start).normalize();
        let from_one = match &self.starts {
            Starts::One(start) => Some(towards(Point3::from(*start))),
            Starts::Each(_) => None,
        };
        let nearness = |(i, j): (usize, usize)| {
            let (start, direction) = self.node(i, j)?;
            Some((i, j, from_one.unwrap_or_else(|| towards(start)).dot(&direction)))
        };
        let nodes = nodes.filter_map(nearness);
        let (i, j, _) = nodes.reduce(|best, next| if next.2 > best.2 { next } else { best })?;
        Some(Place { row: f64::from(*self.rows.get(i)?), col: f64::from(*self.cols.get(j)?) })
    }

    /// The step towards the ray through a point, and the point's depth along the ray before it.
    fn step(&self, at: Place, in_sensor: &Point3) -> Option<(Place, f64)> {
        let Between { start, direction, changes } = self.between(at)?;
        let square = direction.norm_squared();
        let to_point = in_sensor - start;
        let depth = to_point.dot(&direction) / square;
        let across = |v: Vector3| v - direction * (v.dot(&direction) / square);
        let off = across(to_point);
        let [row, col] = changes.map(|(start, direction)| across(start + direction * depth));
        let (rr, rc, cc) = (row.norm_squared(), row.dot(&col), col.norm_squared());
        let (ro, co, det) = (row.dot(&off), col.dot(&off), rr * cc - rc * rc);
        let step = Place { row: (cc * ro - rc * co) / det, col: (rr * co - rc * ro) / det };
        (step.row.is_finite() && step.col.is_finite()).then_some((step, depth))
    }

    fn between(&self, at: Place) -> Option<Between> {
        let (i, v, rows) = interval(&self.rows, at.row)?;
        let (j, u, cols) = interval(&self.cols, at.col)?;
        let [a, b] = [self.node(i, j)?, self.node(i, j + 1)?];
        let [c, d] = [self.node(i + 1, j)?, self.node(i + 1, j + 1)?];
        let mixed = |a: Vector3, b: Vector3, c: Vector3, d: Vector3| {
            let (above, below) = (a + (b - a) * u, c + (d - c) * u);
            let (left, right) = (a + (c - a) * v, b + (d - b) * v);
            (above + (below - above) * v, (below - above) / rows, (right - left) / cols)
        };
        let (direction, by_row, by_col) = mixed(a.1, b.1, c.1, d.1);
        let [sa, sb, sc, sd] = [a, b, c, d].map(|(start, _)| start.coords);
        let (start, start_by_row, start_by_col) = mixed(sa, sb, sc, sd);
        let changes = [(start_by_row, by_row), (start_by_col, by_col)];
        Some(Between { start: start.into(), direction, changes })
    }

    fn node(&self, i: usize, j: usize) -> Option<(Point3, Vector3)> {
        let k = i * self.cols.len() + j;
        let direction = self.directions.get(k)?.map(f64::from);
        Some((self.starts.get(k)?, direction.into()))
    }
}

/// Every `step`th of some rows or columns and the last one; `None` if there is only one.
fn places(count: usize, step: usize) -> Option<Vec<u32>> {
    let last = count.checked_sub(1).filter(|last| *last > 0)?;
    let before = (0..last).step_by(step.max(1));
    before.chain([last]).map(|place| u32::try_from(place).ok()).collect()
}

/// The interval of the lattice in which a place is, the place within it from 0 to 1, and its
/// length. Places beyond the lattice belong to its first or last interval.
fn interval(places: &[u32], at: f64) -> Option<(usize, f64, f64)> {
    let after = places.partition_point(|place| f64::from(*place) <= at);
    let k = after.clamp(1, places.len().checked_sub(1)?) - 1;
    let [from, to] = [k, k + 1].map(|k| places.get(k).map(|place| f64::from(*place)));
    let (from, length) = (from?, to? - from?);
    Some((k, (at - from) / length, length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use transect_device::DevicePoint;
    use transect_sensors::{AngularScan, ImagingRadar, Intrinsics, Pinhole};

    const CAMERA: ImageSize = ImageSize { rows: 480, cols: 640 };
    const SCANNER: ImageSize = ImageSize { rows: 200, cols: 720 };

    fn camera() -> Pinhole {
        Pinhole::new(CAMERA, Intrinsics { fx: 585.0, fy: 585.0, cx: 320.0, cy: 240.0 }).unwrap()
    }

    /// A scanner that turns once around, half a degree from ray to ray.
    fn scanner() -> ImagingRadar {
        let half = 0.5_f64.to_radians();
        let (theta, phi) = (AngularScan::from_radians(-3.0, half), -60.0 * half);
        ImagingRadar::new(SCANNER, theta, AngularScan::from_radians(phi, half)).unwrap()
    }

    /// Whether the lattice finds the place that the sensor finds.
    fn check(frame: &dyn DeviceFrame, image: ImageSize, step: usize, point: &Point3) {
        let pixel = Pixel::new(image.rows / 2, image.cols / 2);
        let rays = [pixel, Pixel { col: pixel.col + 1, ..pixel }].map(|p| frame.ray(p).unwrap());
        let angle = (rays[0].direction - rays[1].direction).norm();
        let bound = CLOSE + 2.0 * (step * step) as f64 * angle / 8.0;
        let lattice = Lattice::of(frame, image, step).unwrap();
        assert!(lattice.is_of(image));
        let is_in = |row: f64, col: f64, margin: f64| {
            let inside = |x: f64, count: usize| x > margin && x < count as f64 - 1.0 - margin;
            inside(row, image.rows) && (frame.columns_wrap() || inside(col, image.cols))
        };
        let found = lattice.place_of(point).filter(|place| is_in(place.row, place.col, -0.5));
        match (frame.device_point(point), found) {
            (Some(DevicePoint { row, col, .. }), Some(place)) => {
                let turn = if frame.columns_wrap() { image.cols as f64 } else { f64::INFINITY };
                let by_col = (place.col - col).abs();
                let off = (place.row - row).abs().max(by_col.min(turn - by_col));
                assert!(off < bound, "{place:?}, not {row} {col}");
            }
            (Some(DevicePoint { row, col, .. }), None) => {
                assert!(!is_in(row, col, bound - 0.5), "{row} {col} is not found");
            }
            (None, found) => assert!(found.is_none(), "{found:?} behind the sensor"),
        }
    }

    proptest! {
        #[test]
        fn a_lattice_finds_the_places_that_the_sensor_finds(
            at in prop::array::uniform3(-5.0..5.0), depth in 0.1..8.0, step in 4_usize..20,
        ) {
            let [x, y, z] = at;
            check(&camera(), CAMERA, step, &Point3::new(0.12 * x * depth, 0.12 * y * depth, depth));
            check(&camera(), CAMERA, step, &Point3::new(x, y, z));
            check(&scanner(), SCANNER, step, &Point3::new(x, y, 0.4 * z));
        }
    }

    #[test]
    fn a_lattice_of_another_image_is_told() {
        let lattice = Lattice::of(&camera(), CAMERA, 13).unwrap();
        assert!(!lattice.is_of(SCANNER));
        let short = Lattice { directions: lattice.directions[1..].to_vec(), ..lattice.clone() };
        assert!(!short.is_of(CAMERA));
        let starts = Starts::Each(vec![[0.0; 3]; 7]);
        assert!(!Lattice { starts, ..lattice }.is_of(CAMERA));
        assert!(Lattice::of(&camera(), ImageSize { rows: 1, cols: 640 }, 13).is_none());
    }
}
