//! The space that a view looked through.
//!
//! **Problem.** What one view alone saw may be a person who walked by. Other views measured what
//! lies behind, so no surface is there. They are asked about the nodes of a whole model, so an
//! answer must cost little.
//!
//! **Idea.** The nearest sample in each direction around the sensor (a depth map as for shadows:
//! Williams, 1978). The kind of sensor does not matter then. Directions are cells on the sides of a
//! cube, about equally wide as angles.
//!
//! **Steps.**
//! 1. The image is divided into blocks of a few pixels. Each has its nearest sample, and the
//!    direction of its middle ray.
//! 2. A cell of the cube has the nearest sample of its blocks.
//! 3. Space is free in a cell up to the nearest sample there and in the eight cells around it, since
//!    poses err a little. It is not known where pixels are missing, which may hide something.
//!
//! **Departure.** Where rays start in different points, as those of light-stripe scanners, there is
//! no such map. Nothing is known of what such a view looks through.

use crate::tuning::{LEAST_STEP, LEAST_WHOLE, QUANTILE_SAMPLES, SPACE_BLOCKS};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_4;
use transect_device::{ImageSize, Pixel, Point3, Vector3, View, median};

/// Blocks along the side of a cell. No unit. Theory: cells at the border of a side are narrower as
/// angles, by a third. With two blocks, each of them has the middle of one. Doubled, things that
/// stand close to a wall are not told from it.
const BLOCKS_OF_CELL: f64 = 2.0;

/// How far a view looked through in every direction. The order of the fields is the layout in a
/// store.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FreeSpace {
    /// Where all rays start, in the sensor frame.
    centre: [f64; 3],
    /// Width of a cell. The sides of the cube reach from -1 to 1.
    width: f64,
    /// The sides that face along x, -x, y, -y, z and -z of the sensor frame.
    sides: [Side; 6],
}

/// The part of a side of the cube that the view saw, row by row.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
struct Side {
    /// Row and column of the first cell; those of the cell at the corner of the side are 0.
    first: [i32; 2],
    cols: usize,
    /// Length of the free space in each cell, from the centre; 0 where it is not known.
    free: Vec<f32>,
}

/// A block of pixels.
struct Block {
    /// Of the side of the cube.
    cell: [i32; 2],
    /// Distance of its nearest sample from the centre; 0 where pixels are missing.
    nearest: f32,
}

impl FreeSpace {
    /// The space that a view looked through; `None` if its rays do not start in one point.
    pub fn of(view: &View) -> Option<Self> {
        let division = Division::of(view.image().size());
        let centre = view.frame().ray(division.middle(0)?)?.start;
        let width = BLOCKS_OF_CELL * division.spacing(view)? / FRAC_PI_4;
        let mut blocks: [Vec<Block>; 6] = Default::default();
        for row in 0..division.size.rows {
            for (col, values) in division.values(view, row).into_iter().enumerate() {
                let Some(middle) = division.middle(row * division.size.cols + col) else {
                    continue;
                };
                let Some(ray) = view.frame().ray(middle) else { continue };
                if ray.start != centre {
                    return None;
                }
                let nearest = values.nearest(view, middle, &centre).unwrap_or(0.0);
                for (side, place) in places(&ray.direction, width) {
                    blocks[side].push(Block { cell: cell(place, width), nearest });
                }
            }
        }
        Some(Self { centre: centre.into(), width, sides: blocks.map(|blocks| Side::of(&blocks)) })
    }

    /// Whether the view looked through a sensor-frame point, by more than half the width of a cell
    /// there.
    pub fn holds(&self, in_sensor: &Point3) -> bool {
        let from_centre = in_sensor - Point3::from(self.centre);
        let distance = from_centre.norm();
        let margin = 0.5 * self.width * FRAC_PI_4 * distance;
        let side = facing(&from_centre);
        let free = place(side, &from_centre)
            .and_then(|place| self.sides[side].free_in(cell(place, self.width)));
        free.is_some_and(|free| f64::from(free) > distance + margin)
    }

    /// Whether its parts fit each other, and all numbers are finite: a file may hold anything.
    pub fn is_sound(&self) -> bool {
        let numbers = self.centre.into_iter().chain([self.width]).all(f64::is_finite);
        let fits = |side: &Side| {
            side.free.iter().all(|free| free.is_finite()) && (side.free.is_empty() || side.cols > 0)
        };
        numbers && self.width > 0.0 && self.sides.iter().all(fits)
    }
}

/// The division of an image into blocks.
struct Division {
    image: ImageSize,
    /// Rows and columns of blocks.
    size: ImageSize,
    /// Pixels along the side of a block.
    step: usize,
}

/// The values of a block.
#[derive(Debug, Clone, Copy)]
struct Values {
    low: f32,
    high: f32,
    missing: usize,
    pixels: usize,
}

impl Division {
    fn of(image: ImageSize) -> Self {
        let step = (image.pixels() as f64 / SPACE_BLOCKS as f64).sqrt().ceil() as usize;
        let step = step.max(LEAST_STEP);
        let size = ImageSize { rows: image.rows.div_ceil(step), cols: image.cols.div_ceil(step) };
        Self { image, size, step }
    }

    /// The pixel in the middle of a block; `None` if the image has no such block.
    fn middle(&self, block: usize) -> Option<Pixel> {
        let middle = |block: usize, size: usize| {
            let first = block * self.step;
            usize::midpoint(first, (first + self.step).min(size))
        };
        let (row, col) = (block.checked_div(self.size.cols)?, block.checked_rem(self.size.cols)?);
        let pixel = Pixel::new(middle(row, self.image.rows), middle(col, self.image.cols));
        self.image.index(pixel).map(|_| pixel)
    }

    /// The values of a row of blocks.
    fn values(&self, view: &View, row: usize) -> Vec<Values> {
        let none = Values { low: f32::INFINITY, high: f32::NEG_INFINITY, missing: 0, pixels: 0 };
        let mut values = vec![none; self.size.cols];
        let rows = row * self.step..((row + 1) * self.step).min(self.image.rows);
        for row in rows {
            let blocks = view.image().row(row).chunks(self.step);
            for (to, pixels) in values.iter_mut().zip(blocks) {
                to.pixels += pixels.len();
                for value in pixels {
                    // A missing pixel is NaN, which is neither lower nor higher.
                    to.low = if *value < to.low { *value } else { to.low };
                    to.high = if *value > to.high { *value } else { to.high };
                    to.missing += usize::from(value.is_nan());
                }
            }
        }
        values
    }

    /// The usual angle between the rays of neighbours, of a few hundred of them: in a row or in a
    /// column, the larger one.
    fn spacing(&self, view: &View) -> Option<f64> {
        let direction = |block: usize| Some(view.frame().ray(self.middle(block)?)?.direction);
        let few = self.size.pixels().div_ceil(QUANTILE_SAMPLES).max(1);
        let apart = |gap: usize| {
            let pair = |k: usize| Some((direction(k)? - direction(k + gap)?).norm());
            let blocks = (0..self.size.pixels()).step_by(few);
            let in_row = blocks.filter(|k| gap > 1 || (k + 1) % self.size.cols > 0);
            median(in_row.filter_map(pair))
        };
        let both = apart(1).into_iter().chain(apart(self.size.cols));
        both.reduce(f64::max).filter(|spacing| *spacing > 0.0)
    }
}

impl Values {
    /// The distance of the nearest sample from a point; `None` where pixels are missing.
    fn nearest(&self, view: &View, middle: Pixel, centre: &Point3) -> Option<f32> {
        let Self { low, high, missing, pixels } = *self;
        if ((pixels - missing + 1) as f64) < LEAST_WHOLE * pixels as f64 {
            return None;
        }
        // The values of a sensor may fall with the distance.
        let point = |value: f32| view.frame().point(middle, f64::from(value));
        let distance = |value: f32| Some((point(value)? - centre).norm() as f32);
        Some(distance(low)?.min(distance(high)?))
    }
}

/// The side of the cube that a direction meets.
fn facing(direction: &Vector3) -> usize {
    let [x, y, z] = direction.map(f64::abs).into();
    let axis = if x >= y && x >= z { 0 } else { 1 + usize::from(z > y) };
    2 * axis + usize::from(direction[axis] < 0.0)
}

/// The sides that a direction meets or passes within two cells, which take part in the free space of
/// cells at the border. With its place on each.
fn places(direction: &Vector3, width: f64) -> impl Iterator<Item = (usize, [f64; 2])> {
    let met = facing(direction);
    let at = place(met, direction);
    // On the other side of a border, cells are up to twice as wide.
    let inside = at.is_some_and(|at| at.iter().all(|c| c.abs() < 1.0 - 4.0 * width));
    let others = (0..6).filter(move |side| *side != met && !inside).filter_map(move |side| {
        let at = place(side, direction)?;
        at.iter().all(|c| c.abs() < 1.0 + 2.0 * width).then_some((side, at))
    });
    at.map(|at| (met, at)).into_iter().chain(others)
}

/// The place of a direction on a side of the cube, row and column; `None` if it points elsewhere,
/// by more than twice the side.
fn place(side: usize, direction: &Vector3) -> Option<[f64; 2]> {
    let axis = side / 2;
    let ahead = if side.is_multiple_of(2) { direction[axis] } else { -direction[axis] };
    let across = [direction[(axis + 1) % 3], direction[(axis + 2) % 3]];
    let near = ahead > 0.0 && across.iter().all(|c| c.abs() < 2.0 * ahead);
    near.then(|| across.map(|c| as_angle(c / ahead)))
}

/// Nearly the angle of a tangent, over 45°: right at -1, 0 and 1, and off by 0.023 at most between. It grows
/// up to a tangent of 2.3. A polynomial takes a tenth of the time of `atan`.
fn as_angle(tangent: f64) -> f64 {
    const SLOPE: f64 = FRAC_PI_4.recip();
    tangent * (SLOPE - (SLOPE - 1.0) * tangent.abs())
}

/// Row and column of a place.
fn cell(place: [f64; 2], width: f64) -> [i32; 2] {
    place.map(|c| ((c + 1.0) / width).floor() as i32)
}

impl Side {
    fn of(blocks: &[Block]) -> Self {
        let span = |of: usize| {
            let cells = blocks.iter().map(|block| block.cell[of]);
            let (low, high) = (cells.clone().min()?, cells.max()?);
            Some((low, (high - low) as usize + 1))
        };
        let (Some((row, rows)), Some((col, cols))) = (span(0), span(1)) else {
            return Self::default();
        };
        let mut nearest = vec![f32::INFINITY; rows * cols];
        for Block { cell: [r, c], nearest: here } in blocks {
            let to = &mut nearest[(r - row) as usize * cols + (c - col) as usize];
            *to = to.min(*here);
        }
        Self { first: [row, col], cols, free: least_around(&nearest, cols) }
    }

    /// The length of the free space in a cell; `None` where the view saw nothing.
    fn free_in(&self, cell: [i32; 2]) -> Option<f32> {
        let [row, col] = [0, 1].map(|k| usize::try_from(cell[k] - self.first[k]).ok());
        let col = col.filter(|col| *col < self.cols)?;
        self.free.get(row? * self.cols + col).copied()
    }
}

/// The least value of each cell and the eight around it; 0 where one of them has no block.
fn least_around(nearest: &[f32], cols: usize) -> Vec<f32> {
    let least = |k: usize| {
        let inside = k >= cols && k + cols < nearest.len() && k % cols > 0 && (k + 1) % cols > 0;
        if !inside {
            return 0.0;
        }
        let around = [k - cols, k, k + cols].into_iter().flat_map(|k| &nearest[k - 1..k + 2]);
        let (low, high) = around.fold((f32::INFINITY, 0.0_f32), |(low, high), value| {
            (low.min(*value), high.max(*value))
        });
        if high.is_finite() { low } else { 0.0 }
    };
    (0..nearest.len()).map(least).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use transect_device::{DeviceFrame, Isometry3, RangeImage};
    use transect_sensors::{AngularScan, ImagingRadar, Intrinsics, Pinhole};

    /// The inside of a ball of radius 2, with something before it where `nearer` says so.
    fn view(frame: Arc<dyn DeviceFrame>, nearer: impl Fn(Pixel) -> Option<f64>) -> View {
        let distance = |pixel: Pixel| {
            let along = frame.ray(pixel).unwrap().direction * nearer(pixel).unwrap_or(2.0);
            frame.device_point(&Point3::from(along)).unwrap().d3 as f32
        };
        let size = frame.size();
        let image = RangeImage::from_values(size, size.all_pixels().map(distance).collect());
        View::new("v", image.unwrap(), frame, Isometry3::identity(), Some(0.0)).unwrap()
    }

    fn camera() -> Arc<dyn DeviceFrame> {
        let size = ImageSize { rows: 240, cols: 320 };
        let lens = Intrinsics { fx: 290.0, fy: 290.0, cx: 159.5, cy: 119.5 };
        Arc::new(Pinhole::new(size, lens).unwrap())
    }

    /// All around, and up and down by 80°.
    fn scanner() -> Arc<dyn DeviceFrame> {
        let size = ImageSize { rows: 321, cols: 720 };
        let half = 0.5_f64.to_radians();
        let [theta, phi] = [-3.1, -160.0 * half].map(|from| AngularScan::from_radians(from, half));
        Arc::new(ImagingRadar::new(size, theta, phi).unwrap())
    }

    #[test]
    fn space_is_free_up_to_what_was_measured() {
        for frame in [camera(), scanner()] {
            let size = frame.size();
            let free = FreeSpace::of(&view(frame.clone(), |_| None)).unwrap();
            assert!(free.is_sound());
            let inside = |p: &Pixel| {
                let off = |k: usize, count: usize| k.min(count - 1 - k);
                let wraps = frame.columns_wrap();
                off(p.row, size.rows) > 24 && (wraps || off(p.col, size.cols) > 24)
            };
            for pixel in size.all_pixels().filter(inside) {
                let along = frame.ray(pixel).unwrap().direction;
                assert!(free.holds(&Point3::from(along * 1.9)), "{pixel:?}");
                assert!(!free.holds(&Point3::from(along * 2.0)), "{pixel:?}");
            }
        }
        // A scanner whose lower half sees something nearer.
        let frame = scanner();
        let height = |pixel: Pixel| frame.ray(pixel).unwrap().direction.z;
        let halves = view(frame.clone(), |p| (height(p) < 0.0).then_some(1.0));
        let free = FreeSpace::of(&halves).unwrap();
        for pixel in frame.size().all_pixels().filter(|p| (0.2..0.95).contains(&height(*p).abs())) {
            let along = frame.ray(pixel).unwrap().direction;
            let is_free = [0.95, 1.9].map(|far| free.holds(&Point3::from(along * far)));
            assert_eq!(is_free, [true, height(pixel) > 0.0], "{pixel:?}");
        }
        let free = FreeSpace::of(&view(camera(), |_| None)).unwrap();
        for beside in [Point3::new(1.0, 0.0, 0.1), Point3::new(0.0, 0.0, -1.0), Point3::origin()] {
            assert!(!free.holds(&beside), "{beside}");
        }
    }

    #[test]
    fn a_rod_one_pixel_wide_ends_the_free_space_around_it() {
        for frame in [camera(), scanner()] {
            let size = frame.size();
            let rod = size.cols / 2 + 3;
            let seen = view(frame.clone(), |p| (p.col == rod).then_some(1.0));
            let free = FreeSpace::of(&seen).unwrap();
            let is_free = |col: usize| {
                let ray = frame.ray(Pixel::new(size.rows / 2, col)).unwrap();
                free.holds(&Point3::from(ray.direction * 1.5))
            };
            assert!((rod - 8..=rod + 8).all(|col| !is_free(col)));
            assert!(is_free(rod - 26) && is_free(rod + 26));
        }
    }

    #[test]
    fn missing_pixels_may_hide_something() {
        let frame = camera();
        let whole = view(frame.clone(), |_| None);
        let is_free = |missing: &dyn Fn(usize, usize) -> bool| {
            let mut values = whole.image().values().to_vec();
            for (k, value) in values.iter_mut().enumerate() {
                if missing(k / 320, k % 320) {
                    *value = f32::NAN;
                }
            }
            let image = RangeImage::from_values(frame.size(), values).unwrap();
            let free = FreeSpace::of(&whole.with_image(image).unwrap()).unwrap();
            free.holds(&Point3::new(0.0, 0.0, 1.5))
        };
        assert!(is_free(&|row, col| row % 4 == 0 && col % 4 == 0));
        assert!(!is_free(&|row, col| row / 4 == 30 && col / 4 == 40));
    }

    #[test]
    fn space_that_does_not_fit_is_told() {
        let free = FreeSpace::of(&view(camera(), |_| None)).unwrap();
        let sound = |change: fn(&mut FreeSpace)| {
            let mut changed = free.clone();
            change(&mut changed);
            changed.is_sound()
        };
        assert!(sound(|_| ()));
        assert!(!sound(|f| f.width = 0.0));
        assert!(!sound(|f| f.centre[1] = f64::NAN));
        assert!(!sound(|f| f.sides[4].cols = 0));
        assert!(!sound(|f| f.sides[4].free[7] = f32::NAN));
    }
}
