//! The surface's and the plane's curves in the device frame, both linear (3.6, errata).

use super::angular_grid::AngularStep;
use super::{PairMeeting, root};
use transect_device::{Point3, Ray, SensorPlane, Vector3};

/// Where the two interpolated curves meet.
///
/// Along the pair the surface's range is `r₀ + (r₁ − r₀) t`. Of the plane the reciprocal of the
/// range is interpolated, `w₀ + (w₁ − w₀) t`, which passes through 0 where the rays pass the
/// plane's horizon. They meet where their product is 1. `None` for a plane through the ray's start,
/// which has no reciprocal.
pub(super) fn meet(
    rays: &[Ray; 2],
    points: &[Point3; 2],
    plane: &SensorPlane,
    angles: Option<&AngularStep>,
) -> Option<PairMeeting> {
    let range = |k: usize| (points[k] - rays[k].start).dot(&rays[k].direction);
    let per_range = |k: usize| {
        let ahead = plane.offset - plane.normal.dot(&rays[k].start.coords);
        plane.normal.dot(&rays[k].direction) / ahead
    };
    let (r, w) = ([range(0), range(1)], [per_range(0), per_range(1)]);
    let mix = |[a, b]: [f64; 2], t: f64| a + (b - a) * t;
    let parameter = root::between_0_and_1(|t| Some(mix(r, t) * mix(w, t) - 1.0))?;
    let start = rays[0].start + (rays[1].start - rays[0].start) * parameter;
    let direction = match angles {
        Some(step) => step.ray(step.size * parameter),
        None => between(&rays[0].direction, &rays[1].direction, parameter)?,
    };
    Some(PairMeeting { parameter, point: start + direction * mix(r, parameter) })
}

/// The unit direction between two that are a pixel apart.
fn between(a: &Vector3, b: &Vector3, t: f64) -> Option<Vector3> {
    (a + (b - a) * t).try_normalize(0.0)
}
