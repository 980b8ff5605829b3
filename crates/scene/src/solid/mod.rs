//! Solids: a shape and its pose.

mod frustum;
mod prism;
mod ray;
mod tessellate;
mod torus;

pub(crate) use ray::LocalRay;
pub(crate) use tessellate::smallest_chord_error;

use crate::mesh::LARGEST;
use crate::{Mesh, MeshError, parry};
use frustum::Frustum;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::shape::TriMesh;
use std::sync::Arc;
use torus::Torus;
use transect_geometry::{Isometry3, Point2, Vector3};

/// Why parameters make no solid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolidError {
    /// A size is not positive, or beyond [`LARGEST`].
    #[error("{key} = {value:?}: a positive length of at most {LARGEST:e} is wanted")]
    BadSize {
        /// The parameter, by its name in scene descriptions.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// The pose has a component that is no number, or beyond [`LARGEST`].
    #[error("the pose has a component that is not finite, or beyond {LARGEST:e}")]
    PoseNotFinite,
    /// A torus without a hole would cut itself.
    #[error("tube = {tube}: it must be thinner than the ring, whose radius is {radius}")]
    TubeTooThick {
        /// Radius of the circle that the tube runs along.
        radius: f64,
        /// Radius of the tube.
        tube: f64,
    },
    /// Corners that do not bound a polygon, or a polygon that a prism cannot have there.
    #[error("{key}: {reason}")]
    BadPolygon {
        /// The polygon, by its name in scene descriptions.
        key: &'static str,
        /// The problem with it.
        reason: String,
    },
    /// A reflectivity is not above 0 and at most 1.
    #[error("reflectivity = {0}: a share above 0, up to 1, is wanted")]
    BadReflectivity(f64),
    /// The triangles do not bound a solid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// A solid's form in its own frame, in the model's length unit.
///
/// Guaranteed: sizes are positive and finite, and a mesh is closed and wound outwards.
#[derive(Debug, Clone)]
pub struct Shape(Kind);

#[derive(Debug, Clone)]
enum Kind {
    /// Centred on the origin, edges along the axes.
    Box { half: Vector },
    /// A cylinder or a cone, whole or truncated: axis along z, centred on the origin.
    Frustum(Frustum),
    /// Centred on the origin.
    Ball { radius: f64 },
    /// Around the z axis, centred on the origin.
    Torus(Torus),
    /// Anywhere. Shared, so that solids are cheap to clone.
    Mesh(Arc<TriMesh>),
}

impl Shape {
    /// A box of the given edge lengths along x, y and z, centred on its frame's origin.
    ///
    /// # Errors
    /// [`SolidError::BadSize`] unless all three are positive and finite.
    pub fn cuboid(size: Vector3) -> Result<Self, SolidError> {
        for &edge in &size {
            positive("size", edge)?;
        }
        Ok(Self(Kind::Box { half: parry::vector(&(size * 0.5)) }))
    }

    /// A circular cylinder with flat ends. Its axis is the **z axis** of its frame, its centre the
    /// origin: it reaches from `z = -height/2` to `z = height/2`.
    ///
    /// # Errors
    /// [`SolidError::BadSize`] unless both are positive and finite.
    pub fn cylinder(radius: f64, height: f64) -> Result<Self, SolidError> {
        Self::frustum(radius, radius, height)
    }

    /// A ball around its frame's origin.
    ///
    /// # Errors
    /// [`SolidError::BadSize`] unless the radius is positive and finite.
    pub fn ball(radius: f64) -> Result<Self, SolidError> {
        Ok(Self(Kind::Ball { radius: positive("radius", radius)? }))
    }

    /// A cone that stands on its base. Its axis is the **z axis** of its frame: the base lies at
    /// `z = -height/2`, the tip at `z = height/2`.
    ///
    /// # Errors
    /// [`SolidError::BadSize`] unless both are positive and finite.
    pub fn cone(radius: f64, height: f64) -> Result<Self, SolidError> {
        let (radius, height) = (positive("radius", radius)?, positive("height", height)?);
        Ok(Self(Kind::Frustum(Frustum { bottom: radius, top: 0.0, half_height: 0.5 * height })))
    }

    /// A truncated cone with flat ends; either may be the larger one. Its axis is the **z
    /// axis** of its frame: `radius` is that at `z = -height/2`, `top_radius` that at
    /// `z = height/2`.
    ///
    /// # Errors
    /// [`SolidError::BadSize`] unless all three are positive and finite.
    pub fn frustum(radius: f64, top_radius: f64, height: f64) -> Result<Self, SolidError> {
        let bottom = positive("radius", radius)?;
        let top = positive("top_radius", top_radius)?;
        let half_height = 0.5 * positive("height", height)?;
        Ok(Self(Kind::Frustum(Frustum { bottom, top, half_height })))
    }

    /// A ring with a hole, around the **z axis** of its frame: all points within `tube` of the
    /// circle of the given radius in the plane `z = 0`.
    ///
    /// # Errors
    /// [`SolidError::BadSize`] unless both are positive and finite, [`SolidError::TubeTooThick`]
    /// unless the tube is thinner than the ring.
    pub fn torus(radius: f64, tube: f64) -> Result<Self, SolidError> {
        let (radius, tube) = (positive("radius", radius)?, positive("tube", tube)?);
        if tube < radius {
            Ok(Self(Kind::Torus(Torus { radius, tube })))
        } else {
            Err(SolidError::TubeTooThick { radius, tube })
        }
    }

    /// A pyramid on a rectangle. `size` is the base's edge along x, its edge along y, and the
    /// height: the base lies at `z = -height/2`, the tip above its middle at `z = height/2`.
    ///
    /// # Errors
    /// [`SolidError::BadSize`] unless all three are positive and finite.
    pub fn pyramid(size: Vector3) -> Result<Self, SolidError> {
        for &edge in &size {
            positive("size", edge)?;
        }
        Self::mesh(&prism::pyramid(size))
    }

    /// The dissertation's general polyhedron (4.5.2): two parallel polygons of as many corners, the
    /// bottom one at `z = -height/2` and the top one at `z = height/2`, corner joined to corner.
    ///
    /// Polygons may be concave and run either way round. A side whose two edges are not parallel is
    /// no plane; it is two triangles then, folded from the bottom edge's first corner to the top
    /// edge's second, counter-clockwise. Sides that cut through each other are not detected.
    ///
    /// # Errors
    /// [`SolidError::BadSize`] unless the height is positive and finite, [`SolidError::BadPolygon`]
    /// if a polygon crosses or touches itself, or the two do not belong together.
    pub fn prism(bottom: &[Point2], top: &[Point2], height: f64) -> Result<Self, SolidError> {
        Self::mesh(&prism::prism(bottom, top, positive("height", height)?)?)
    }

    /// The solid that a closed triangle mesh bounds.
    ///
    /// # Errors
    /// [`SolidError::Mesh`] if it is not closed ([`Mesh::check_closed`]), naming the first bad
    /// edge.
    pub fn mesh(mesh: &Mesh) -> Result<Self, SolidError> {
        mesh.check_closed()?;
        let vertices = mesh.vertices.iter().map(parry::point).collect();
        // Parry only refuses a mesh without faces, which was excluded above.
        let surface = TriMesh::new(vertices, mesh.faces.clone()).map_err(|_| MeshError::Empty)?;
        Ok(Self(Kind::Mesh(Arc::new(surface))))
    }

    /// A box around the shape, in its own frame.
    pub(crate) fn bounds(&self) -> Aabb {
        let around = |half: Vector| Aabb::new(-half, half);
        match &self.0 {
            Kind::Box { half } => around(*half),
            Kind::Frustum(Frustum { bottom, top, half_height }) => {
                let radius = bottom.max(*top);
                around(Vector::new(radius, radius, *half_height))
            }
            Kind::Ball { radius } => around(Vector::splat(*radius)),
            Kind::Torus(Torus { radius, tube }) => {
                around(Vector::new(radius + tube, radius + tube, *tube))
            }
            Kind::Mesh(surface) => surface.local_aabb(),
        }
    }
}

fn positive(key: &'static str, value: f64) -> Result<f64, SolidError> {
    if value > 0.0 && value <= LARGEST {
        Ok(value)
    } else {
        Err(SolidError::BadSize { key, value })
    }
}

/// A shape placed in the world.
#[derive(Debug, Clone)]
pub struct Solid {
    name: Option<String>,
    reflectivity: f64,
    shape: Shape,
    world_from_solid: Isometry3,
}

impl Solid {
    /// A shape at a pose.
    ///
    /// # Errors
    /// [`SolidError::PoseNotFinite`] if a component of the pose is no number, or beyond
    /// [`LARGEST`].
    pub fn new(shape: Shape, world_from_solid: Isometry3) -> Result<Self, SolidError> {
        // Comparisons with NaN are false.
        if world_from_solid.to_homogeneous().iter().all(|c| c.abs() <= LARGEST) {
            Ok(Self { name: None, reflectivity: 1.0, shape, world_from_solid })
        } else {
            Err(SolidError::PoseNotFinite)
        }
    }

    /// The same solid with a name for reports.
    #[must_use]
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: Some(name.into()), ..self }
    }

    /// The same solid of a matt material: light comes back by the cosine law, in proportion to the
    /// reflectivity. That is the share of the light that comes back from a surface seen head-on;
    /// 1, a perfect white, unless it is set.
    ///
    /// # Errors
    /// [`SolidError::BadReflectivity`] unless it is above 0 and at most 1.
    pub fn with_reflectivity(self, reflectivity: f64) -> Result<Self, SolidError> {
        if reflectivity > 0.0 && reflectivity <= 1.0 {
            Ok(Self { reflectivity, ..self })
        } else {
            Err(SolidError::BadReflectivity(reflectivity))
        }
    }

    /// Share of the light that comes back from its surface, seen head-on.
    pub fn reflectivity(&self) -> f64 {
        self.reflectivity
    }

    /// Its name in reports, if it has one.
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// Its form.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Its pose: world coordinates from the shape's own.
    pub fn world_from_solid(&self) -> &Isometry3 {
        &self.world_from_solid
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_sizes_are_named() {
        let flat = Shape::cuboid(Vector3::new(1.0, 0.0, 1.0)).unwrap_err();
        assert_eq!(flat.to_string(), "size = 0.0: a positive length of at most 1e13 is wanted");
        let nan = Shape::cylinder(1.0, f64::NAN).unwrap_err();
        assert!(matches!(nan, SolidError::BadSize { key: "height", .. }));
        assert!(Shape::ball(f64::INFINITY).is_err());
        assert!(Shape::ball(-1.0).is_err());
        let full = Shape::torus(1.0, 1.0).unwrap_err();
        assert_eq!(
            full.to_string(),
            "tube = 1: it must be thinner than the ring, whose radius is 1"
        );
        let edge = Shape::frustum(1.0, 0.0, 1.0).unwrap_err();
        assert!(matches!(edge, SolidError::BadSize { key: "top_radius", .. }));
        assert!(Shape::cone(1.0, -1.0).is_err());
        assert!(Shape::pyramid(Vector3::new(1.0, 1.0, 0.0)).is_err());
    }

    #[test]
    fn a_solid_reflects_as_told() {
        let solid = Solid::new(Shape::ball(1.0).unwrap(), Isometry3::identity()).unwrap();
        assert_eq!(solid.reflectivity(), 1.0);
        assert_eq!(solid.clone().with_reflectivity(0.05).unwrap().reflectivity(), 0.05);
        for bad in [0.0, -0.1, 1.1, f64::NAN] {
            let refused = solid.clone().with_reflectivity(bad);
            assert!(matches!(refused, Err(SolidError::BadReflectivity(_))));
        }
    }

    #[test]
    fn a_pose_must_be_finite() {
        for x in [f64::NAN, f64::INFINITY, 1e300] {
            let nowhere = Isometry3::translation(x, 0.0, 0.0);
            let solid = Solid::new(Shape::ball(1.0).unwrap(), nowhere);
            assert_eq!(solid.unwrap_err(), SolidError::PoseNotFinite);
        }
    }
}
