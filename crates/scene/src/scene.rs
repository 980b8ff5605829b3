//! The union of solids: the first hit of a ray, and the surface as a mesh and as sections.

use crate::parry::{self, Motion};
use crate::solid::{LocalRay, Solid, smallest_chord_error};
use crate::{MergeError, Mesh, MeshError, merge_overlaps, sections};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use std::collections::BTreeMap;
use transect_device::Ray;
use transect_geometry::{Curve, PlaneFamily, PlaneIndex, Point3, Vector3};

/// Why a scene's surface cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The chord error is not a length, or too small for the largest round solid.
    #[error(
        "a chord error of {chord_error:e} is not possible; it must be positive and at least {smallest:e}"
    )]
    BadChordError {
        /// The requested chord error.
        chord_error: f64,
        /// The smallest possible one, in the model's length unit.
        smallest: f64,
    },
    /// The surface does not fit the planes.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Sections of the solids could not be united.
    #[error(transparent)]
    Merge(#[from] MergeError),
}

/// The first hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Hit {
    /// The solid, by its place in the list given to [`Scene::new`].
    pub solid: usize,
    /// Distance along the ray, in the model's length unit; 0 if the ray starts inside the solid.
    pub distance: f64,
    /// The hit, in the world.
    pub point_in_world: Point3,
    /// Outward unit normal of the surface there, in the world.
    pub normal_in_world: Vector3,
}

/// A union of solids, ready for rays.
///
/// ```
/// use transect_device::{Ray, Vector3};
/// use transect_geometry::{Isometry3, PlaneFamily, PlaneIndex, Point3, StraightGuide};
/// use transect_scene::{Scene, Shape, Solid};
///
/// let ball = Solid::new(Shape::ball(2.0)?, Isometry3::translation(0.0, 0.0, 5.0))?;
/// let scene = Scene::new(vec![ball]);
/// let ray = Ray { start: Point3::origin(), direction: Vector3::z() };
/// let hit = scene.hit(&ray).ok_or("no hit")?;
/// assert_eq!((hit.solid, hit.distance), (0, 3.0));
///
/// let planes = PlaneFamily::new(StraightGuide::along(Vector3::z())?, 5.0, 1.5)?;
/// let sections = scene.sections(&planes, 1e-3)?;
/// assert_eq!(sections.len(), 3, "below, through and above the centre");
/// assert!(sections[&PlaneIndex(0)][0].is_closed());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Scene {
    solids: Vec<Solid>,
    /// For each solid, the motion from the world to its frame.
    solid_from_world: Vec<Motion>,
    /// Over the solids' boxes in the world; a leaf is an index into `solids`.
    hierarchy: Bvh,
}

/// A ray in the world, with the reciprocals that box tests need.
pub(crate) struct WorldRay {
    origin: Vector,
    direction: Vector,
    inverse: Vector,
}

impl WorldRay {
    /// A ray; distances along it count lengths of its direction.
    pub(crate) fn new(origin: Vector, direction: Vector) -> Self {
        // A component of zero becomes tiny, so that 0 · ∞ never makes a NaN.
        let inverse = |c: f64| 1.0 / if c.abs() < 1e-300 { 1e-300 } else { c };
        let inverse = Vector::new(inverse(direction.x), inverse(direction.y), inverse(direction.z));
        Self { origin, direction, inverse }
    }

    /// Distance at which the ray enters a box; infinite if it misses it.
    pub(crate) fn box_entry(&self, mins: Vector, maxs: Vector) -> f64 {
        let a = (mins - self.origin) * self.inverse;
        let b = (maxs - self.origin) * self.inverse;
        let enters = a.min(b).max_element().max(0.0);
        if enters <= a.max(b).min_element() { enters } else { f64::MAX }
    }

    fn in_solid(&self, solid_from_world: &Motion) -> LocalRay {
        let origin = solid_from_world.point(self.origin);
        LocalRay::new(origin, solid_from_world.rotation * self.direction)
    }
}

impl Scene {
    /// The union of some solids, which may touch and overlap.
    pub fn new(solids: Vec<Solid>) -> Self {
        let boxes: Vec<_> = solids.iter().map(world_bounds).collect();
        let solid_from_world =
            solids.iter().map(|s| Motion::new(&s.world_from_solid().inverse())).collect();
        let hierarchy = Bvh::from_leaves(BvhBuildStrategy::Ploc, &boxes);
        Self { solids, solid_from_world, hierarchy }
    }

    /// The solids, in the order given.
    pub fn solids(&self) -> &[Solid] {
        &self.solids
    }

    /// The first hit of a ray in the world; `None` if it meets no solid.
    ///
    /// Where two solids touch, either may be named.
    pub fn hit(&self, ray_in_world: &Ray) -> Option<Hit> {
        let (start, direction) = (ray_in_world.start, ray_in_world.direction);
        let ray = WorldRay::new(parry::point(&start), parry::vector(&direction));
        let (solid, distance) = self.nearest(&ray)?;
        Some(Hit {
            solid,
            distance,
            point_in_world: start + direction * distance,
            normal_in_world: parry::from_vector(self.normal(&ray, solid, distance)?),
        })
    }

    /// Whether a point is inside a solid or on its surface.
    pub fn contains(&self, in_world: &Point3) -> bool {
        let upwards = Ray { start: *in_world, direction: Vector3::z() };
        self.hit(&upwards).is_some_and(|hit| hit.distance <= 0.0)
    }

    /// The solid that a ray meets first, and at which distance.
    pub(crate) fn nearest(&self, ray: &WorldRay) -> Option<(usize, f64)> {
        let best = self.hierarchy.find_best(
            f64::MAX,
            |node, _| ray.box_entry(node.mins(), node.maxs()),
            |leaf, _| self.entry(ray, leaf as usize),
        );
        best.map(|(leaf, distance)| (leaf as usize, distance))
    }

    /// Whether a ray meets a solid within a distance.
    pub(crate) fn blocks(&self, ray: &WorldRay, way: f64) -> bool {
        let met = self.hierarchy.find_best(
            way,
            |node, _| ray.box_entry(node.mins(), node.maxs()),
            |leaf, _| self.entry(ray, leaf as usize),
        );
        met.is_some()
    }

    fn entry(&self, ray: &WorldRay, solid: usize) -> Option<f64> {
        let local = ray.in_solid(self.solid_from_world.get(solid)?);
        self.solids.get(solid)?.shape().entry(&local)
    }

    /// Outward normal, in the world, where a ray enters a solid.
    pub(crate) fn normal(&self, ray: &WorldRay, solid: usize, distance: f64) -> Option<Vector> {
        let motion = self.solid_from_world.get(solid)?;
        let local = ray.in_solid(motion);
        let normal = self.solids.get(solid)?.shape().normal(&local, distance);
        Some(motion.rotation.transpose() * normal)
    }

    /// The solids' surfaces as one mesh in the world, wound outwards.
    ///
    /// Round solids are polyhedra with their vertices on the true surface and their faces at most
    /// `chord_error` from it. The faces lie inside of it, except around the hole of a torus.
    /// Flat-faced solids and meshes are exact. Solids that overlap keep the parts of their surfaces
    /// that lie inside each other: the mesh bounds the union, but is not its boundary.
    ///
    /// # Errors
    /// [`SceneError::BadChordError`] unless the chord error is positive, finite and not absurdly
    /// small for the largest round solid (about 6e-7 of its radius).
    pub fn mesh(&self, chord_error: f64) -> Result<Mesh, SceneError> {
        let radii = self.solids.iter().filter_map(|s| s.shape().radius());
        let smallest = radii.map(smallest_chord_error).fold(0.0, f64::max);
        if !(chord_error.is_finite() && chord_error > 0.0 && chord_error >= smallest) {
            return Err(SceneError::BadChordError { chord_error, smallest });
        }
        let mut mesh = Mesh::default();
        for solid in &self.solids {
            mesh.append(&solid.shape().mesh_of(chord_error), solid.world_from_solid());
        }
        Ok(mesh)
    }

    /// The exact sections of the union: rings with the solid on the left, in plane coordinates.
    ///
    /// Exact up to rounding for boxes and meshes. The curves of round solids come from
    /// [`Scene::mesh`], so they lie on a surface within `chord_error` of the true one. Where a
    /// plane nearly touches a ball, their distance in the plane is larger by one over the sine of
    /// the angle between plane and surface.
    ///
    /// # Errors
    /// [`SceneError`] for a bad chord error, planes without number, or solids of absurd sizes.
    pub fn sections(
        &self,
        planes: &PlaneFamily,
        chord_error: f64,
    ) -> Result<BTreeMap<PlaneIndex, Vec<Curve>>, SceneError> {
        let cut = sections(&self.mesh(chord_error)?, planes)?;
        cut.into_iter().map(|(plane, curves)| Ok((plane, merge_overlaps(curves)?))).collect()
    }
}

/// A box around a solid in the world, slightly enlarged: the rounding of a ray into the solid's
/// frame must not decide whether the solid is tested.
fn world_bounds(solid: &Solid) -> Aabb {
    const LOOSE: f64 = 1e-9;
    let world_from_solid = Motion::new(solid.world_from_solid());
    let local = solid.shape().bounds();
    let center = world_from_solid.point(local.center());
    let half = world_from_solid.rotation.abs() * local.half_extents();
    let loose = Vector::splat(LOOSE * (half.max_element() + center.abs().max_element()));
    Aabb::new(center - half - loose, center + half + loose)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Shape;
    use proptest::prelude::*;
    use transect_geometry::Isometry3;

    fn at(shape: Shape, x: f64, y: f64, z: f64) -> Solid {
        Solid::new(shape, Isometry3::translation(x, y, z)).unwrap()
    }

    fn ray(start: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { start: Point3::from(start), direction: Vector3::from(direction).normalize() }
    }

    #[test]
    fn a_ball_is_met_at_its_exact_range() {
        let scene = Scene::new(vec![at(Shape::ball(1.5).unwrap(), 10.0, 0.0, 0.0)]);
        for k in 0..100 {
            // Rays passing the centre at distance 1.5 sin(a), so met at 10 cos(b) - 1.5 cos(a).
            let passes: f64 = 0.0149 * f64::from(k);
            let sin = passes / 10.0;
            let hit = scene.hit(&ray([0.0; 3], [(1.0 - sin * sin).sqrt(), 0.0, sin])).unwrap();
            let expected = (100.0 - passes * passes).sqrt() - (2.25 - passes * passes).sqrt();
            assert!((hit.distance - expected).abs() < 1e-9, "{k}");
            let outward = (hit.point_in_world - Point3::new(10.0, 0.0, 0.0)).normalize();
            assert!((hit.normal_in_world - outward).norm() < 1e-9);
        }
        assert!(scene.hit(&ray([0.0; 3], [1.0, 0.0, 0.2])).is_none());
    }

    #[test]
    fn the_nearest_solid_wins_whatever_the_order() {
        let solids = [
            at(Shape::ball(1.0).unwrap(), 9.0, 0.0, 0.0),
            at(Shape::cuboid(Vector3::repeat(1.0)).unwrap(), 5.0, 0.0, 0.0),
            at(Shape::cylinder(0.5, 1.0).unwrap(), 7.0, 0.0, 0.0),
        ];
        for order in [[0, 1, 2], [1, 2, 0], [2, 1, 0]] {
            let scene = Scene::new(order.map(|k| solids[k].clone()).to_vec());
            let hit = scene.hit(&ray([0.0; 3], [1.0, 0.0, 0.0])).unwrap();
            assert_eq!(order[hit.solid], 1);
            assert_eq!(hit.distance, 4.5);
            assert_eq!(hit.normal_in_world, -Vector3::x());
        }
    }

    #[test]
    fn an_empty_scene_and_one_solid_work_too() {
        let forward = ray([0.0; 3], [1.0, 0.0, 0.0]);
        assert!(Scene::new(Vec::new()).hit(&forward).is_none());
        let one = Scene::new(vec![at(Shape::ball(1.0).unwrap(), 3.0, 0.0, 0.0)]);
        assert_eq!(one.hit(&forward).map(|h| h.distance), Some(2.0));
        assert!(one.contains(&Point3::new(2.5, 0.0, 0.0)));
        assert!(!one.contains(&Point3::new(1.5, 0.0, 0.0)));
    }

    #[test]
    fn world_sized_coordinates_keep_a_micrometre() {
        let (x, y) = (5.0e5, 5.4e6);
        let scene = Scene::new(vec![at(Shape::ball(1.0).unwrap(), x + 7.0, y, 0.0)]);
        let hit = scene.hit(&ray([x, y, 0.0], [1.0, 0.0, 0.0])).unwrap();
        assert!((hit.distance - 6.0).abs() < 1e-8);
    }

    #[test]
    fn the_chord_error_is_checked() {
        let scene = Scene::new(vec![at(Shape::ball(1.0).unwrap(), 0.0, 0.0, 0.0)]);
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9] {
            assert!(scene.mesh(bad).is_err(), "{bad}");
        }
    }

    /// Distance of a point from the nearest of a box, a cylinder and a ball, each about its pose.
    fn distance_from_surfaces(poses: &[Isometry3], p: &Point3) -> f64 {
        let inside = |local: Vec<f64>| {
            // Outside: hypotenuse of what sticks out; inside: the depth.
            let out = local.iter().map(|d| d.max(0.0).powi(2)).sum::<f64>().sqrt();
            let deepest = local.iter().copied().fold(f64::MIN, f64::max);
            if deepest > 0.0 { out } else { -deepest }
        };
        let of = |k: usize| poses[k].inverse_transform_point(p);
        let (b, c, s) = (of(0), of(1), of(2));
        let block = inside(vec![b.x.abs() - 0.5, b.y.abs() - 1.0, b.z.abs() - 1.5]);
        let can = inside(vec![c.x.hypot(c.y) - 0.7, c.z.abs() - 1.1]);
        block.min(can).min((s.coords.norm() - 1.2).abs())
    }

    fn poses() -> impl Strategy<Value = Isometry3> {
        prop::array::uniform6(-2.0..2.0).prop_map(|[x, y, z, a, b, c]: [f64; 6]| {
            Isometry3::new(Vector3::new(x, y, z), Vector3::new(a, b, c))
        })
    }

    proptest! {
        #[test]
        fn hits_lie_on_a_surface_and_nothing_is_in_front_of_them(
            poses in prop::array::uniform3(poses()),
            azimuth in -3.0..3.0f64, height in -6.0..6.0f64, aim in prop::array::uniform3(-2.0..2.0),
        ) {
            let shapes = [
                Shape::cuboid(Vector3::new(1.0, 2.0, 3.0)).unwrap(),
                Shape::cylinder(0.7, 2.2).unwrap(),
                Shape::ball(1.2).unwrap(),
            ];
            let solids = shapes.into_iter().zip(poses).map(|(s, p)| Solid::new(s, p).unwrap());
            let scene = Scene::new(solids.collect());
            let start = Point3::new(9.0 * azimuth.cos(), 9.0 * azimuth.sin(), height);
            let direction = (Point3::from(aim) - start).normalize();
            let ray = Ray { start, direction };
            let hit = scene.hit(&ray);
            // Sphere tracing with the distance is an independent way to find the first surface.
            let mut marched = 0.0;
            for _ in 0..5000 {
                let step = distance_from_surfaces(&poses, &(start + direction * marched));
                if step < 1e-9 || marched > 30.0 {
                    break;
                }
                marched += step;
            }
            match hit {
                Some(hit) => {
                    prop_assert!(distance_from_surfaces(&poses, &hit.point_in_world) < 1e-9);
                    prop_assert!(hit.normal_in_world.dot(&direction) <= 1e-9);
                    prop_assert!(hit.distance - marched < 1e-4, "{} {}", hit.distance, marched);
                }
                None => prop_assert!(marched > 15.0),
            }
        }
    }
}
