//! Crossings of planes with pixel pairs, and their linear subpixel solution (section 3.6).

use crate::SectionAxes;
use transect_device::{Pixel, Point3, Vector3, View};
use transect_geometry::Point2;

/// One plane crossing one pair of pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    /// Where, in plane coordinates.
    pub position: Point2,
    /// Which plane, as a level from the base of the view's axes.
    pub level: i32,
    /// The pixel nearer to the crossing.
    pub pixel: Pixel,
    /// Whether the pair is of two rows of one column; a diagonal counts as such, too.
    pub across_rows: bool,
    /// From one sample of the pair to the other, in plane coordinates with the height third.
    pub pair: Vector3,
    /// Distance between the two rays at the surface, in the length unit.
    pub spacing: f32,
}

/// First crossing's number and lowest level of a pair; level `k` has number `first + (k − low)`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Base {
    pub first: u32,
    pub low: i32,
}

impl Base {
    /// Of a pair without crossings.
    pub const NONE: Self = Self { first: u32::MAX, low: 0 };

    /// Number of the crossing at a level that this pair has.
    pub fn number(self, level: i32) -> u32 {
        self.first.wrapping_add(level.wrapping_sub(self.low) as u32)
    }
}

/// The crossings of one pair of pixels with planes `low..high`.
pub(super) fn solve(
    view: &View,
    axes: &SectionAxes,
    (a, b): (Pixel, Pixel),
    (low, high): (i32, i32),
    out: &mut Vec<Crossing>,
) {
    // An unbroken pair has both points; should a backend disagree with itself, the crossings become
    // NaN, keep their numbers, and are refused as curve nodes.
    let nowhere = Point3::new(f64::NAN, f64::NAN, f64::NAN);
    let p = view.point_in_sensor(a).unwrap_or(nowhere);
    let q = view.point_in_sensor(b).unwrap_or(nowhere);
    let (level_p, level_q) = (axes.level().at(&p), axes.level().at(&q));
    let ray = view.frame().ray(a).map_or(Vector3::z(), |r| r.direction);
    let d = q - p;
    let spacing = (d - ray * d.dot(&ray)).norm() as f32;
    let pair = axes.turn(&d);
    for level in low..high {
        let t = parameter(level_p - f64::from(level), level_q - f64::from(level));
        let pixel = if t < 0.5 { a } else { b };
        // From the nearer sample, so that crossings at one sample are at one place.
        let at = if t < 0.5 { p + d * t } else { q - d * (1.0 - t) };
        let position = axes.in_plane(&at);
        let across_rows = a.row != b.row;
        out.push(Crossing { position, level, pixel, across_rows, pair, spacing });
    }
}

/// Where between two heights over a plane the line through them meets it (errata to 3.6).
///
/// Clamped: labels are decided in `f32`, heights here in `f64`, so a sample that is on the plane
/// within rounding may have the other sign.
fn parameter(height_a: f64, height_b: f64) -> f64 {
    let t = height_a / (height_a - height_b);
    if t.is_nan() { 0.5 } else { t.clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plane_is_met_between_the_samples() {
        assert_eq!(parameter(-1.0, 3.0), 0.25);
        assert_eq!(parameter(0.0, 3.0), 0.0);
        assert_eq!(parameter(1e-9, 3.0), 0.0, "a label that rounding flipped");
        assert_eq!(parameter(0.0, 0.0), 0.5);
    }

    #[test]
    fn numbers_of_one_pair_are_consecutive() {
        let base = Base { first: 7, low: -3 };
        assert_eq!((base.number(-3), base.number(0)), (7, 10));
    }
}
