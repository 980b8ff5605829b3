//! The closed curves that can be filled as solid.

use transect_geometry::{Curve, Point2};

/// Positions of the curves that bound solid area to fill: closed curves around solid, and the holes
/// inside them. A hole without solid around it, such as a room seen from inside, is not filled,
/// because no view saw the outer bound of its solid.
pub(super) fn filled(curves: &[&Curve]) -> Vec<usize> {
    let areas: Vec<f64> = curves.iter().map(|c| c.signed_area().unwrap_or(0.0)).collect();
    let solids: Vec<&Curve> =
        curves.iter().zip(&areas).filter(|(_, a)| **a > 0.0).map(|(c, _)| *c).collect();
    let around = |hole: &Curve| {
        let place = hole.nodes().first().map(|n| n.position);
        place.is_some_and(|p| solids.iter().any(|s| encloses(s, &p)))
    };
    let keep = |(curve, area): (&&Curve, &f64)| *area > 0.0 || (*area < 0.0 && around(curve));
    let numbered = curves.iter().zip(&areas).enumerate();
    numbered.filter(|(_, pair)| keep(*pair)).map(|(i, _)| i).collect()
}

/// Whether a closed curve goes round a point, by counting crossings of the line to the right.
fn encloses(curve: &Curve, p: &Point2) -> bool {
    if !curve.envelope().contains(p) {
        return false;
    }
    let crosses = |u: &transect_geometry::CurveUnit| {
        let (a, b) = (u.start, u.end);
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    curve.units().filter(crosses).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_data::curve;

    fn square(half: f64) -> Curve {
        curve(&[(-half, -half), (half, -half), (half, half), (-half, half)], true)
    }

    #[test]
    fn a_ring_is_filled_and_a_room_is_not() {
        let (outer, hole) = (square(2.0), square(1.0).reversed());
        assert_eq!(filled(&[&outer, &hole]), vec![0, 1]);
        let room = square(5.0).reversed();
        assert_eq!(filled(&[&room, &square(1.0)]), vec![1]);
        let open = curve(&[(0.0, 0.0), (1.0, 0.0)], false);
        assert_eq!(filled(&[&open]), Vec::<usize>::new());
    }
}
