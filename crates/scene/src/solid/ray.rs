//! The entry of a ray into a shape, and the surface normal there, in the shape's own frame.
//!
//! Convex shapes are intersections of slabs, so a ray is inside them from the last slab entry to
//! the first slab exit. Balls and meshes are parry's; its cylinders and cones are found by GJK
//! iterations, good to about 1e-6 of their size. They are solved here in closed form, as is the
//! torus, which parry does not have.
//!
//! A ray that starts in a solid enters it at distance 0, a value which no sensor returns. A ray
//! along an edge of a mesh may, by rounding, slip in between its two faces. It then counts as one
//! that starts inside, so that a pixel goes missing rather than wrong.

use super::{Kind, Shape};
use parry3d_f64::math::Vector;
use parry3d_f64::query::details::ray_toi_with_ball;
use parry3d_f64::query::{Ray, RayCast, RayIntersection};
use parry3d_f64::shape::TriMesh;

/// A ray in a shape's frame, of unit direction.
pub(crate) type LocalRay = Ray;

impl Shape {
    /// Distance along the ray at which it enters the solid; 0 if it starts inside.
    pub(crate) fn entry(&self, ray: &LocalRay) -> Option<f64> {
        match &self.0 {
            Kind::Box { half } => box_entry(*half, ray),
            Kind::Frustum(frustum) => frustum.entry(ray),
            Kind::Ball { radius } => ray_toi_with_ball(Vector::ZERO, *radius, ray, true).1,
            Kind::Torus(torus) => torus.entry(ray),
            Kind::Mesh(surface) => {
                let hit = mesh_hit(surface, ray)?;
                // A back face as the first hit means that the ray started behind it.
                Some(if leaves(surface, &hit, ray) { 0.0 } else { hit.time_of_impact })
            }
        }
    }

    /// Outward unit normal where the ray enters at the given distance.
    pub(crate) fn normal(&self, ray: &LocalRay, distance: f64) -> Vector {
        let p = ray.point_at(distance);
        match &self.0 {
            Kind::Box { half } => {
                // The face whose plane the point is nearest to.
                let depth = *half - p.abs();
                let axis = if depth.x <= depth.y && depth.x <= depth.z {
                    Vector::X
                } else if depth.y <= depth.z {
                    Vector::Y
                } else {
                    Vector::Z
                };
                axis * axis.dot(p).signum()
            }
            Kind::Frustum(frustum) => frustum.normal(p),
            Kind::Ball { .. } => p.normalize_or(Vector::Z),
            Kind::Torus(torus) => torus.normal(p),
            Kind::Mesh(surface) => mesh_hit(surface, ray).map_or(Vector::Z, |hit| hit.normal),
        }
    }
}

fn mesh_hit(surface: &TriMesh, ray: &LocalRay) -> Option<RayIntersection> {
    surface.cast_local_ray_and_get_normal(ray, f64::MAX, false)
}

/// Whether the ray crosses the hit face from inside to outside.
fn leaves(surface: &TriMesh, hit: &RayIntersection, ray: &LocalRay) -> bool {
    surface.triangle(hit.subshape).scaled_normal().dot(ray.dir) > 0.0
}

fn box_entry(half: Vector, ray: &LocalRay) -> Option<f64> {
    let mut inside = (0.0, f64::MAX);
    for axis in 0..3 {
        let slab = slab(ray.origin[axis], ray.dir[axis], half[axis])?;
        inside = (slab.0.max(inside.0), slab.1.min(inside.1));
    }
    (inside.0 <= inside.1).then_some(inside.0)
}

/// Distances between which a coordinate running from `start` lies within ± `half`; `None` if it
/// stands still outside.
pub(super) fn slab(start: f64, slope: f64, half: f64) -> Option<(f64, f64)> {
    if slope == 0.0 {
        return (start.abs() <= half).then_some((f64::MIN, f64::MAX));
    }
    let (a, b) = ((-half - start) / slope, (half - start) / slope);
    Some((a.min(b), a.max(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mesh;
    use transect_geometry::{Isometry3, Vector3};

    fn ray(origin: [f64; 3], dir: [f64; 3]) -> LocalRay {
        Ray::new(Vector::from_array(origin), Vector::from_array(dir).normalize())
    }

    #[test]
    fn a_cylinder_is_met_on_its_mantle_and_on_its_ends() {
        let can = Shape::cylinder(0.5, 2.0).unwrap();
        let side = ray([3.0, 0.0, 0.9], [-1.0, 0.0, 0.0]);
        assert_eq!(can.entry(&side), Some(2.5));
        assert_eq!(can.normal(&side, 2.5), Vector::X);
        let top = ray([0.3, 0.0, 5.0], [0.0, 0.0, -1.0]);
        assert_eq!(can.entry(&top), Some(4.0));
        assert_eq!(can.normal(&top, 4.0), Vector::Z);
        assert_eq!(can.entry(&ray([0.6, 0.0, 5.0], [0.0, 0.0, -1.0])), None);
        assert_eq!(can.entry(&ray([3.0, 0.0, 1.1], [-1.0, 0.0, 0.0])), None);
        assert_eq!(can.entry(&ray([3.0, 0.6, 0.0], [-1.0, 0.0, 0.0])), None);
        assert_eq!(can.entry(&ray([3.0, 0.0, 0.0], [1.0, 0.0, 0.0])), None, "behind the start");
    }

    #[test]
    fn a_ray_from_inside_enters_at_once() {
        let center = ray([0.1, 0.0, 0.0], [0.3, 0.2, 0.9]);
        let block = Shape::cuboid(Vector3::new(1.0, 1.0, 1.0)).unwrap();
        let mut surface = Mesh::default();
        surface.append(&block.mesh_of(1.0), &Isometry3::identity());
        for shape in [
            Shape::mesh(&surface).unwrap(),
            block,
            Shape::cylinder(0.5, 2.0).unwrap(),
            Shape::ball(0.5).unwrap(),
        ] {
            assert_eq!(shape.entry(&center), Some(0.0), "{shape:?}");
        }
    }

    #[test]
    fn a_mesh_of_a_box_is_met_like_the_box() {
        let block = Shape::cuboid(Vector3::new(1.0, 2.0, 3.0)).unwrap();
        let mesh = Shape::mesh(&block.mesh_of(1.0)).unwrap();
        for k in 0..200 {
            let angle = f64::from(k) * 0.1;
            let origin = [4.0 * angle.cos(), 4.0 * angle.sin(), 0.03 * f64::from(k) - 3.0];
            let aim = [0.1 - origin[0], 0.2 - origin[1], -0.7 * origin[2]];
            let r = ray(origin, aim);
            let (a, b) = (block.entry(&r), mesh.entry(&r));
            assert_eq!(a.is_some(), b.is_some(), "{r:?}");
            if let (Some(a), Some(b)) = (a, b) {
                assert!((a - b).abs() < 1e-12);
                assert!((block.normal(&r, a) - mesh.normal(&r, b)).length() < 1e-12);
            }
        }
    }

    #[test]
    fn rays_onto_edges_of_a_mesh_do_not_slip_in_between() {
        use transect_geometry::Point2;
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(Point2::from);
        let block = Shape::prism(&corners, &corners, 2.0).unwrap();
        let tent = Shape::pyramid(Vector3::new(2.0, 2.0, 2.0)).unwrap();
        let mut slipped = 0;
        for k in 1..1000 {
            // Along both diagonals of the roof and over the edges of the pyramid.
            let x = f64::from(k) * 0.002 - 1.0;
            for y in [x, -x] {
                let down = ray([x, y, 5.0], [0.0, 0.0, -1.0]);
                slipped += i32::from(block.entry(&down) != Some(4.0));
                let tip = 4.0 + 2.0 * x.abs();
                slipped += i32::from(tent.entry(&down).is_none_or(|t| (t - tip).abs() > 1e-9));
                let slanted = ray(
                    [3.0 * x + 0.3, 3.0 * y - 0.7, 5.0],
                    [-2.0 * x - 0.3, -2.0 * y + 0.7, -4.0],
                );
                slipped += i32::from(block.entry(&slanted).is_none_or(|t| t < 1.0));
            }
        }
        assert_eq!(slipped, 0);
    }
}
