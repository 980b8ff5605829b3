//! A cubic through four samples and the plane (3.6 with n = 4).
//!
//! The scanned curve `c(t) = s(c₁, …, c₄)` is the cubic through the samples at t = −1, 0, 1, 2. Its
//! height over the plane is the cubic through their heights, whose root between 0 and 1 is wanted.
//! The remainder of the interpolation is `t (t² − 1)(t − 2) c⁗ / 24`: at most 3/128 of the fourth
//! difference of the samples.

use super::{PairMeeting, height, root};
use transect_device::{Point3, SensorPlane, Vector3};

/// Where the cubic through four samples meets the plane between the second and the third.
pub(super) fn meet(points: &[Point3; 4], plane: &SensorPlane) -> Option<PairMeeting> {
    let heights = points.each_ref().map(|p| height(plane, p));
    let at = |t: f64| weights(t).iter().zip(&heights).map(|(w, h)| w * h).sum();
    let parameter = root::between_0_and_1(|t| Some(at(t)))?;
    let weighted = weights(parameter).into_iter().zip(points).map(|(w, p)| p.coords * w);
    Some(PairMeeting { parameter, point: Point3::from(weighted.sum::<Vector3>()) })
}

/// Lagrange's weights of samples at −1, 0, 1, 2.
fn weights(t: f64) -> [f64; 4] {
    let (a, b, c, d) = (t + 1.0, t, t - 1.0, t - 2.0);
    [-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_followed_exactly() {
        let cubic = |t: f64| Point3::new(t, 1.0 - t * t, 2.0 * t * t * t - 0.3 * t - 0.4);
        let plane = SensorPlane { normal: Vector3::z(), offset: 0.0 };
        let meeting = meet(&[-1.0, 0.0, 1.0, 2.0].map(cubic), &plane).unwrap();
        assert!((meeting.point - cubic(meeting.parameter)).norm() < 1e-14);
        assert!(meeting.point.z.abs() < 1e-14);
    }
}
