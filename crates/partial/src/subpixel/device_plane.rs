//! The surface's curve in the device frame and the exact plane (3.6, Eq. 3.5 and 3.6).

use super::angular_grid::AngularStep;
use super::{PairLine, PairMeeting, height, root};
use transect_device::{DeviceFrame, Point3, SensorPlane};

/// Newton steps from the linearised equation to the exact one; each squares what is left of an
/// error that is already quadratic in the step.
const REFINEMENTS: usize = 3;

/// The solution for a grid of two angles and a range.
///
/// With `r = r₀ + A δ` (3.6) and the plane `r g(δ) = offset` (3.5), `g` the normal's part along the
/// ray, linearised as `g₀ + g₀′ δ` (errata): `l δ² + m δ + n = 0` with `l = A g₀′`,
/// `m = A g₀ + r₀ g₀′`, `n = r₀ g₀ − offset`. Of its two solutions the one within the step counts.
pub(super) fn on_angles(
    step: &AngularStep,
    [r0, r1]: [f64; 2],
    plane: &SensorPlane,
) -> Option<PairMeeting> {
    let slope = (r1 - r0) / step.size;
    let (g0, g_slope) = (plane.normal.dot(&step.ray(0.0)), plane.normal.dot(&step.ray_slope(0.0)));
    let (l, m, n) = (slope * g_slope, slope * g0 + r0 * g_slope, r0 * g0 - plane.offset);
    let within = |delta: &f64| (0.0..=1.0).contains(&(delta / step.size));
    let mut delta = quadratic(l, m, n).into_iter().flatten().find(within)?;
    for _ in 0..REFINEMENTS {
        let (r, g) = (r0 + slope * delta, plane.normal.dot(&step.ray(delta)));
        let change = slope * g + r * plane.normal.dot(&step.ray_slope(delta));
        delta -= (r * g - plane.offset) / change;
    }
    let parameter = delta / step.size;
    let point = Point3::from(step.ray(delta) * (r0 + slope * delta));
    (0.0..=1.0).contains(&parameter).then_some(PairMeeting { parameter, point })
}

/// The solutions of `l x² + m x + n = 0`, without cancellation; one for `l = 0`.
fn quadratic(l: f64, m: f64, n: f64) -> [Option<f64>; 2] {
    let discriminant = m * m - 4.0 * l * n;
    // The root of a negative discriminant is not a number, and neither are the solutions.
    let q = -0.5 * (m + discriminant.sqrt().copysign(m));
    [n / q, q / l].map(|x| x.is_finite().then_some(x))
}

/// The solution for any sensor.
///
/// Between the pixels, at a share `t` of the way, a value's point is taken as `(1 − t) f(a, d) + t
/// f(b, d)` with the mapping `f` at both pixels and `d` linear in `t`. This is exact for a
/// pinhole's depths, and quadratic in the step for other sensors, like the linear value itself.
pub(super) fn on_any(
    frame: &dyn DeviceFrame,
    line: &PairLine,
    [first, second]: [f64; 2],
    plane: &SensorPlane,
) -> Option<PairMeeting> {
    let point = |t: f64| {
        let value = first + (second - first) * t;
        let (p, q) = (frame.point(line.first, value)?, frame.point(line.second, value)?);
        Some(p + (q - p) * t)
    };
    let parameter = root::between_0_and_1(|t| Some(height(plane, &point(t)?)))?;
    Some(PairMeeting { parameter, point: point(parameter)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadratics_keep_their_small_root() {
        let [small, large] = quadratic(1.0, 1e9, 1.0);
        assert!((small.unwrap() + 1e-9).abs() < 1e-24);
        assert!((large.unwrap() + 1e9).abs() < 1e-3);
        assert_eq!(quadratic(0.0, 2.0, -1.0)[0], Some(0.5));
        assert_eq!(quadratic(1.0, 0.0, 1.0), [None, None]);
    }
}
