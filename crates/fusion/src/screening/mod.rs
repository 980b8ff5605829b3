//! Which pairs of curves may overlap at all (dissertation 5.3).
//!
//! The idea: comparing every curve with every other is slow, and comparing rectangles is cheap.
//! Every step below is necessary for an overlap, and none is sufficient;
//! [`classify`](crate::pattern::classify) verifies the pairs that are left.
//!
//! 1. The envelopes of the two curves, grown by the tolerance, must meet; their common rectangle
//!    limits the search (5.3.2). [`PlaneEnvelopes`](crate::envelopes::PlaneEnvelopes) finds them.
//!    The test of whole planes (5.3.1) is left out: this search contains it.
//! 2. Both curves must have units in the common rectangle (the dashed envelopes of Figure 5.3).
//! 3. Some of those units must run the same way: the opposite sides of a sheet and neighbouring
//!    surfaces that face each other do not (Figure 5.5).

use transect_geometry::{Curve, CurveUnit, Envelope};

/// Whether a segment and a rectangle share a point.
fn touches(unit: &CurveUnit, rectangle: &Envelope) -> bool {
    if !unit.envelope().intersects(rectangle) {
        return false;
    }
    // Two convex shapes are apart only if the segment's own line, too, has the rectangle on one
    // side.
    let (min, max) = (rectangle.min, rectangle.max);
    let corners = [min, [max.x, min.y].into(), max, [min.x, max.y].into()];
    let sides = corners.map(|corner| unit.line_value(&corner));
    sides.iter().any(|&s| s >= 0.0) && sides.iter().any(|&s| s <= 0.0)
}

/// Whether two curves may overlap in their common rectangle. Both must have units there, and some
/// unit of one must run the same way as some unit of the other, up to `max_angle_rad`.
///
/// `common` is the intersection of both envelopes, each grown by the distance up to which curves
/// overlap: a smaller rectangle loses pairs.
///
/// Cost: linear in the units of both curves; those in the rectangle are sorted.
pub fn may_overlap(a: &Curve, b: &Curve, common: &Envelope, max_angle_rad: f64) -> bool {
    let angles_of_a = angles_within(a, common);
    let mut angles_of_b = angles_within(b, common);
    angles_of_b.sort_by(f64::total_cmp);
    angles_of_a.iter().any(|angle| least_turn(*angle, &angles_of_b) <= max_angle_rad)
}

/// The directions of a curve's units in a rectangle, in radians from -π to π.
fn angles_within(curve: &Curve, rectangle: &Envelope) -> Vec<f64> {
    let within = curve.units().filter(|unit| touches(unit, rectangle));
    within.map(|unit| unit.vector().y.atan2(unit.vector().x)).collect()
}

/// The smallest turn from an angle to one of some sorted angles; infinite if there are none.
fn least_turn(angle: f64, sorted: &[f64]) -> f64 {
    let after = sorted.partition_point(|&other| other < angle);
    let before = after.checked_sub(1).and_then(|i| sorted.get(i));
    // The angles next to this one on the circle: a list's last angle comes before its first.
    let neighbours = [sorted.get(after), before, sorted.first(), sorted.last()];
    let turn = |other: &f64| {
        let turn = (angle - other).abs();
        turn.min(std::f64::consts::TAU - turn)
    };
    neighbours.into_iter().flatten().map(turn).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests;
