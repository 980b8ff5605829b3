//! The part of a surface that a set of views can see. A model can only be compared with this part.
//!
//! Points come in groups of neighbours. The rays of one view to such a group run close together, so
//! one search with a thick ray finds all triangles that any of them can meet. Each ray is then
//! tested against these few triangles alone. Where one triangle hides the box around the group from
//! a view, no point needs a ray of its own: the places that a triangle hides are a convex set.

use crate::scene::WorldRay;
use crate::{Mesh, MeshError, parry};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::{TriMesh, TriMeshFlags, Triangle};
use transect_device::{Pixel, View};
use transect_geometry::Point3;

/// Largest angle of incidence, in degrees, at which a surface counts as seen. Chosen by hand: at
/// this angle samples lie six times as far apart as head-on. It cannot be doubled; at 90 every
/// surface counts as seen, however oblique.
const MAX_INCIDENCE_DEG: f64 = 80.0;

/// Tolerance of a free path at its end, relative to its length. Chosen by hand: above rounding,
/// below any thickness. Doubling it changes nothing visible.
const REACHED: f64 = 1e-3;

/// Most rays that share one thick ray. Chosen by hand. Doubled, each ray is tested against more
/// triangles; halved, there are twice as many searches. What is seen stays the same.
const BUNDLE: usize = 16;

/// Most points of a group. Chosen by hand. Doubled, a triangle hides a whole group less often;
/// halved, there are more searches. What is seen stays the same.
const GROUP: usize = 32;

/// Factor on the radius of a thick ray, against rounding. Chosen by hand: far above rounding.
/// Doubled, more triangles are tested, with equal results.
const THICKER: f64 = 1.01;

/// Finds the points of a surface that some view sees.
///
/// A point is seen if it projects into a view's image and the nearest pixel is not missing. The
/// paths to the start of that pixel's ray, and to its second viewpoint, if any, must be free. A
/// view whose device frame has no inverse mapping sees no point, because its rays between the
/// pixels are unknown.
#[derive(Debug)]
pub struct Visibility {
    surface: TriMesh,
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

    /// The ways on which the view sees a point, if its pixel has a value.
    fn sight(&self, number: usize, in_world: &Point3) -> Option<Sight> {
        let view = &self.view;
        let pixel = pixel(view, in_world)?;
        view.image().get(pixel)?;
        let from =
            |start: Point3| Ray::new(parry::point(&start), parry::vector(&(in_world - start)));
        let placed = |in_sensor: Point3| view.world_from_sensor() * in_sensor;
        let start = match self.centre {
            Some(centre) => centre,
            None => placed(view.frame().ray(pixel)?.start),
        };
        let second = view.frame().second_viewpoint(pixel).map(|viewpoint| from(placed(viewpoint)));
        Some(Sight { number, way: from(start), second })
    }

    fn centre(&self) -> Option<Vector> {
        self.centre.map(|centre| parry::point(&centre))
    }

    /// Whether an end or the middle of a group is in the image.
    fn looks_at(&self, group: &[Point3]) -> bool {
        let samples = [group.first(), group.get(group.len() / 2), group.last()];
        samples.into_iter().flatten().any(|point| pixel(&self.view, point).is_some())
    }
}

/// How a view sees the middle of a group of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Glance {
    Seen,
    /// One triangle hides the whole group.
    Hidden,
    /// Not in the image, hidden or seen too obliquely; other points may be seen.
    Unknown,
}

/// The ways to a point of the surface from where a view sees it.
struct Sight {
    /// The point's place in its group.
    number: usize,
    /// From the start of the pixel's ray.
    way: Ray,
    /// From the pixel's second viewpoint, if it has one.
    second: Option<Ray>,
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
        let eyes = views.into_iter().map(Eye::new).collect();
        Ok(Self { surface, eyes, least_cosine: MAX_INCIDENCE_DEG.to_radians().cos() })
    }

    /// Whether some view sees each of some points of the surface. The points should be in the order
    /// of a curve: the time per point grows with the triangles around the paths to its neighbours.
    pub fn sees(&self, in_world: &[Point3]) -> Vec<bool> {
        in_world.chunks(GROUP).flat_map(|group| self.sees_group(group)).collect()
    }

    /// Whether some view sees each of a group of points.
    fn sees_group(&self, in_world: &[Point3]) -> Vec<bool> {
        let mut seen = vec![false; in_world.len()];
        let bounds = Aabb::from_points(in_world.iter().map(parry::point));
        let middle = in_world.get(in_world.len() / 2);
        let mut hidden = Vec::with_capacity(self.eyes.len());
        // Mostly, a view that sees the middle of a group sees all of it.
        let first = self.eyes.iter().position(|eye| {
            let found = middle.map(|point| self.glance(eye, point, &bounds));
            hidden.push(found == Some(Glance::Hidden));
            found == Some(Glance::Seen)
        });
        let others = (0..self.eyes.len()).filter(|k| Some(*k) != first);
        for k in first.into_iter().chain(others) {
            let Some(eye) = self.eyes.get(k).filter(|_| seen.contains(&false)) else { break };
            let is_hidden = hidden.get(k).is_some_and(|hidden| *hidden)
                || eye.looks_at(in_world) && self.hides(eye, &bounds);
            if !is_hidden {
                self.look(eye, in_world, &mut seen);
            }
        }
        seen
    }

    /// How a view sees the middle of a group within a box.
    fn glance(&self, eye: &Eye, middle: &Point3, bounds: &Aabb) -> Glance {
        let Some(sight) = eye.sight(0, middle) else { return Glance::Unknown };
        let mut around = self.around(std::iter::once(&sight.way));
        let Some(cosine) = cosine_at_end(&sight.way, &mut around) else {
            // Mostly, what hides the middle hides all.
            let blocker = around.first().zip(eye.centre());
            let hides = blocker.is_some_and(|(triangle, centre)| hides(triangle, centre, bounds));
            return if hides { Glance::Hidden } else { Glance::Unknown };
        };
        let is_watched = |way: &Ray| {
            let mut around = self.around(std::iter::once(way));
            cosine_at_end(way, &mut around).is_some()
        };
        let is_seen = cosine > self.least_cosine && sight.second.as_ref().is_none_or(is_watched);
        if is_seen { Glance::Seen } else { Glance::Unknown }
    }

    /// Marks the points that a view sees.
    fn look(&self, eye: &Eye, in_world: &[Point3], seen: &mut [bool]) {
        let unseen = in_world.iter().enumerate().filter(|(k, _)| seen.get(*k) == Some(&false));
        let sights: Vec<Sight> = unseen.filter_map(|(k, point)| eye.sight(k, point)).collect();
        for sights in sights.chunks(BUNDLE) {
            self.follow(sights, seen);
        }
    }

    /// Marks the points that can be seen on the ways to them.
    fn follow(&self, sights: &[Sight], seen: &mut [bool]) {
        let mut from_start = self.around(sights.iter().map(|s| &s.way));
        let mut from_second = self.around(sights.iter().filter_map(|s| s.second.as_ref()));
        for sight in sights {
            let cosine = cosine_at_end(&sight.way, &mut from_start);
            let is_lit = cosine.is_some_and(|c| c > self.least_cosine);
            let mut is_watched = |way| cosine_at_end(way, &mut from_second).is_some();
            if let Some(seen) = seen.get_mut(sight.number) {
                *seen = is_lit && sight.second.as_ref().is_none_or(&mut is_watched);
            }
        }
    }

    /// Whether one triangle hides a box from a view.
    fn hides(&self, eye: &Eye, bounds: &Aabb) -> bool {
        let Some(centre) = eye.centre() else { return false };
        let middle = WorldRay::new(centre, bounds.center() - centre);
        let mut leaves = self.surface.bvh().leaves(|n| middle.box_entry(n.mins(), n.maxs()) <= 1.0);
        leaves.any(|leaf| hides(&self.surface.triangle(leaf), centre, bounds))
    }

    /// The triangles that neighbouring ways can meet.
    ///
    /// The middle one of the ways is as thick as the largest distance of another one's ends from
    /// its own. In between, and a little beyond the end, other ways are no farther from it.
    fn around<'a>(&self, ways: impl Iterator<Item = &'a Ray> + Clone) -> Vec<Triangle> {
        let Some(middle) = ways.clone().nth(ways.clone().count() / 2) else { return Vec::new() };
        let end = |way: &Ray| way.origin + way.dir;
        let distance = |way: &Ray| {
            (way.origin - middle.origin).length().max((end(way) - end(middle)).length())
        };
        let radius = ways.map(distance).fold(REACHED * 1e-3 * middle.dir.length(), f64::max);
        let thick = Vector::splat(THICKER * radius);
        let ray = WorldRay::new(middle.origin, middle.dir);
        let leaves = self.surface.bvh().leaves(|node| {
            ray.box_entry(node.mins() - thick, node.maxs() + thick) <= 1.0 + REACHED
        });
        let mut found = Vec::with_capacity(4 * BUNDLE);
        found.extend(leaves.map(|leaf| self.surface.triangle(leaf)));
        found
    }
}

/// Whether a triangle hides a box from a place.
fn hides(triangle: &Triangle, centre: Vector, bounds: &Aabb) -> bool {
    let blocks = |end: Vector| {
        let way = Ray::new(centre, end - centre);
        triangle.cast_local_ray(&way, 1.0 - REACHED, false).is_some()
    };
    blocks(bounds.center()) && bounds.vertices().iter().all(|corner| blocks(*corner))
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

/// Cosine of incidence of a way on the surface at its end; `None` if it is blocked before.
///
/// A triangle that blocks the way becomes the first one, as it mostly blocks the next way, too.
fn cosine_at_end(way: &Ray, around: &mut [Triangle]) -> Option<f64> {
    let mut first = None;
    let mut least = f64::INFINITY;
    for k in 0..around.len() {
        // Measured in the length of the way, a ray that reaches the point hits at 1.
        let hit = around.get(k)?.cast_local_ray_and_get_normal(way, 1.0 + REACHED, false);
        let Some(hit) = hit.filter(|hit| hit.time_of_impact < least) else { continue };
        if hit.time_of_impact <= 1.0 - REACHED {
            around.swap(0, k);
            return None;
        }
        (first, least) = (Some(hit.normal), hit.time_of_impact);
    }
    first.map(|normal| normal.dot(way.dir.normalize()).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_frames::SheetOfLight;
    use crate::{Noise, Scene, Shape, Solid};
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

    #[test]
    fn groups_are_seen_as_a_search_of_all_triangles_for_each_point_finds() {
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
        let mut all: Vec<Triangle> = seen.surface.triangles().collect();
        let mut alone = |point: &Point3| {
            seen.eyes.iter().any(|eye| {
                let Some(sight) = eye.sight(0, point) else { return false };
                cosine_at_end(&sight.way, &mut all).is_some_and(|c| c > seen.least_cosine)
                    && sight.second.is_none_or(|way| cosine_at_end(&way, &mut all).is_some())
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
