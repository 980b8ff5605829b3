//! Crossings of planes with pixel pairs, and their linear subpixel solution (section 3.6), in
//! `f64`.

use super::bend::Bend;
use super::vertex::Kind;
use crate::SectionAxes;
use crate::repeats::OnCurve;
use crate::subpixel::parameter;
use transect_device::{MISSING_POINT, Pixel, Point3, Vector3, View};
use transect_geometry::Point2;

/// One plane crossing one pair of pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    /// Where, in plane coordinates.
    pub position: Point2,
    /// The pixel nearer to the crossing.
    pub pixel: Pixel,
    /// Direction of that pixel's ray, or of the pair's other one, in plane coordinates with the
    /// height third.
    pub ray: Vector3,
    /// Whether the pair is of two rows; a diagonal is one, too.
    pub across_rows: bool,
    /// From one sample of the pair to the other, in plane coordinates with the height third.
    pub pair: Vector3,
    /// A step on the surface across the curve, in the same coordinates: the pair, or a better one.
    pub across: Vector3,
    /// How far the surface may lie off the pair's chord.
    pub bend: Bend,
    /// Distance between the two rays at the surface, in the length unit.
    pub spacing: f32,
    /// Share of the way from the first sample to the second, by their heights.
    pub share: f32,
    /// Whether pixels are missing between this crossing and the next one of its curve.
    pub bridged_after: bool,
}

impl OnCurve for Crossing {
    fn position(&self) -> Point2 {
        self.position
    }

    fn spacing(&self) -> f64 {
        f64::from(self.spacing)
    }

    fn bridged_after(&mut self) -> &mut bool {
        &mut self.bridged_after
    }
}

impl Crossing {
    /// The crossing of a pair at a share of the way between its samples.
    ///
    /// The samples and the rays' directions are in one frame; `turn` and `place` lead from it to
    /// plane coordinates.
    pub fn new(
        kind: Kind,
        [(a, p), (b, q)]: [(Pixel, Point3); 2],
        share: f64,
        direction: impl Fn(Pixel) -> Vector3,
        turn: impl Fn(&Vector3) -> Vector3,
        place: impl Fn(&Point3) -> Point2,
    ) -> Self {
        let d = q - p;
        // From the nearer sample, so that crossings at one sample are at one place.
        let (pixel, at) = if share < 0.5 { (a, p + d * share) } else { (b, q - d * (1.0 - share)) };
        let (pair, ray) = (turn(&d), direction(pixel));
        Self {
            position: place(&at),
            pixel,
            ray: turn(&ray),
            across_rows: kind != Kind::Left,
            pair,
            across: pair,
            bend: Bend::default(),
            spacing: (d - ray * d.dot(&ray)).norm() as f32,
            share: share as f32,
            bridged_after: false,
        }
    }

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
    [first, second]: [Pixel; 2],
    level: i32,
) -> Crossing {
    let (p, q) = (sample(view, first), sample(view, second));
    let height = |p: &Point3| axes.level().at(p) - f64::from(level);
    let share = parameter(height(&p), height(&q));
    let direction = |pixel| direction(view, pixel);
    let turn = |v: &Vector3| axes.turn(v);
    let samples = [(first, p), (second, q)];
    Crossing::new(kind, samples, share, direction, turn, |p| axes.in_plane(p))
}

/// A sample in the sensor frame.
///
/// A joined pair has both points. Should a backend disagree with itself, the crossing becomes NaN
/// and is refused as a curve's node.
pub(super) fn sample(view: &View, pixel: Pixel) -> Point3 {
    view.point_in_sensor(pixel).unwrap_or(MISSING_POINT)
}

/// Direction of a pixel's ray in the sensor frame.
pub(super) fn direction(view: &View, pixel: Pixel) -> Vector3 {
    view.frame().ray(pixel).map_or(Vector3::z(), |ray| ray.direction)
}
