//! The part of a surface that a set of views can see. A model can only be compared with this part.

use crate::{Mesh, MeshError, parry};
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::{TriMesh, TriMeshFlags};
use transect_device::{Pixel, View};
use transect_geometry::Point3;

/// Largest angle of incidence, in degrees, at which a surface counts as seen. Chosen by hand: at
/// this angle samples lie six times as far apart as head-on. It cannot be doubled; at 90 every
/// surface counts as seen, however oblique.
const MAX_INCIDENCE_DEG: f64 = 80.0;

/// Tolerance of a free path at its end, relative to its length. Chosen by hand: above rounding,
/// below any thickness. Doubling it changes nothing visible.
const REACHED: f64 = 1e-3;

/// Finds the points of a surface that some view sees.
///
/// A point is seen if it projects into a view's image, the nearest pixel is not missing, and the
/// paths to the start of that pixel's ray and to its second viewpoint, if any, are free. A view
/// whose device frame has no inverse mapping sees no point, because its rays between the pixels are
/// unknown.
#[derive(Debug)]
pub struct Visibility {
    surface: TriMesh,
    views: Vec<View>,
    least_cosine: f64,
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
        Ok(Self { surface, views, least_cosine: MAX_INCIDENCE_DEG.to_radians().cos() })
    }

    /// Whether some view sees a point of the surface.
    pub fn sees(&self, in_world: &Point3) -> bool {
        self.views.iter().any(|view| self.seen_by(view, in_world).unwrap_or(false))
    }

    fn seen_by(&self, view: &View, in_world: &Point3) -> Option<bool> {
        let in_sensor = view.world_from_sensor().inverse_transform_point(in_world);
        let at = view.frame().device_point(&in_sensor)?;
        let (row, col) = (at.row.round(), at.col.round());
        if row < 0.0 || col < 0.0 {
            return None;
        }
        let pixel = Pixel::new(row as usize, col as usize);
        view.image().get(pixel)?;
        let start = view.world_from_sensor() * view.frame().ray(pixel)?.start;
        let cosine = self.cosine_at_end(&start, in_world)?;
        let watched = view.frame().second_viewpoint(pixel).is_none_or(|viewpoint| {
            self.cosine_at_end(&(view.world_from_sensor() * viewpoint), in_world).is_some()
        });
        Some(cosine > self.least_cosine && watched)
    }

    /// Cosine of incidence of a way on the surface at its end; `None` if it is blocked before.
    fn cosine_at_end(&self, start: &Point3, end: &Point3) -> Option<f64> {
        let way = end - start;
        let ray = Ray::new(parry::point(start), parry::vector(&way));
        // Measured in the length of the way, a ray that reaches the point hits at 1.
        let hit = self.surface.cast_local_ray_and_get_normal(&ray, 1.0 + REACHED, false)?;
        let normal = parry::from_vector(hit.normal).normalize();
        let reached = hit.time_of_impact > 1.0 - REACHED;
        reached.then(|| normal.dot(&way.normalize()).abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_frames::SheetOfLight;
    use crate::{Noise, Scene, Shape, Solid};
    use std::sync::Arc;
    use transect_device::{ImageSize, Isometry3};

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
        // All three belong to the pixel of column 20, whose ray ends at x = 0.13.
        for (x, expected) in [(0.05, true), (0.24, true), (0.258, false)] {
            assert_eq!(seen.sees(&Point3::new(x, 0.1, 10.0)), expected, "{x}");
        }
        assert!(seen.sees(&Point3::new(2.0, 0.1, 8.0)));
        assert!(!seen.sees(&Point3::new(3.5, 0.1, 10.0)), "shadow of the laser");
    }
}
