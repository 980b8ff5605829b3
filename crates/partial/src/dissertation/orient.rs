//! The direction of a curve: solid on the left, seen against the plane's normal (3.7, errata).
//!
//! Every node whose two rays tell votes for or against the direction in which the curve was traced;
//! two ways of telling are built:
//!
//! * [`DirectionRule::PlanePoints`], free of conventions. Of the two pixels of a border, one has a
//!   ray that meets the plane before the surface: its point of the plane is in free space. The
//!   point of the other one is behind the surface. So inside lies from the first of these points
//!   towards the second, and must be on the left of the curve.
//! * [`DirectionRule::Codes`], the printed steps a–d. (a) The side of the plane on which the
//!   pixel's ray starts. (b) The right-hand pixel, from the code and the way from the last contour
//!   pixel. The printed lines of codes 1 and 2 are exchanged (errata), and mirrored on grids of the
//!   other handedness. (c) Whether that pixel's ray meets the plane before the object, so that the
//!   plane is outside there. (d) The direction is right if the start is on the positive side and
//!   right is outside, or neither. A right-hand pixel of another surface tells nothing about this
//!   one.
//!
//! Where no node tells (a plane through the sensor, which no ray meets), the high side of the plane
//! does. Seen from the sensor it is on the left, whatever side of the plane the sensor is on. On a
//! mirrored grid it is on the right.

use super::code::Surface;
use super::crossing::Crossing;
use super::plane_image::PlaneImage;
use super::samples::Samples;
use serde::{Deserialize, Serialize};
use transect_device::{Handedness, Neighbour, Pixel, SensorPlane};
use transect_geometry::{Point2, Vector2};

/// How a curve's direction is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DirectionRule {
    /// From where the rays of a border's two pixels meet the plane.
    #[default]
    PlanePoints,
    /// From codes and right-hand pixels, as printed (errata).
    Codes,
}

/// Finds the direction of the curves of one plane.
#[derive(Clone, Copy)]
pub(super) struct Orient<'a> {
    pub rule: DirectionRule,
    pub samples: &'a Samples<'a>,
    pub surface: &'a Surface<'a>,
    pub plane: SensorPlane,
    pub plane_image: &'a PlaneImage,
}

impl Orient<'_> {
    /// Whether a traced curve already has its solid on the left.
    pub fn solid_on_left(&self, crossings: &[Crossing], closed: bool, high_on_left: bool) -> bool {
        let votes = self.votes(crossings, closed);
        if votes == 0.0 {
            high_on_left == (self.samples.view.frame().handedness() == Handedness::ColumnsRight)
        } else {
            votes > 0.0
        }
    }

    /// Positive if the nodes find that the solid is on the left; 0 where no node tells.
    pub fn votes(&self, crossings: &[Crossing], closed: bool) -> f64 {
        match self.rule {
            DirectionRule::PlanePoints => by_plane_points(self, crossings, closed),
            DirectionRule::Codes => by_codes(self, crossings),
        }
    }

    /// Unit direction in the plane from free space to behind the surface; `None` unless both rays
    /// meet the plane, one of them before the surface.
    pub fn towards_inside(&self, crossing: &Crossing) -> Option<Vector2> {
        towards_inside(self, crossing)
    }
}

/// Sum of the votes: each is the sine between the curve and the direction to the inside.
fn by_plane_points(orient: &Orient<'_>, crossings: &[Crossing], closed: bool) -> f64 {
    let vote = |k: usize| {
        let towards_inside = towards_inside(orient, &crossings[k])?;
        tangent(crossings, k, closed).map(|t| t.perp(&towards_inside))
    };
    (0..crossings.len()).filter_map(vote).sum()
}

/// Unit direction in the plane from free space to behind the surface; `None` unless both rays meet
/// the plane, one of them before the surface.
fn towards_inside(orient: &Orient<'_>, crossing: &Crossing) -> Option<Vector2> {
    let frame = orient.samples.view.frame();
    let on_plane = |p: Pixel| -> Option<(Point2, bool)> {
        let value = orient.plane_image.get(p);
        let point = value.is_finite().then(|| frame.point(p, value)).flatten()?;
        let object = f64::from(orient.samples.view.image().get(p)?);
        Some((orient.samples.axes.in_plane(&point), orient.plane_image.is_before(p, object)))
    };
    let (a, a_is_free) = on_plane(crossing.first)?;
    let (b, b_is_free) = on_plane(crossing.second)?;
    let inside = if a_is_free { b - a } else { a - b };
    (a_is_free != b_is_free).then(|| inside.try_normalize(0.0)).flatten()
}

/// Unit direction of the trace at a crossing, from its neighbours.
fn tangent(crossings: &[Crossing], k: usize, closed: bool) -> Option<Vector2> {
    let n = crossings.len();
    let (before, after) = if closed {
        ((k + n - 1) % n, (k + 1) % n)
    } else {
        (k.saturating_sub(1), (k + 1).min(n - 1))
    };
    (crossings[after].position - crossings[before].position).try_normalize(0.0)
}

/// Number of nodes for which steps a–d find the direction right, less those that find it wrong.
fn by_codes(orient: &Orient<'_>, crossings: &[Crossing]) -> f64 {
    let mut votes = 0.0;
    let mut last: Option<Pixel> = None;
    for (k, crossing) in crossings.iter().enumerate() {
        if k > 0 && crossings[k - 1].second != crossing.second {
            last = Some(crossings[k - 1].second);
        }
        if let Some(right) = last.and_then(|last| right_pixel(orient, last, crossing))
            && let Some(correct) = is_correct(orient, right)
        {
            votes += if correct { 1.0 } else { -1.0 };
        }
    }
    votes
}

/// Step b: the pixel on the right of the way from the last contour pixel to this one.
fn right_pixel(orient: &Orient<'_>, last: Pixel, crossing: &Crossing) -> Option<Pixel> {
    let grid = &orient.samples.grid;
    let (rows, cols) = grid.offset(last, crossing.second);
    let sign = |x: f64| if x == 0.0 { 0 } else { x.signum() as i32 };
    let (down, right) = match crossing.neighbour {
        Neighbour::Up => (sign(cols), 0),
        Neighbour::Left => (0, -sign(rows)),
    };
    let mirrored = orient.samples.view.frame().handedness() == Handedness::ColumnsLeft;
    let (down, right) = if mirrored { (-down, -right) } else { (down, right) };
    let pixel = ((down, right) != (0, 0)).then(|| grid.step(crossing.second, down, right));
    pixel.flatten().filter(|right| orient.surface.alike(crossing.second, *right))
}

/// Steps a, c and d; `None` where the pixel is missing, its ray starts on the plane, or it meets
/// the plane where the sensor does not see.
fn is_correct(orient: &Orient<'_>, right: Pixel) -> Option<bool> {
    let view = orient.samples.view;
    let (ray, plane) = (view.frame().ray(right)?, &orient.plane);
    let height = plane.normal.dot(&ray.start.coords) - plane.offset;
    let meets = height * plane.normal.dot(&ray.direction) < 0.0;
    if height == 0.0 || (meets && orient.plane_image.get(right).is_infinite()) {
        return None;
    }
    let object = f64::from(view.image().get(right)?);
    let right_is_outside = orient.plane_image.is_before(right, object);
    Some((height > 0.0) == right_is_outside)
}
