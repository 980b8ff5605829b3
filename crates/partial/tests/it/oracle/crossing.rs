//! Crossings of planes with pixel pairs, and their linear subpixel solution (section 3.6).

use transect_device::{Pixel, Point3, View};
use transect_geometry::Point2;
use transect_partial::SectionAxes;

/// One plane crossing one pair of pixels.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    /// Where, in plane coordinates.
    pub position: Point2,
    /// Which plane, as a level from the base of the view's axes.
    pub level: i32,
    /// The two samples, in the order of rows and columns.
    pub pair: [Pixel; 2],
    /// Their levels and distance: how well the position is known.
    pub levels: [f64; 2],
    pub length: f64,
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
    let d = q - p;
    let pair = if (a.row, a.col) <= (b.row, b.col) { [a, b] } else { [b, a] };
    for level in low..high {
        let t = parameter(level_p - f64::from(level), level_q - f64::from(level));
        // From the nearer sample, so that crossings at one sample are at one place.
        let at = if t < 0.5 { p + d * t } else { q - d * (1.0 - t) };
        let position = axes.in_plane(&at);
        let levels = [level_p, level_q];
        out.push(Crossing { position, level, pair, levels, length: d.norm() });
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
