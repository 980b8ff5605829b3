//! The local frame of one section plane (dissertation, section 2.4.2).

use crate::{Point2, Point3, Vector3};

/// A right-handed frame in space whose first two axes span a section plane.
///
/// ```text
///        normal (third axis)
///          ^    y_axis
///          |   /
///          |  /            world = origin + x · x_axis + y · y_axis + height · normal
///   origin +--------> x_axis
/// ```
///
/// Unit: the model's length unit. The axes are unit vectors and mutually orthogonal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneFrame {
    origin: Point3,
    x_axis: Vector3,
    y_axis: Vector3,
    normal: Vector3,
}

impl PlaneFrame {
    /// The world's own axes and origin.
    pub const WORLD: Self = Self {
        origin: Point3::new(0.0, 0.0, 0.0),
        x_axis: Vector3::new(1.0, 0.0, 0.0),
        y_axis: Vector3::new(0.0, 1.0, 0.0),
        normal: Vector3::new(0.0, 0.0, 1.0),
    };

    /// The frame with the given normal and origin; in-plane axes after the matrix `[T]` of 2.4.2.
    ///
    /// With `h = hypot(n_x, n_y)` of the unit normal `n`, the rotation is about X by `alpha_x` (cos
    /// `n_z`, sin `h`), then about Z by `alpha_z` (cos `-n_y / h`, sin `n_x / h`). The signs are
    /// those of the errata: the printed ones do not turn e_z into the normal. A normal along +Z
    /// gives the world's own axes, along -Z a half-turn about X.
    ///
    /// `normal` need not have unit length; `None` if it has no direction or is not finite.
    pub fn new(origin: Point3, normal: Vector3) -> Option<Self> {
        // Scaled first, so that tiny and huge normals do not lose digits.
        let normal = normal / normal.amax();
        let length = normal.norm();
        let usable =
            length.is_finite() && length > 0.0 && origin.coords.iter().all(|c| c.is_finite());
        if !usable {
            return None;
        }
        let n = normal / length;
        let h = n.x.hypot(n.y);
        let (cos_x, sin_x) = (n.z, h);
        let (cos_z, sin_z) = if h > 0.0 { (-n.y / h, n.x / h) } else { (1.0, 0.0) };
        let x_axis = Vector3::new(cos_z, sin_z, 0.0);
        let y_axis = Vector3::new(-cos_x * sin_z, cos_x * cos_z, sin_x);
        Some(Self { origin, x_axis, y_axis, normal: n })
    }

    /// The frame with a unit normal and a unit x axis perpendicular to it.
    pub(crate) fn carried(origin: Point3, normal: Vector3, x_axis: Vector3) -> Self {
        Self { origin, x_axis, y_axis: normal.cross(&x_axis), normal }
    }

    /// The same axes at another origin.
    #[must_use]
    pub fn moved_to(&self, origin: Point3) -> Self {
        Self { origin, ..*self }
    }

    /// The world point of plane coordinates (0, 0).
    pub fn origin(&self) -> Point3 {
        self.origin
    }

    /// First in-plane axis, a unit vector in the world.
    pub fn x_axis(&self) -> Vector3 {
        self.x_axis
    }

    /// Second in-plane axis, a unit vector in the world.
    pub fn y_axis(&self) -> Vector3 {
        self.y_axis
    }

    /// Plane normal, a unit vector in the world; `x_axis × y_axis`.
    pub fn normal(&self) -> Vector3 {
        self.normal
    }

    /// Plane coordinates of a world point, without its height.
    pub fn plane_from_world(&self, in_world: &Point3) -> Point2 {
        let d = in_world - self.origin;
        Point2::new(self.x_axis.dot(&d), self.y_axis.dot(&d))
    }

    /// Signed distance of a world point from the plane, positive on the normal's side.
    pub fn height(&self, in_world: &Point3) -> f64 {
        self.normal.dot(&(in_world - self.origin))
    }

    /// The world point of plane coordinates.
    pub fn world_from_plane(&self, in_plane: &Point2) -> Point3 {
        self.origin + self.x_axis * in_plane.x + self.y_axis * in_plane.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn normals() -> impl Strategy<Value = Vector3> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0)
            .prop_map(|(x, y, z)| Vector3::new(x, y, z))
            .prop_filter("has a direction", |v: &Vector3| v.norm() > 1e-3)
    }

    proptest! {
        #[test]
        fn axes_are_right_handed_and_end_in_the_normal(normal in normals()) {
            let f = PlaneFrame::new(Point3::new(1.0, 2.0, 3.0), normal).unwrap();
            prop_assert!((f.x_axis().cross(&f.y_axis()) - normal.normalize()).norm() < 1e-12);
            prop_assert!((f.x_axis().norm() - 1.0).abs() < 1e-12);
            prop_assert!(f.x_axis().dot(&f.y_axis()).abs() < 1e-12);
        }

        #[test]
        fn going_to_the_plane_and_back_returns_the_point(
            normal in normals(), x in -9.0..9.0, y in -9.0..9.0,
        ) {
            let f = PlaneFrame::new(Point3::new(5e5, 5.4e6, 300.0), normal).unwrap();
            let p = Point2::new(x, y);
            let world = f.world_from_plane(&p);
            prop_assert!((f.plane_from_world(&world) - p).norm() < 1e-8);
            prop_assert!(f.height(&world).abs() < 1e-8);
        }
    }

    #[test]
    fn vertical_normals_have_stated_axes() {
        let up = PlaneFrame::new(Point3::origin(), Vector3::z() * 2.0).unwrap();
        assert_eq!((up.x_axis(), up.y_axis()), (Vector3::x(), Vector3::y()));
        let down = PlaneFrame::new(Point3::origin(), -Vector3::z()).unwrap();
        assert_eq!((down.x_axis(), down.y_axis()), (Vector3::x(), -Vector3::y()));
    }

    #[test]
    fn a_normal_without_direction_is_refused() {
        assert!(PlaneFrame::new(Point3::origin(), Vector3::zeros()).is_none());
        assert!(PlaneFrame::new(Point3::origin(), Vector3::new(f64::NAN, 0.0, 1.0)).is_none());
    }
}
