//! Flat surfaces that are seen at a grazing angle.
//!
//! **Problem.** The rule for range jumps ([`BreakRule`]) breaks a surface that is seen more
//! obliquely than its largest angle: the far walls of a tunnel, a floor. With a larger angle it
//! would join what lies behind an edge.
//!
//! **Idea.** A jump stands alone. Along a flat surface the inverse of the range changes by equal
//! steps from pixel to pixel, however large they are. With depths that is exact, with ranges up to
//! the square of the angle between two rays.
//!
//! **Rule.** Two neighbours are joined if each of them lies on the line through the other one and
//! the pixel beyond it. A line may miss by what noise explains, and by a small share of the step.
//! Where noise explains much of the step, nothing is joined.
//!
//! **Limit.** Neighbours may share most of their noise, as in depth cameras. Four pixels in a row
//! are often one ramp between two surfaces then, and the rule is not used. With it, the halves of
//! the red kitchen would be 3 to 8 % farther apart (95 %).
//!
//! **Gain.** The median distance from the truth is two fifths smaller in the room, where more views
//! see each place. In a tunnel seen by cameras the curves are 16 % longer, and no less exact.
//!
//! **Cost.** A few operations for each pair of pixels that is not joined.

use crate::BreakRule;
use transect_device::{Neighbour, Pixel, RayProducts, View};

/// How far the line may miss, as a share of the step. No unit. Measured: five times as large, the
/// rims of the bunny are joined where the scanner errs, and its 95 % distance grows by 1.4 %.
const BENT: f64 = 0.02;

/// Noise of the miss over that of the difference of two ranges. Theory: √6 over √2.
const NOISE: f64 = 1.732;

/// Largest share of the step that the line may miss by, noise included. No unit. Theory: where the
/// neighbours of a jump lie anywhere within its step, two lines agree in a quarter of all cases.
/// Without the limit, a room with 0.5 % of noise gets 14 spurious pieces in place of 7.
const MOST: f64 = 0.5;

/// Pixels per word of a mask.
const WORD: usize = 64;

/// The rule for a view.
#[derive(Debug)]
pub struct Grazing<'a> {
    view: &'a View,
    /// Range difference that noise explains.
    slack: f64,
    /// Of sensors that have tables: lengths of rays of value 1, squared.
    products: Option<RayProducts>,
}

impl<'a> Grazing<'a> {
    /// The rule for a view; `None` if the break rule [joins no more](BreakRule::with_grazing).
    pub fn of(view: &'a View, rule: &BreakRule) -> Option<Self> {
        let products = || view.frame().ray_products(Neighbour::Left);
        rule.joins_grazing().then(|| Self {
            view,
            slack: f64::from(rule.slack()),
            products: products(),
        })
    }

    /// Those of some pairs in a word of a row that are joined after all: one bit per pixel, for its
    /// pair with a neighbour.
    pub fn joined(&self, neighbour: Neighbour, row: usize, word: usize, mut pairs: u64) -> u64 {
        let mut joined = 0;
        while pairs != 0 {
            let bit = pairs.trailing_zeros() as usize;
            pairs &= pairs - 1;
            let pixel = Pixel { row, col: word * WORD + bit };
            joined |= u64::from(self.is_flat(pixel, neighbour).unwrap_or(false)) << bit;
        }
        joined
    }

    /// Whether a pixel and its neighbour lie on one line with the pixels on either side; `None` if
    /// one is missing.
    fn is_flat(&self, pixel: Pixel, neighbour: Neighbour) -> Option<bool> {
        let at = |steps: isize| self.inverse_range(self.beside(pixel, neighbour, steps)?);
        let (here, next) = (at(0)?, at(1)?);
        let step = (here - next).abs();
        let miss = NOISE * self.slack * here.max(next).powi(2) + BENT * step;
        if miss > MOST * step {
            return Some(false);
        }
        let (before, beyond) = (at(-1)?, at(2)?);
        let misses = [2.0 * here - before - next, 2.0 * next - beyond - here];
        Some(misses.iter().all(|m| m.abs() <= miss))
    }

    /// The pixel some steps in the direction of a neighbour.
    fn beside(&self, pixel: Pixel, neighbour: Neighbour, steps: isize) -> Option<Pixel> {
        let size = self.view.image().size();
        match neighbour {
            Neighbour::Up => {
                let row = pixel.row.checked_add_signed(-steps).filter(|row| *row < size.rows)?;
                Some(Pixel { row, ..pixel })
            }
            Neighbour::Left if self.view.frame().columns_wrap() => {
                let col = (pixel.col as isize - steps).rem_euclid(size.cols as isize) as usize;
                Some(Pixel { col, ..pixel })
            }
            Neighbour::Left => {
                let col = pixel.col.checked_add_signed(-steps).filter(|col| *col < size.cols)?;
                Some(Pixel { col, ..pixel })
            }
        }
    }

    /// The inverse of the distance from the start of a pixel's ray.
    fn inverse_range(&self, pixel: Pixel) -> Option<f64> {
        let value = f64::from(self.view.image().get(pixel)?);
        let Some(products) = &self.products else {
            let frame = self.view.frame();
            return Some(1.0 / (frame.point(pixel, value)? - frame.ray(pixel)?.start).norm());
        };
        let of_column = products.columns.get(pixel.col).map_or(0.0, |p| p.here);
        let here = products.rows.get(pixel.row)?.here + of_column;
        Some(1.0 / (value * f64::from(here).sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;
    use std::sync::Arc;
    use transect_device::{DeviceFrame, ImageSize, Isometry3, Point3, RangeImage, Vector3};
    use transect_sensors::{AngularScan, ImagingRadar, Intrinsics, Pinhole, PointGrid, RayStarts};

    const SIZE: ImageSize = ImageSize { rows: 40, cols: 70 };

    fn rule(slack: f64) -> BreakRule {
        BreakRule::new(78_f64.to_radians(), slack).with_grazing()
    }

    fn view(frame: Arc<dyn DeviceFrame>, value: impl Fn(Pixel) -> f64) -> View {
        let values = frame.size().all_pixels().map(|pixel| value(pixel) as f32).collect();
        let image = RangeImage::from_values(frame.size(), values).unwrap();
        View::new("wall", image, frame, Isometry3::identity(), None).unwrap()
    }

    /// A camera that looks along a wall, which lies to the right of it or below.
    fn along_wall(neighbour: Neighbour, value: impl Fn(usize, f64) -> f64) -> View {
        let intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 0.0, cy: 0.0 };
        view(Arc::new(Pinhole::new(SIZE, intrinsics).unwrap()), |pixel| {
            let at = if neighbour == Neighbour::Left { pixel.col } else { pixel.row };
            value(at, 100.0 / at as f64)
        })
    }

    /// The same view by its points, as laser scanners write it.
    fn by_points(view: &View) -> View {
        let nowhere = Point3::new(f64::NAN, f64::NAN, f64::NAN);
        let point = |p: Pixel| view.frame().point(p, f64::from(view.image().get(p)?));
        let points = SIZE.all_pixels().map(|p| point(p).unwrap_or(nowhere)).collect();
        let viewpoint = RayStarts::Viewpoint(Point3::origin());
        let (frame, image) = PointGrid::new(SIZE, points, viewpoint).unwrap();
        View::new("points", image, Arc::new(frame), Isometry3::identity(), None).unwrap()
    }

    /// Whether a pixel's pair is joined by the break rule, and by this one.
    fn joined(view: &View, neighbour: Neighbour, pixel: Pixel, slack: f64) -> [bool; 2] {
        let rule = rule(slack);
        let other = view.frame().neighbour(pixel, neighbour).unwrap();
        let pair = view.frame().pair(view.image(), pixel, other);
        let bit = 1 << (pixel.col % WORD);
        let grazing = Grazing::of(view, &rule).unwrap();
        let found = grazing.joined(neighbour, pixel.row, pixel.col / WORD, bit);
        [pair.is_some_and(|pair| rule.holds(&pair)), found == bit]
    }

    #[test]
    fn a_wall_is_joined_however_obliquely_it_is_seen() {
        for neighbour in [Neighbour::Left, Neighbour::Up] {
            let camera = along_wall(neighbour, |_, depth| depth);
            for view in [by_points(&camera), camera] {
                for at in 4..20 {
                    let found = joined(&view, neighbour, Pixel::new(at, at), 0.0);
                    assert_eq!(found, [false, true], "{neighbour:?}, {at}");
                }
            }
        }
    }

    #[test]
    fn jumps_and_ends_of_walls_are_not_joined() {
        let neighbour = Neighbour::Left;
        // The wall ends at column 10, and a wall across stands behind it.
        let end = along_wall(neighbour, |at, depth| if at < 10 { 25.0 } else { depth });
        for (at, expected) in [(9, [true, false]), (10, [false; 2]), (11, [false; 2])] {
            let found = joined(&end, neighbour, Pixel::new(5, at), 0.0);
            assert_eq!(found[0] || found[1], expected[0], "{at}");
        }
        assert_eq!(joined(&end, neighbour, Pixel::new(5, 12), 0.0), [false, true]);
        let step = along_wall(neighbour, |at, _| if at < 30 { 2.0 } else { 3.0 });
        assert_eq!(joined(&step, neighbour, Pixel::new(5, 30), 0.0), [false; 2]);
        // Two pixels that fly between two walls are half a line.
        let flying = |at: usize, _: f64| [2.0, 2.0, 2.3, 2.7, 3.0][at.clamp(30, 34) - 30];
        let flying = along_wall(neighbour, flying);
        for at in 31..35 {
            assert!(!joined(&flying, neighbour, Pixel::new(5, at), 0.0)[1], "{at}");
        }
    }

    #[test]
    fn noise_as_large_as_the_steps_joins_nothing() {
        let view = along_wall(Neighbour::Left, |_, depth| depth);
        let pixel = Pixel::new(5, 15);
        let step = 100.0 / 14.0 - 100.0 / 15.0;
        assert!(joined(&view, Neighbour::Left, pixel, 0.2 * step)[1]);
        assert!(!joined(&view, Neighbour::Left, pixel, 0.4 * step)[1]);
        let hole = |at: usize, depth: f64| if at == 13 { f64::NAN } else { depth };
        let view = along_wall(Neighbour::Left, hole);
        assert!(!joined(&view, Neighbour::Left, pixel, 0.0)[1], "a pixel of the line is missing");
    }

    #[test]
    fn lines_go_on_across_the_seam_of_a_full_circle() {
        let size = ImageSize { rows: 3, cols: 400 };
        let theta = AngularScan::from_radians(0.0, TAU / 400.0);
        let phi = AngularScan::from_radians(0.0, 0.01);
        let radar = ImagingRadar::new(size, theta, phi).unwrap();
        // A wall along the seam's direction, 1 beside it.
        let normal = Vector3::new(0.1_f64.sin(), 0.1_f64.cos(), 0.0);
        let frame = Arc::new(radar);
        let view = view(frame.clone(), |pixel| {
            let along = frame.ray(pixel).unwrap().direction.dot(&normal);
            if along > 1e-3 { 1.0 / along } else { f64::NAN }
        });
        assert_eq!(joined(&view, Neighbour::Left, Pixel::new(1, 0), 0.0), [false, true]);
    }
}
