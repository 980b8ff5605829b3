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
//! 3. Space is free in a cell up to the nearest sample there and in the eight cells around it,
//!    since poses err a little. It is not known where pixels are missing, which may hide something.
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
        let Rays { centre, spacing, grows } = division.rays(view)?;
        let width = BLOCKS_OF_CELL * spacing / FRAC_PI_4;
        let mut blocks: [Vec<Block>; 6] = Default::default();
        for row in 0..division.size.rows {
            for (col, values) in division.values(view, row).iter().enumerate() {
                let Some(middle) = division.middle(row * division.size.cols + col) else {
                    continue;
                };
                let value = f64::from(if grows { values.low } else { values.high });
                let whole = values.are_whole().then(|| view.frame().point(middle, value));
                let whole = whole.flatten().map(|point| point - centre);
                let ray = || view.frame().ray(middle).map(|ray| ray.direction);
                let Some(direction) = whole.or_else(ray) else { continue };
                let nearest = whole.map_or(0.0, |from_centre| from_centre.norm() as f32);
                for (side, place) in places(&direction, width) {
                    blocks[side].push(Block { cell: cell(place, width), nearest });
                }
            }
        }
        let most = division.size.pixels();
        let sides = blocks.map(|blocks| Side::of(&blocks, most).unwrap_or_default());
        Some(Self { centre: centre.into(), width, sides })
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

/// What the rays of a view have in common.
struct Rays {
    /// Where they start.
    centre: Point3,
    /// The usual angle between those of neighbouring blocks: in a row or in a column, the larger
    /// one.
    spacing: f64,
    /// Whether the sensor's values grow with the distance.
    grows: bool,
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

    /// What a few hundred rays tell of all; `None` if they do not start in one point.
    fn rays(&self, view: &View) -> Option<Rays> {
        let ray = |block: usize| view.frame().ray(self.middle(block)?);
        let step = self.size.pixels().div_ceil(QUANTILE_SAMPLES).max(1);
        let few = (0..self.size.pixels()).step_by(step);
        let centre = few.clone().find_map(ray)?.start;
        if few.clone().filter_map(ray).any(|ray| ray.start != centre) {
            return None;
        }
        let apart = |gap: usize| {
            let pair = |k: usize| Some((ray(k)?.direction - ray(k + gap)?.direction).norm());
            let in_row = |k: &usize| gap > 1 || !(k + 1).is_multiple_of(self.size.cols);
            median(few.clone().filter(in_row).filter_map(pair))
        };
        let both = apart(1).into_iter().chain(apart(self.size.cols));
        let spacing = both.reduce(f64::max).filter(|spacing| *spacing > 0.0)?;
        let (low, high) = view.image().extremes()?;
        let grows = few.clone().find_map(|block| {
            let point = |value: f32| view.frame().point(self.middle(block)?, f64::from(value));
            Some((point(low)? - centre).norm() <= (point(high)? - centre).norm())
        });
        Some(Rays { centre, spacing, grows: grows? })
    }
}

impl Values {
    /// Whether nearly every pixel has a sample.
    fn are_whole(&self) -> bool {
        let Self { missing, pixels, .. } = *self;
        (pixels - missing + 1) as f64 >= LEAST_WHOLE * pixels as f64
    }
}

/// The side of the cube that a direction meets.
fn facing(direction: &Vector3) -> usize {
    let [x, y, z] = direction.map(f64::abs).into();
    let axis = if x >= y && x >= z { 0 } else { 1 + usize::from(z > y) };
    2 * axis + usize::from(direction[axis] < 0.0)
}

/// The sides that a direction meets or passes within two cells, which take part in the free space
/// of cells at the border. With its place on each.
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

/// Nearly the angle of a tangent, over 45°: right at -1, 0 and 1, and off by 0.023 at most between.
/// It grows up to a tangent of 2.3. A polynomial takes a tenth of the time of `atan`.
fn as_angle(tangent: f64) -> f64 {
    const SLOPE: f64 = FRAC_PI_4.recip();
    tangent * (SLOPE - (SLOPE - 1.0) * tangent.abs())
}

/// Row and column of a place.
fn cell(place: [f64; 2], width: f64) -> [i32; 2] {
    place.map(|c| ((c + 1.0) / width).floor() as i32)
}

impl Side {
    /// The side with these blocks; `None` without blocks, and if it has more cells than `most`, the
    /// blocks of the view. Nearly all cells are empty then, as where a line of pixels runs askew.
    fn of(blocks: &[Block], most: usize) -> Option<Self> {
        let span = |of: usize| {
            let cells = blocks.iter().map(|block| block.cell[of]);
            let (low, high) = (cells.clone().min()?, cells.max()?);
            Some((low, usize::try_from(high.checked_sub(low)?).ok()? + 1))
        };
        let ((row, rows), (col, cols)) = (span(0)?, span(1)?);
        let count = rows.checked_mul(cols).filter(|count| *count <= most)?;
        let mut nearest = vec![f32::INFINITY; count];
        for Block { cell: [r, c], nearest: here } in blocks {
            let to = &mut nearest[(r - row) as usize * cols + (c - col) as usize];
            *to = to.min(*here);
        }
        Some(Self { first: [row, col], cols, free: least_around(&nearest, cols) })
    }

    /// The length of the free space in a cell; `None` where the view saw nothing.
    fn free_in(&self, cell: [i32; 2]) -> Option<f32> {
        let [row, col] = [0, 1].map(|k| usize::try_from(cell[k].checked_sub(self.first[k])?).ok());
        let col = col.filter(|col| *col < self.cols)?;
        self.free.get(row? * self.cols + col).copied()
    }
}

/// The least value of each cell and the eight around it; 0 where one of them has no block.
fn least_around(nearest: &[f32], cols: usize) -> Vec<f32> {
    let least = |k: usize| {
        let in_row = !k.is_multiple_of(cols) && !(k + 1).is_multiple_of(cols);
        let inside = in_row && k >= cols && k + cols < nearest.len();
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
    use transect_device::{
        DeviceFrame, DevicePoint, Handedness, Isometry3, RangeImage, Ray, SensorPlane,
    };
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

    /// A camera whose values are inverse depths, which fall with the distance.
    #[derive(Debug)]
    struct Disparities(Arc<dyn DeviceFrame>);

    impl DeviceFrame for Disparities {
        fn size(&self) -> ImageSize {
            self.0.size()
        }

        fn kind(&self) -> &'static str {
            "Disparities"
        }

        fn handedness(&self) -> Handedness {
            self.0.handedness()
        }

        fn ray(&self, pixel: Pixel) -> Option<Ray> {
            self.0.ray(pixel)
        }

        fn point(&self, pixel: Pixel, d3: f64) -> Option<Point3> {
            self.0.point(pixel, 1.0 / d3)
        }

        fn device_point(&self, p: &Point3) -> Option<DevicePoint> {
            self.0.device_point(p).map(|at| DevicePoint { d3: 1.0 / at.d3, ..at })
        }

        fn plane_value(&self, pixel: Pixel, plane: &SensorPlane) -> Option<f64> {
            self.0.plane_value(pixel, plane).map(f64::recip)
        }

        fn extent(&self, direction: &Vector3, nearest: f64, farthest: f64) -> (f64, f64) {
            self.0.extent(direction, 1.0 / nearest, 1.0 / farthest)
        }
    }

    #[test]
    fn values_may_fall_with_the_distance() {
        let rod = |p: Pixel| (p.col == 163).then_some(1.0);
        let depths = FreeSpace::of(&view(camera(), rod)).unwrap();
        let inverse = FreeSpace::of(&view(Arc::new(Disparities(camera())), rod)).unwrap();
        for (x, far) in [(0, 0.9), (0, 1.5), (60, 1.5), (60, 1.9), (60, 2.1)] {
            let along = camera().ray(Pixel::new(120, 163 + x)).unwrap().direction;
            let holds = [&depths, &inverse].map(|free| free.holds(&Point3::from(along * far)));
            assert_eq!(holds[0], holds[1], "{x} {far}");
            assert_eq!(holds[0], far < if x == 0 { 1.0 } else { 2.0 }, "{x} {far}");
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
    fn blocks_far_from_each_other_make_no_side() {
        let side = |cells: [[i32; 2]; 2]| {
            let blocks = cells.map(|cell| Block { cell, nearest: 1.0 });
            Side::of(&blocks, 100).map(|side| side.free.len())
        };
        assert_eq!(side([[3, 4], [12, 13]]), Some(100));
        assert_eq!(side([[3, 4], [13, 13]]), None);
        assert_eq!(side([[i32::MIN, 0], [i32::MAX, 0]]), None);
        // A file may state any first cell.
        let mut free = FreeSpace::of(&view(camera(), |_| None)).unwrap();
        free.sides[4].first = [i32::MIN; 2];
        assert!(!free.holds(&Point3::new(0.0, 0.0, 1.0)));
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
