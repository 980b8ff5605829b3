//! Axes carried along a curve without turning about its tangent.
//!
//! Problem: the in-plane axes of neighbouring planes must not turn against each other. The axes of
//! the curve's own bend (Frenet) turn fast where it bends little.
//!
//! Idea: the rotation-minimising frame by double reflection (W. Wang, B. Jüttler, D. Zheng, Y. Liu,
//! Computation of rotation minimizing frames, ACM Transactions on Graphics 27(1), 2008). A
//! reflection in the plane half way between two points of the curve, and a second one that turns
//! the reflected tangent into the true one. Exact on plane curves; elsewhere the error of a step of
//! length h is O(h⁵).

use super::path_point::PathPoint;
use crate::Vector3;

/// The axis `x` at `from`, carried to `to`.
pub(super) fn carry(x: &Vector3, from: &PathPoint, to: &PathPoint) -> Vector3 {
    let chord = to.point - from.point;
    let between = reflect(x, &chord);
    let tangent = reflect(&from.tangent, &chord);
    let carried = reflect(&between, &(to.tangent - tangent));
    // Rounding is removed in every step, so that it does not add up over thousands of steps.
    let across = carried - to.tangent * to.tangent.dot(&carried);
    across.try_normalize(0.0).unwrap_or(*x)
}

/// A vector reflected in the plane perpendicular to another; unchanged if that one is zero.
fn reflect(v: &Vector3, normal: &Vector3) -> Vector3 {
    let size = normal.norm_squared();
    if size > 0.0 { v - normal * (2.0 * normal.dot(v) / size) } else { *v }
}
