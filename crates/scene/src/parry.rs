//! Between the workspace's vectors (nalgebra) and parry's (glam).

use parry3d_f64::math::{Matrix, Vector};
use transect_geometry::{Isometry3, Point3, Vector3};

/// A direction for parry.
pub fn vector(v: &Vector3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// A point for parry.
pub fn point(p: &Point3) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

/// A direction from parry.
pub fn from_vector(v: Vector) -> Vector3 {
    Vector3::new(v.x, v.y, v.z)
}

/// A point from parry.
pub fn from_point(p: Vector) -> Point3 {
    Point3::new(p.x, p.y, p.z)
}

/// A rigid motion `target = rotation · source + translation` with a matrix, which turns a vector
/// faster than a quaternion does.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// Turns source directions into target directions.
    pub rotation: Matrix,
    /// The source's origin in the target.
    pub translation: Vector,
}

impl Motion {
    /// The same motion for parry.
    pub fn new(target_from_source: &Isometry3) -> Self {
        let m = target_from_source.rotation.to_rotation_matrix();
        let column = |k: usize| Vector::new(m[(0, k)], m[(1, k)], m[(2, k)]);
        Self {
            rotation: Matrix::from_cols(column(0), column(1), column(2)),
            translation: vector(&target_from_source.translation.vector),
        }
    }

    /// A source point in the target.
    pub fn point(&self, p: Vector) -> Vector {
        self.rotation * p + self.translation
    }
}
