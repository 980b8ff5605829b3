//! What a set of views can see of a surface: the part of the truth that a model can be asked for.

use crate::{Mesh, MeshError, parry};
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::{TriMesh, TriMeshFlags};
use transect_device::{Pixel, View};
use transect_geometry::Point3;

/// Surface seen more obliquely than this is not counted as seen: its samples lie six times as far
/// apart as those of surface seen head-on.
const MAX_INCIDENCE_DEG: f64 = 80.0;

/// How far before the point a ray may hit and still have reached it, as a share of its length.
const REACHED: f64 = 1e-3;

/// Tells which points of a surface some view sees.
///
/// A point is seen if it projects into a view's image, the nearest pixel there is not missing, and
/// nothing lies between it and the start of that pixel's ray. Views whose device frame has no
/// inverse mapping see nothing: nobody knows where they look between their points.
pub struct Visibility {
    surface: TriMesh,
    views: Vec<View>,
    least_cosine: f64,
}

impl std::fmt::Debug for Visibility {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Visibility").field("views", &self.views.len()).finish_non_exhaustive()
    }
}

impl Visibility {
    /// What the views see of a surface in the world.
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
        let way = in_world - start;
        let ray = Ray::new(parry::point(&start), parry::vector(&way));
        // Measured in the length of the way, a ray that reaches the point hits at 1.
        let hit = self.surface.cast_local_ray_and_get_normal(&ray, 1.0 + REACHED, false)?;
        let normal = parry::from_vector(hit.normal).normalize();
        let cosine = normal.dot(&way.normalize()).abs();
        Some(hit.time_of_impact > 1.0 - REACHED && cosine > self.least_cosine)
    }
}
