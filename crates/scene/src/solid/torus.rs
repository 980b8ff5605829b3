//! The entry of a ray into a torus: the first root of a quartic, found between stationary points.
//!
//! With the ring's radius R, the tube's radius r and `k = |p|² + R² - r²`, a point is inside where
//! `f = k² - 4 R² (p_x² + p_y²)` is not positive. On a ray whose parameter counts from the point
//! `o` nearest the centre, `o · d = 0` and so
//!
//! `f(t) = t⁴ + p t² + q t + s` with, for `k = |o|² + R² - r²`,
//! `p = 2 k - 4 R² (d_x² + d_y²)`, `q = -8 R² (o_x d_x + o_y d_y)`, `s = k² - 4 R² (o_x² + o_y²)`:
//!
//! a quartic without its cubic term, whose derivative is a cubic without its square term.
//!
//! 1. The stationary points of `f` follow from Cardano's and Viète's formulas.
//! 2. Between two of them `f` is monotone, so it has at most one root there.
//! 3. The first interval on which `f` falls to 0 is searched by Newton's method, kept inside the
//!    bracket by bisection.
//!
//! Closed formulas for quartics lose half of the digits near tangents. This loses none that `f`
//! itself has, and a point's distance from the surface stays near the rounding of its coordinates.

use super::ray::LocalRay;
use parry3d_f64::math::Vector;
use std::f64::consts::TAU;

/// A torus around the z axis, centred on the origin.
#[derive(Debug, Clone, Copy)]
pub struct Torus {
    /// Radius R of the circle that the tube runs along.
    pub radius: f64,
    /// Radius r of the tube, less than R.
    pub tube: f64,
}

/// More than bisection alone needs to get from any length to neighbouring numbers.
const MOST_STEPS: usize = 128;

impl Torus {
    /// Distance along the ray at which it enters; 0 if it starts inside.
    pub fn entry(&self, ray: &LocalRay) -> Option<f64> {
        let nearest = -ray.origin.dot(ray.dir);
        let origin = ray.point_at(nearest);
        // All of the torus is within a ball of radius R + r.
        let reach = ((self.radius + self.tube).powi(2) - origin.length_squared()).sqrt();
        let begin = (-reach).max(-nearest);
        // A line past the ball has a NaN as reach.
        if begin.is_nan() || reach.is_nan() || begin > reach {
            return None;
        }
        self.quartic(origin, ray.dir).first_fall(begin, reach).map(|t| (t + nearest).max(0.0))
    }

    fn quartic(&self, o: Vector, d: Vector) -> Quartic {
        let square = self.radius * self.radius;
        let k = o.length_squared() + square - self.tube * self.tube;
        Quartic {
            p: 2.0 * k - 4.0 * square * (d.x * d.x + d.y * d.y),
            q: -8.0 * square * (o.x * d.x + o.y * d.y),
            s: k * k - 4.0 * square * (o.x * o.x + o.y * o.y),
        }
    }

    /// Outward unit normal at a point of the surface.
    pub fn normal(&self, p: Vector) -> Vector {
        let lateral = Vector::new(p.x, p.y, 0.0);
        let on_circle = lateral.normalize_or(Vector::X) * self.radius;
        (p - on_circle).normalize_or(Vector::Z)
    }
}

/// `t⁴ + p t² + q t + s`.
struct Quartic {
    p: f64,
    q: f64,
    s: f64,
}

impl Quartic {
    fn at(&self, t: f64) -> f64 {
        ((t * t + self.p) * t + self.q) * t + self.s
    }

    fn slope(&self, t: f64) -> f64 {
        (4.0 * t * t + 2.0 * self.p) * t + self.q
    }

    /// The first place from `begin` to `end` at which the value is not positive.
    fn first_fall(&self, begin: f64, end: f64) -> Option<f64> {
        if self.at(begin) <= 0.0 {
            return Some(begin);
        }
        let between = self.stationary().into_iter().filter(|&t| begin < t && t < end);
        let mut left = begin;
        for right in between.chain([end]) {
            if self.at(right) <= 0.0 {
                return Some(self.root(left, right));
            }
            left = right;
        }
        None
    }

    /// The stationary points in rising order: roots of `t³ + (p/2) t + q/4`. Of a single one, the
    /// other two are NaN.
    fn stationary(&self) -> [f64; 3] {
        let (third, half) = (self.p / 6.0, self.q / 8.0);
        let discriminant = half * half + third.powi(3);
        if discriminant >= 0.0 {
            // Cardano, again with the cube root that subtracts nothing.
            let u = -(half.abs() + discriminant.sqrt()).cbrt().copysign(half);
            let t = if u == 0.0 { 0.0 } else { u - third / u };
            return [t, f64::NAN, f64::NAN];
        }
        // Viète; third is negative here.
        let size = (-third).sqrt();
        let angle = (-half / (size * size * size)).clamp(-1.0, 1.0).acos();
        let root = |k: f64| 2.0 * size * ((angle + k * TAU) / 3.0).cos();
        [root(1.0), root(2.0), root(0.0)]
    }

    /// Where the value falls through 0 in between a place above 0 and one that is not.
    fn root(&self, mut above: f64, mut below: f64) -> f64 {
        let mut t = 0.5 * (above + below);
        for _ in 0..MOST_STEPS {
            let value = self.at(t);
            if value > 0.0 {
                above = t
            } else {
                below = t
            }
            let newton = t - value / self.slope(t);
            let inside = above.min(below) < newton && newton < above.max(below);
            let next = if inside { newton } else { 0.5 * (above + below) };
            if next == t {
                break;
            }
            t = next;
        }
        t
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parry3d_f64::query::Ray;

    const RING: Torus = Torus { radius: 2.0, tube: 0.5 };

    fn entry(origin: [f64; 3], dir: [f64; 3]) -> Option<f64> {
        RING.entry(&Ray::new(Vector::from_array(origin), Vector::from_array(dir).normalize()))
    }

    fn near(found: Option<f64>, expected: f64) {
        assert!(found.is_some_and(|t| (t - expected).abs() < 1e-13), "{found:?} {expected}");
    }

    #[test]
    fn a_torus_is_met_outside_inside_and_above() {
        near(entry([5.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), 2.5);
        near(entry([0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), 1.5);
        near(entry([2.0, 0.0, 5.0], [0.0, 0.0, -1.0]), 4.5);
        near(entry([2.3, 0.0, 5.0], [0.0, 0.0, -1.0]), 4.6);
        assert_eq!(entry([0.0, 1.9, 0.1], [0.3, 0.2, 0.1]), Some(0.0), "starts inside");
    }

    #[test]
    fn rays_through_the_hole_or_past_the_ring_miss_it() {
        assert_eq!(entry([0.3, 0.2, 5.0], [0.0, 0.0, -1.0]), None);
        assert_eq!(entry([1.0, -0.8, 5.0], [0.0, 0.0, -1.0]), None);
        assert_eq!(entry([5.0, 0.0, 0.51], [-1.0, 0.0, 0.0]), None);
        assert_eq!(entry([5.0, 0.0, 0.0], [1.0, 0.0, 0.0]), None, "behind the start");
        assert_eq!(entry([-9.0, 2.6, 0.0], [1.0, 0.0, 0.0]), None);
    }

    #[test]
    fn tangents_are_found_to_their_own_precision() {
        // Passes under the outermost circle by ever less; met on the flank at height sqrt(...).
        for k in 1..14 {
            let below = 10f64.powi(-k);
            let origin = [2.5 - below, 9.0, 0.0];
            let t = entry(origin, [0.0, -1.0, 0.0]).unwrap();
            let p = Vector::new(origin[0], 9.0 - t, 0.0);
            assert!((p.length() - 2.5).abs() < 1e-14, "{k}: {}", p.length());
        }
    }

    #[test]
    fn a_far_sensor_loses_nothing() {
        near(entry([0.0, 0.0, 0.0], [0.0, 1.0, 0.0]), 1.5);
        let t = entry([1e5, 0.0, 0.0], [-1.0, 0.0, 0.0]).unwrap();
        assert!((t - (1e5 - 2.5)).abs() < 1e-10);
    }
}
