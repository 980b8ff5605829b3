//! Crossings of planes with pixel pairs, and their linear subpixel solution (section 3.6), in
//! `f64`.

use super::vertex::Kind;
use crate::SectionAxes;
use transect_device::{Pixel, Point3, Vector3, View};
use transect_geometry::Point2;

/// One plane crossing one pair of pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    /// Where, in plane coordinates.
    pub position: Point2,
    /// The pixel nearer to the crossing.
    pub pixel: Pixel,
    /// Direction of that pixel's ray, or of the pair's other one, in the sensor frame.
    pub ray: Vector3,
    /// Whether the pair is of two rows; a diagonal is one, too.
    pub across_rows: bool,
    /// From one sample of the pair to the other, in plane coordinates with the height third.
    pub pair: Vector3,
    /// A step on the surface across the curve, in the same coordinates: the pair, or a better one.
    pub across: Vector3,
    /// Distance between the two rays at the surface, in the length unit.
    pub spacing: f32,
    /// Share of the way from the first sample to the second, by their heights.
    pub share: f32,
    /// Whether pixels are missing between this crossing and the next one of its curve.
    pub bridged_after: bool,
}

impl Crossing {
    /// Heights of the pair's samples over the plane, in the length unit.
    pub fn heights(&self) -> [f64; 2] {
        let share = f64::from(self.share);
        [-share * self.pair.z, (1.0 - share) * self.pair.z]
    }
}

/// Solves the crossing of a pair with the plane at a level.
pub(super) fn solve(
    view: &View,
    axes: &SectionAxes,
    kind: Kind,
    [a, b]: [Pixel; 2],
    level: i32,
) -> Crossing {
    // A joined pair has both points; should a backend disagree with itself, the crossing becomes
    // NaN and is refused as a curve's node.
    let nowhere = Point3::new(f64::NAN, f64::NAN, f64::NAN);
    let p = view.point_in_sensor(a).unwrap_or(nowhere);
    let q = view.point_in_sensor(b).unwrap_or(nowhere);
    let level = f64::from(level);
    let t = parameter(axes.level().at(&p) - level, axes.level().at(&q) - level);
    let d = q - p;
    // From the nearer sample, so that crossings at one sample are at one place.
    let (pixel, at) = if t < 0.5 { (a, p + d * t) } else { (b, q - d * (1.0 - t)) };
    let pair = axes.turn(&d);
    let ray = view.frame().ray(pixel).map_or(Vector3::z(), |r| r.direction);
    Crossing {
        position: axes.in_plane(&at),
        pixel,
        ray,
        across_rows: kind != Kind::Left,
        pair,
        across: pair,
        spacing: (d - ray * d.dot(&ray)).norm() as f32,
        share: t as f32,
        bridged_after: false,
    }
}

/// Where between two heights over a plane the line through them meets it (errata to 3.6).
///
/// Clamped: labels are decided in `f32`, heights here in `f64`, so a sample that is on the plane
/// within rounding may have the other sign.
pub(super) fn parameter(height_a: f64, height_b: f64) -> f64 {
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
}
