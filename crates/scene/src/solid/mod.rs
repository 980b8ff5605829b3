//! Solids: a shape and where it stands.

mod ray;
mod tessellate;

pub(crate) use ray::LocalRay;
pub(crate) use tessellate::smallest_chord_error;

use crate::{Mesh, MeshError, parry};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::shape::TriMesh;
use std::sync::Arc;
use transect_geometry::{Isometry3, Vector3};

/// Parameters that describe no solid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolidError {
    /// A size is zero, negative, NaN or infinite.
    #[error("{key} = {value}: a positive length is wanted")]
    BadSize {
        /// The parameter, as scene descriptions call it.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// The pose has a component that is NaN or infinite.
    #[error("the pose is not finite")]
    PoseNotFinite,
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
    /// Axis along z, centred on the origin.
    Cylinder { radius: f64, half_height: f64 },
    /// Centred on the origin.
    Ball { radius: f64 },
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
        let radius = positive("radius", radius)?;
        Ok(Self(Kind::Cylinder { radius, half_height: 0.5 * positive("height", height)? }))
    }

    /// A ball around its frame's origin.
    ///
    /// # Errors
    /// [`SolidError::BadSize`] unless the radius is positive and finite.
    pub fn ball(radius: f64) -> Result<Self, SolidError> {
        Ok(Self(Kind::Ball { radius: positive("radius", radius)? }))
    }

    /// The solid that a closed triangle mesh bounds.
    ///
    /// # Errors
    /// [`SolidError::Mesh`] if it is not closed ([`Mesh::check_closed`]), naming the first bad edge.
    pub fn mesh(mesh: &Mesh) -> Result<Self, SolidError> {
        mesh.check_closed()?;
        let vertices = mesh.vertices.iter().map(parry::point).collect();
        // Parry refuses nothing but a mesh without faces, which has just been ruled out.
        let surface = TriMesh::new(vertices, mesh.faces.clone()).map_err(|_| MeshError::Empty)?;
        Ok(Self(Kind::Mesh(Arc::new(surface))))
    }

    /// A box around the shape, in its own frame.
    pub(crate) fn bounds(&self) -> Aabb {
        let around = |half: Vector| Aabb::new(-half, half);
        match &self.0 {
            Kind::Box { half } => around(*half),
            Kind::Cylinder { radius, half_height } => {
                around(Vector::new(*radius, *radius, *half_height))
            }
            Kind::Ball { radius } => around(Vector::splat(*radius)),
            Kind::Mesh(surface) => surface.local_aabb(),
        }
    }
}

fn positive(key: &'static str, value: f64) -> Result<f64, SolidError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(SolidError::BadSize { key, value })
    }
}

/// A shape placed in the world.
#[derive(Debug, Clone)]
pub struct Solid {
    name: Option<String>,
    shape: Shape,
    world_from_solid: Isometry3,
}

impl Solid {
    /// A shape at a pose.
    ///
    /// # Errors
    /// [`SolidError::PoseNotFinite`] if the pose has a NaN or infinite component.
    pub fn new(shape: Shape, world_from_solid: Isometry3) -> Result<Self, SolidError> {
        let finite = world_from_solid.to_homogeneous().iter().all(|c| c.is_finite());
        if finite {
            Ok(Self { name: None, shape, world_from_solid })
        } else {
            Err(SolidError::PoseNotFinite)
        }
    }

    /// The same solid with a name for reports.
    #[must_use]
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: Some(name.into()), ..self }
    }

    /// What reports call it, if it has a name.
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// Its form.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Where it stands: world coordinates from the shape's own.
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
        assert_eq!(flat.to_string(), "size = 0: a positive length is wanted");
        let nan = Shape::cylinder(1.0, f64::NAN).unwrap_err();
        assert!(matches!(nan, SolidError::BadSize { key: "height", .. }));
        assert!(Shape::ball(f64::INFINITY).is_err());
        assert!(Shape::ball(-1.0).is_err());
    }

    #[test]
    fn a_pose_must_be_finite() {
        let nowhere = Isometry3::translation(f64::NAN, 0.0, 0.0);
        let solid = Solid::new(Shape::ball(1.0).unwrap(), nowhere);
        assert_eq!(solid.unwrap_err(), SolidError::PoseNotFinite);
    }
}
