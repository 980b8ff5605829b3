//! The entry of a ray into a cylinder or a cone, whole or truncated, in closed form.
//!
//! The mantle is the surface `|p_xy| = m + s z` with the mean radius `m` and the slope `s`. Along a
//! ray `p = o + t d` this is `a t² + 2 b t + c = 0` with
//!
//! * `a = d_x² + d_y² - s² d_z²`,
//! * `b = o_x d_x + o_y d_y - s d_z (m + s o_z)`,
//! * `c = o_x² + o_y² - (m + s o_z)²`,
//!
//! and the ray is within the mantle, or within its mirror image beyond the tip, where the left side
//! is not positive. Between the two ends the radius is not negative, so the mirror image plays no
//! part there. The solid is convex: of the at most two intervals within the double cone, only one
//! lies between the ends.
//!
//! The start is first moved along the ray to the point nearest the centre. All terms are then of
//! the solid's size, and the roots lose nothing to a far sensor.

use super::ray::{LocalRay, slab};
use parry3d_f64::math::Vector;

/// A truncated cone around the z axis, centred on the origin; a cone if one radius is 0, a cylinder
/// if both are equal.
#[derive(Debug, Clone, Copy)]
pub struct Frustum {
    /// Radius at `z = -half_height`.
    pub bottom: f64,
    /// Radius at `z = half_height`.
    pub top: f64,
    /// Half of the distance between the ends.
    pub half_height: f64,
}

/// Distances along a ray between which a condition holds.
type Interval = (f64, f64);
const EVERYWHERE: Interval = (f64::MIN, f64::MAX);

impl Frustum {
    fn mean_radius(&self) -> f64 {
        0.5 * (self.bottom + self.top)
    }

    /// Change of the radius per height.
    fn slope(&self) -> f64 {
        (self.top - self.bottom) / (2.0 * self.half_height)
    }

    /// Distance along the ray at which it enters; 0 if it starts inside.
    pub fn entry(&self, ray: &LocalRay) -> Option<f64> {
        let nearest = -ray.origin.dot(ray.dir);
        let origin = ray.point_at(nearest);
        let (low, high) = slab(origin.z, ray.dir.z, self.half_height)?;
        let ends = (low.max(-nearest), high);
        let within = self.within_mantle(origin, ray.dir).into_iter().flatten();
        let enters = within.filter_map(|mantle| {
            let enters = mantle.0.max(ends.0);
            (enters <= mantle.1.min(ends.1)).then_some(enters)
        });
        enters.reduce(f64::min).map(|t| (t + nearest).max(0.0))
    }

    /// Where a line is within the double cone: at most two intervals.
    fn within_mantle(&self, o: Vector, d: Vector) -> [Option<Interval>; 2] {
        let slope = self.slope();
        let radius = self.mean_radius() + slope * o.z;
        let a = d.x * d.x + d.y * d.y - (slope * d.z).powi(2);
        let b = o.x * d.x + o.y * d.y - slope * d.z * radius;
        let c = o.x * o.x + o.y * o.y - radius * radius;
        let discriminant = b * b - a * c;
        if discriminant < 0.0 {
            // No crossing: nowhere within, or through the tip and within on both sides.
            return [(a < 0.0).then_some(EVERYWHERE), None];
        }
        // The root that subtracts nothing; the other one follows from their product c / a.
        let q = -(b + discriminant.sqrt().copysign(b));
        if q == 0.0 {
            // a t² + c <= 0, where a or c is 0.
            let within = if a > 0.0 { (0.0, 0.0) } else { EVERYWHERE };
            return [(a != 0.0 || c <= 0.0).then_some(within), None];
        }
        let (one, other) = (q / a, c / q);
        let (first, second) = (one.min(other), one.max(other));
        if a > 0.0 {
            [Some((first, second)), None]
        } else if a < 0.0 {
            [Some((f64::MIN, first)), Some((second, f64::MAX))]
        } else if b > 0.0 {
            // Parallel to the mantle: 2 b t + c <= 0.
            [Some((f64::MIN, other)), None]
        } else {
            [Some((other, f64::MAX)), None]
        }
    }

    /// Outward unit normal at a point of the surface.
    pub fn normal(&self, p: Vector) -> Vector {
        let slope = self.slope();
        let lateral = Vector::new(p.x, p.y, 0.0);
        let across = (1.0 + slope * slope).sqrt();
        let below_mantle = (self.mean_radius() + slope * p.z - lateral.length()) / across;
        if self.half_height - p.z.abs() < below_mantle {
            return Vector::Z * p.z.signum();
        }
        let outwards = lateral.try_normalize();
        // At the tip the axis is as good a normal as any other.
        outwards.map_or(-Vector::Z * slope.signum(), |u| (u - Vector::Z * slope) / across)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parry3d_f64::query::Ray;

    const CONE: Frustum = Frustum { bottom: 1.0, top: 0.0, half_height: 1.0 };

    fn ray(origin: [f64; 3], dir: [f64; 3]) -> LocalRay {
        Ray::new(Vector::from_array(origin), Vector::from_array(dir).normalize())
    }

    fn near(found: Option<f64>, expected: f64) {
        assert!(found.is_some_and(|t| (t - expected).abs() < 1e-14), "{found:?} {expected}");
    }

    #[test]
    fn a_cone_is_met_on_its_mantle_its_base_and_its_tip() {
        near(CONE.entry(&ray([3.0, 0.0, 0.0], [-1.0, 0.0, 0.0])), 2.5);
        near(CONE.entry(&ray([0.5, 0.0, -3.0], [0.0, 0.0, 1.0])), 2.0);
        near(CONE.entry(&ray([0.0, 0.0, 3.0], [0.0, 0.0, -1.0])), 2.0);
        near(CONE.entry(&ray([0.25, 0.0, 3.0], [0.0, 0.0, -1.0])), 2.5);
        assert_eq!(CONE.entry(&ray([0.0, 0.0, 0.0], [0.3, 0.1, 0.2])), Some(0.0));
        // Through the mirror image beyond the tip only.
        assert_eq!(CONE.entry(&ray([3.0, 0.0, 1.5], [-1.0, 0.0, 0.0])), None);
        assert_eq!(CONE.entry(&ray([3.0, 0.0, 0.0], [1.0, 0.0, 0.0])), None, "behind the start");
    }

    #[test]
    fn a_ray_along_the_slope_is_met_too() {
        // Parallel to the mantle line through (-1, 0, -1) and the tip, and 0.1 inside of it.
        let along = ray([-3.0 + 0.1, 0.0, -5.0], [1.0, 0.0, 2.0]);
        let t = CONE.entry(&along).unwrap();
        assert!((along.point_at(t).z + 1.0).abs() < 1e-12);
        assert_eq!(CONE.entry(&ray([-3.0 - 0.1, 0.0, -5.0], [1.0, 0.0, 2.0])), None);
    }

    #[test]
    fn a_far_sensor_loses_nothing() {
        let far = 1e5;
        let hit = ray([far, 0.25, 0.0], [-1.0, 0.0, 0.0]);
        let expected = far - 0.1875f64.sqrt();
        assert!((CONE.entry(&hit).unwrap() - expected).abs() < 1e-10);
    }

    #[test]
    fn normals_stand_on_the_surface() {
        let across = 1.25f64.sqrt();
        let mantle = CONE.normal(Vector::new(0.5, 0.0, 0.0));
        assert!((mantle - Vector::new(1.0, 0.0, 0.5) / across).length() < 1e-15);
        assert_eq!(CONE.normal(Vector::new(0.2, 0.1, -1.0)), -Vector::Z);
        let funnel = Frustum { bottom: 0.5, top: 1.5, half_height: 1.0 };
        assert!(funnel.normal(Vector::new(0.0, 1.0, 0.0)).z < 0.0);
        assert_eq!(funnel.normal(Vector::new(0.2, 0.1, 1.0)), Vector::Z);
    }
}
