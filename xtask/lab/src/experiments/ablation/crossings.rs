//! How often the curves of a plane cross themselves and each other.

use transect_geometry::{Curve, CurveUnit};

/// Pairs of units of a plane's curves that cross; units that follow each other do not count.
pub fn count(curves: &[Curve]) -> usize {
    let mut units: Vec<(f64, f64, CurveUnit)> = curves
        .iter()
        .flat_map(Curve::units)
        .map(|u| (u.start.x.min(u.end.x), u.start.x.max(u.end.x), u))
        .collect();
    units.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut crossings = 0;
    for (k, (_, right, unit)) in units.iter().enumerate() {
        let near = units.iter().skip(k + 1).take_while(|(left, ..)| left <= right);
        crossings += near.filter(|(.., other)| cross(unit, other)).count();
    }
    crossings
}

/// Whether two units cross inside both of them.
fn cross(a: &CurveUnit, b: &CurveUnit) -> bool {
    let side = |u: &CurveUnit, p| u.vector().perp(&(p - u.start));
    side(a, b.start) * side(a, b.end) < 0.0 && side(b, a.start) * side(b, a.end) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_geometry::{Node, Point2};

    #[test]
    fn an_eight_crosses_itself_once_and_a_square_never() {
        let closed = |corners: [[f64; 2]; 4]| {
            let nodes = corners.map(|c| Node::at(Point2::from(c))).to_vec();
            Curve::new(nodes, true).expect("four nodes")
        };
        let eight = closed([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
        let square = closed([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(count(std::slice::from_ref(&eight)), 1);
        assert_eq!(count(std::slice::from_ref(&square)), 0);
        let beside = closed([[0.5, -0.5], [2.0, -0.5], [2.0, 0.5], [0.5, 0.5]]);
        assert_eq!(count(&[square, beside]), 2);
    }
}
