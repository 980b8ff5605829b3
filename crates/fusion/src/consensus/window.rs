//! A rectangle laid along a curve, from which neighbours of the same direction are gathered.

use crate::grid::{Numbered, PointGrid};
use transect_geometry::{Point2, Vector2};

/// Points that are compared with a window at once. No unit. Chosen by hand. Doubled: nothing
/// changes.
const CHUNK: usize = 32;

/// The neighbourhood of a node in its own direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    pub centre: Point2,
    /// Unit direction of the curve at the centre.
    pub tangent: Vector2,
    /// Half-width along the curve.
    pub reach: f64,
    /// Half-width across the curve.
    pub across: f64,
    /// Smallest cosine between directions of one surface.
    pub same_way: f64,
}

impl Window {
    /// Unit normal of the curve, to its left: positive y.
    pub fn normal(&self) -> Vector2 {
        left_of(&self.tangent)
    }

    /// Visits the points inside: number, place along (x) and across (y).
    pub fn visit(&self, grid: &PointGrid, mut visit: impl FnMut(usize, f64, f64)) {
        grid.runs_around(&self.centre, &self.half(), |points| {
            let all = |_: &Numbered| true;
            self.visit_run(points, |p| p.place, all, |_, p, x, y| visit(p.number as usize, x, y));
        });
    }

    /// Visits the points of a run that lie inside and pass `suits`: number in the run, point, place
    /// along and across.
    #[inline]
    pub fn visit_run<T>(
        &self,
        points: &[T],
        place: impl Fn(&T) -> Point2,
        suits: impl Fn(&T) -> bool,
        mut visit: impl FnMut(usize, &T, f64, f64),
    ) {
        for (chunk, points) in points.chunks(CHUNK).enumerate() {
            // Whether a point is inside cannot be guessed, so nothing branches on it.
            let (mut inside, mut count) = ([0; CHUNK], 0);
            for (i, point) in points.iter().enumerate() {
                let (x, y) = self.place(&place(point));
                inside[count] = i as u8;
                let is_inside = (x.abs() <= self.reach) & (y.abs() <= self.across);
                count += usize::from(is_inside & suits(point));
            }
            for i in inside[..count].iter().map(|i| usize::from(*i)) {
                let (x, y) = self.place(&place(&points[i]));
                visit(chunk * CHUNK + i, &points[i], x, y);
            }
        }
    }

    /// The place of a point along (x) and across (y) the curve.
    #[inline]
    pub fn place(&self, p: &Point2) -> (f64, f64) {
        let d = p - self.centre;
        (d.dot(&self.tangent), d.dot(&self.normal()))
    }

    /// Whether a direction is that of the same surface.
    #[inline]
    pub fn goes_along(&self, tangent: &Vector2) -> bool {
        tangent.dot(&self.tangent) >= self.same_way
    }

    /// Whether the centre of another window lies in this one, and both run the same way.
    pub fn holds(&self, other: &Self) -> bool {
        let d = other.centre - self.centre;
        d.dot(&self.tangent).abs() <= self.reach
            && d.dot(&self.normal()).abs() <= self.across
            && self.goes_along(&other.tangent)
    }

    /// Half-widths of the upright rectangle around the slanted one.
    #[inline]
    pub fn half(&self) -> Vector2 {
        let (x, y) = (self.tangent.x.abs(), self.tangent.y.abs());
        Vector2::new(x * self.reach + y * self.across, y * self.reach + x * self.across)
    }
}

/// A direction turned by a quarter to the left.
pub(super) fn left_of(tangent: &Vector2) -> Vector2 {
    Vector2::new(-tangent.y, tangent.x)
}
