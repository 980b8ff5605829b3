//! The part of a surface that a set of views can see. A model can only be compared with this part.
//!
//! Points come in the order of a curve. Mostly, the view that saw the last point sees the next one
//! too. The triangle that hid the last point from a view mostly hides the next one. So both are
//! tried first.

use crate::scene::WorldRay;
use crate::{Mesh, MeshError, parry};
use parry3d_f64::math::Vector;
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::{TriMesh, TriMeshFlags, Triangle};
use transect_device::{Pixel, View};
use transect_geometry::Point3;

/// Largest angle of incidence, in degrees, at which a surface counts as seen. Chosen by hand: at
/// this angle samples lie six times as far apart as head-on. It cannot be doubled; at 90 every
/// surface counts as seen, however oblique.
const MAX_INCIDENCE_DEG: f64 = 80.0;

/// Tolerance of a free path at its end, relative to the surface's largest side. Chosen by hand:
/// far above rounding of the points (2⁻³¹ after [`merge_overlaps`](crate::merge_overlaps), six
/// times as much along an oblique path) and below any thickness: 20 µm in a scene of 20 m. Doubled,
/// the hidden sides of sheets up to twice as thick count as seen.
const REACHED: f64 = 1e-6;

/// Finds the points of a surface that some view sees.
///
/// A point is seen if it projects into a view's image and the nearest pixel is not missing. The
/// paths to the start of that pixel's ray, and to its second viewpoint, if any, must be free. A
/// view whose device frame has no inverse mapping sees no point, because its rays between the
/// pixels are unknown.
#[derive(Debug)]
pub struct Visibility {
    surface: TriMesh,
    /// How far from a point a path may end that reaches it.
    reached: f64,
    eyes: Vec<Eye>,
    least_cosine: f64,
}

/// A view with the place in the world from which all of its rays start, if there is one.
#[derive(Debug)]
struct Eye {
    view: View,
    centre: Option<Point3>,
}

impl Eye {
    fn new(view: View) -> Self {
        let size = view.image().size();
        let (last_row, last_col) = (size.rows.saturating_sub(1), size.cols.saturating_sub(1));
        let corners = [(0, 0), (0, last_col), (last_row, 0), (last_row, last_col)];
        let mut starts = corners.map(|(row, col)| view.frame().ray(Pixel::new(row, col)));
        let centre = starts[0].take().map(|ray| ray.start);
        let is_common = starts[1..].iter().all(|ray| ray.map(|ray| ray.start) == centre);
        let centre = centre.filter(|_| is_common).map(|centre| view.world_from_sensor() * centre);
        Self { view, centre }
    }

    /// The ways on which the view sees a point, if its pixel has a value: from the start of the
    /// pixel's ray, and from its second viewpoint, if it has one.
    fn sight(&self, in_world: &Point3) -> Option<(Ray, Option<Ray>)> {
        let view = &self.view;
        let pixel = pixel(view, in_world)?;
        view.image().get(pixel)?;
        let placed = |in_sensor: Point3| view.world_from_sensor() * in_sensor;
        let start = match self.centre {
            Some(centre) => centre,
            None => placed(view.frame().ray(pixel)?.start),
        };
        let second = view.frame().second_viewpoint(pixel);
        Some((way(&start, in_world), second.map(|start| way(&placed(start), in_world))))
    }
}

/// The way from a place to a point; it has the length 1 there.
fn way(from: &Point3, to: &Point3) -> Ray {
    Ray::new(parry::point(from), parry::vector(&(to - from)))
}

/// How a way to a point of the surface ends.
enum End {
    /// At the point, with this cosine of incidence; `None` where no surface is.
    AtPoint(Option<f64>),
    /// At a triangle before it.
    Blocked(Triangle),
}

impl Visibility {
    /// The visibility of a surface in the world.
    ///
    /// # Errors
    /// [`MeshError`] if the surface is no usable mesh.
    pub fn new(surface: &Mesh, views: Vec<View>) -> Result<Self, MeshError> {
        surface.check()?;
        let vertices = surface.vertices.iter().map(parry::point).collect();
        let flags = TriMeshFlags::empty();
        let surface = TriMesh::with_flags(vertices, surface.faces.clone(), flags);
        let surface = surface.map_err(|_| MeshError::Empty)?;
        let sides = surface.local_aabb().extents();
        let reached = REACHED * sides.x.max(sides.y).max(sides.z);
        let eyes = views.into_iter().map(Eye::new).collect();
        let least_cosine = MAX_INCIDENCE_DEG.to_radians().cos();
        Ok(Self { surface, reached, eyes, least_cosine })
    }

    /// Whether some view sees each of some points of the surface, in the order of a curve.
    pub fn sees(&self, in_world: &[Point3]) -> Vec<bool> {
        let mut blockers = vec![None; self.eyes.len()];
        let mut last = 0;
        let mut is_seen = |point: &Point3| {
            let others = (0..self.eyes.len()).filter(|k| *k != last);
            let mut views = std::iter::once(last).chain(others);
            let found = views.find(|k| {
                let eye = self.eyes.get(*k).zip(blockers.get_mut(*k));
                eye.is_some_and(|(eye, blocker)| self.sees_point(eye, point, blocker))
            });
            last = found.unwrap_or(last);
            found.is_some()
        };
        in_world.iter().map(&mut is_seen).collect()
    }

    /// Whether a view sees a point. `blocker` is the triangle that last hid a point from it.
    fn sees_point(&self, eye: &Eye, in_world: &Point3, blocker: &mut Option<Triangle>) -> bool {
        let hidden = eye.centre.zip(blocker.as_ref());
        if hidden.is_some_and(|(centre, triangle)| self.blocks(triangle, &way(&centre, in_world))) {
            return false;
        }
        let Some((way, second)) = eye.sight(in_world) else { return false };
        match self.end(&way) {
            End::Blocked(triangle) => {
                *blocker = Some(triangle);
                false
            }
            End::AtPoint(cosine) => {
                let is_free = |way: &Ray| matches!(self.end(way), End::AtPoint(Some(_)));
                cosine.is_some_and(|cosine| cosine > self.least_cosine)
                    && second.as_ref().is_none_or(is_free)
            }
        }
    }

    /// Follows a way to a point of the surface.
    fn end(&self, way: &Ray) -> End {
        let ray = WorldRay::new(way.origin, way.dir);
        let tolerance = self.tolerance(way);
        // Room for rounding in boxes without thickness.
        let thick = Vector::splat(self.reached);
        let leaves = self.surface.bvh().leaves(|node| {
            ray.box_entry(node.mins() - thick, node.maxs() + thick) <= 1.0 + tolerance
        });
        let (mut nearest, mut cosine) = (f64::INFINITY, None);
        for leaf in leaves {
            let triangle = self.surface.triangle(leaf);
            let hit = triangle.cast_local_ray_and_get_normal(way, 1.0 + tolerance, false);
            let Some(hit) = hit.filter(|hit| hit.time_of_impact < nearest) else { continue };
            if hit.time_of_impact <= 1.0 - tolerance {
                return End::Blocked(triangle);
            }
            nearest = hit.time_of_impact;
            // Either side counts: an open sheet has no outside, and the front of a closed surface
            // blocks the way to its back.
            cosine = Some(hit.normal.dot(way.dir.normalize()).abs());
        }
        End::AtPoint(cosine)
    }

    /// Whether a triangle lies across a way before its end.
    fn blocks(&self, triangle: &Triangle, way: &Ray) -> bool {
        triangle.cast_local_ray(way, 1.0 - self.tolerance(way), false).is_some()
    }

    /// The tolerance at the end of a way, as a share of its length.
    fn tolerance(&self, way: &Ray) -> f64 {
        (self.reached / way.dir.length()).min(1.0)
    }
}

/// The pixel of the image that a point projects to.
fn pixel(view: &View, in_world: &Point3) -> Option<Pixel> {
    let in_sensor = view.world_from_sensor().inverse_transform_point(in_world);
    let at = view.frame().device_point(&in_sensor)?;
    let (row, col) = (at.row.round(), at.col.round());
    let size = view.image().size();
    let is_inside =
        (0.0..size.rows as f64).contains(&row) && (0.0..size.cols as f64).contains(&col);
    is_inside.then(|| Pixel::new(row as usize, col as usize))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_frames::SheetOfLight;
    use crate::{Noise, Scene, Shape, Solid};
    use parry3d_f64::query::RayIntersection;
    use std::sync::Arc;
    use transect_device::{DeviceFrame, ImageSize, Isometry3};
    use transect_sensors::{Intrinsics, Pinhole};

    #[test]
    fn what_the_camera_of_a_triangulation_sensor_cannot_see_is_not_seen() {
        let block = |size: [f64; 3], x: f64, z: f64| {
            let shape = Shape::cuboid(size.into()).unwrap();
            Solid::new(shape, Isometry3::translation(x, 0.0, z)).unwrap()
        };
        // The step of the casting tests: the camera's shadow begins at x = 0.25 on the wall.
        let wall = block([40.0, 20.0, 1.0], 0.0, 10.5);
        let scene = Scene::new(vec![wall, block([2.0, 20.0, 3.0], 2.0, 9.5)]);
        let frame = SheetOfLight { size: ImageSize { rows: 3, cols: 40 }, base_line: 4.0 };
        let view = scene.view("step", Arc::new(frame), Isometry3::identity(), &Noise::NONE, 0);
        let seen = Visibility::new(&scene.mesh(0.1).unwrap(), vec![view.unwrap()]).unwrap();
        let sees = |x, z| seen.sees(&[Point3::new(x, 0.1, z)]) == [true];
        // All three belong to the pixel of column 20, whose ray ends at x = 0.13.
        for (x, expected) in [(0.05, true), (0.24, true), (0.258, false)] {
            assert_eq!(sees(x, 10.0), expected, "{x}");
        }
        assert!(sees(2.0, 8.0));
        assert!(!sees(3.5, 10.0), "shadow of the laser");
    }

    /// A board of 15 mm, 20 m before a camera that looks along z.
    #[test]
    fn the_hidden_side_of_a_thin_board_is_not_seen() {
        let shape = Shape::cuboid([4.0, 4.0, 0.015].into()).unwrap();
        let pose = Isometry3::translation(0.0, 0.0, 20.0);
        let scene = Scene::new(vec![Solid::new(shape, pose).unwrap()]);
        let lens = Intrinsics { fx: 200.0, fy: 200.0, cx: 49.5, cy: 49.5 };
        let frame = Pinhole::new(ImageSize { rows: 100, cols: 100 }, lens).unwrap();
        let view = scene.view("board", Arc::new(frame), Isometry3::identity(), &Noise::NONE, 0);
        let seen = Visibility::new(&scene.mesh(0.01).unwrap(), vec![view.unwrap()]).unwrap();
        let side = |z: f64| [Point3::new(0.3, 0.4, z), Point3::new(-1.1, 0.7, z)];
        assert_eq!(seen.sees(&side(20.0 - 0.0075)), [true, true]);
        assert_eq!(seen.sees(&side(20.0 + 0.0075)), [false, false]);
    }

    #[test]
    fn points_are_seen_as_a_search_of_all_triangles_for_each_point_finds() {
        let block = |size: [f64; 3], x: f64, y: f64, z: f64| {
            let shape = Shape::cuboid(size.into()).unwrap();
            Solid::new(shape, Isometry3::translation(x, y, z)).unwrap()
        };
        let ball = Solid::new(Shape::ball(0.8).unwrap(), Isometry3::translation(-1.5, 1.0, 6.0));
        let wall = block([12.0, 8.0, 1.0], 0.0, 0.0, 9.0);
        let scene = Scene::new(vec![wall, block([1.0, 5.0, 1.0], 1.0, 0.0, 5.0), ball.unwrap()]);
        let size = ImageSize { rows: 30, cols: 40 };
        let lens = Intrinsics { fx: 30.0, fy: 30.0, cx: 19.5, cy: 14.5 };
        let camera: Arc<dyn DeviceFrame> = Arc::new(Pinhole::new(size, lens).unwrap());
        let stripe: Arc<dyn DeviceFrame> = Arc::new(SheetOfLight { size, base_line: 2.0 });
        let poses = [(&camera, -2.0), (&camera, 0.5), (&camera, 3.0), (&stripe, 0.0)];
        let view = |(frame, x): &(&Arc<dyn DeviceFrame>, f64)| {
            let pose = Isometry3::translation(*x, 0.0, 0.0);
            scene.view("view", (*frame).clone(), pose, &Noise::NONE, 0).unwrap()
        };
        let mesh = scene.mesh(0.05).unwrap();
        let seen = Visibility::new(&mesh, poses.iter().map(view).collect()).unwrap();
        let all: Vec<Triangle> = seen.surface.triangles().collect();
        let cosine = |way: &Ray| {
            let end = seen.tolerance(way);
            let hit = |t: &Triangle| t.cast_local_ray_and_get_normal(way, 1.0 + end, false);
            let nearer = |a: &RayIntersection, b: &RayIntersection| {
                a.time_of_impact.total_cmp(&b.time_of_impact)
            };
            let first = all.iter().filter_map(hit).min_by(nearer)?;
            let cosine = first.normal.dot(way.dir.normalize()).abs();
            (first.time_of_impact > 1.0 - end).then_some(cosine)
        };
        let mut alone = |point: &Point3| {
            seen.eyes.iter().any(|eye| {
                let Some((way, second)) = eye.sight(point) else { return false };
                cosine(&way).is_some_and(|c| c > seen.least_cosine)
                    && second.is_none_or(|way| cosine(&way).is_some())
            })
        };
        let mut counts = [0; 2];
        for [a, b, c] in &mesh.faces {
            let [a, b, c] = [a, b, c].map(|k| mesh.vertices[*k as usize]);
            let along = |k: u32| a + (b - a) * 0.45 + (c - b) * (0.02 + 0.024 * f64::from(k));
            let group: Vec<Point3> = (0..20).map(along).collect();
            let expected: Vec<bool> = group.iter().map(&mut alone).collect();
            expected.iter().for_each(|seen| counts[usize::from(*seen)] += 1);
            assert_eq!(seen.sees(&group), expected, "{a} {b} {c}");
        }
        assert!(counts[0] > 1000 && counts[1] > 500, "{counts:?}");
    }
}
