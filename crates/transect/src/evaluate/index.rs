//! The curve units of one plane in a spatial index.

use super::sample::{PlacedUnit, placed_units};
use rstar::RTree;
use transect_geometry::{Curve, CurveUnit, Point2, Vector2};
use transect_model::InTree;

/// Units count as equally near if their distances differ by less than this share. Chosen by hand:
/// rounding at the common end of two units stays far below it. Doubled or halved, it still does.
const EQUALLY_NEAR: f64 = 1e-9;

/// A unit in the tree.
#[derive(Debug, Clone, Copy)]
pub(super) struct IndexedUnit {
    /// The unit and its place along its curve.
    pub placed: PlacedUnit,
    /// Which of the plane's curves it belongs to.
    pub curve: usize,
}

impl AsRef<CurveUnit> for IndexedUnit {
    fn as_ref(&self) -> &CurveUnit {
        &self.placed.unit
    }
}

/// The unit nearest to a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearest {
    /// How far it is, in the coordinates' unit.
    pub distance: f64,
    /// Its direction, a unit vector.
    pub direction: Vector2,
}

/// All units with a length of some curves of one plane.
pub(super) struct UnitIndex {
    tree: RTree<InTree<IndexedUnit>>,
}

impl UnitIndex {
    /// Sorts the units of the curves into a tree.
    pub fn new(curves: &[Curve]) -> Self {
        let units = curves.iter().enumerate().flat_map(|(curve, c)| {
            placed_units(c).map(move |placed| InTree(IndexedUnit { placed, curve }))
        });
        Self { tree: RTree::bulk_load(units.collect()) }
    }

    /// The unit nearest to a point, any one of those equally near; `None` if there is no unit.
    pub fn nearest(&self, p: &Point2) -> Option<Nearest> {
        // Not `nearest_neighbor`: it prunes with an upper bound of the distance to a box's content.
        // Where the nearest point is a corner of the box, rounding can put that bound below the
        // true distance. The unit is then lost, and one several times as far may be returned.
        let (found, squared) =
            self.tree.nearest_neighbor_iter_with_distance_2((*p).into()).next()?;
        Some(Nearest { distance: squared.sqrt(), direction: found.placed.direction() })
    }

    /// Whether a direction agrees with a unit that is as near to the point as the nearest one.
    pub fn agrees(&self, p: &Point2, direction: &Vector2, nearest: &Nearest) -> bool {
        // Most samples have one nearest unit and need no second search.
        direction.dot(&nearest.direction) > 0.0 || {
            let reach = nearest.distance * (1.0 + EQUALLY_NEAR);
            self.within(p, reach).any(|u| direction.dot(&u.placed.direction()) > 0.0)
        }
    }

    /// The units no farther than `reach` from a point, in no particular order.
    pub fn within(&self, p: &Point2, reach: f64) -> impl Iterator<Item = &IndexedUnit> {
        self.tree.locate_within_distance((*p).into(), reach * reach).map(|entry| &entry.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::tests::{curves, polyline};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn nearest_unit_is_that_of_a_search_through_all(
            curves in curves(), x in -2.0..12.0, y in -2.0..12.0,
        ) {
            let p = Point2::new(x, y);
            let slow = curves.iter().map(|c| c.foot(&p).distance).fold(f64::INFINITY, f64::min);
            let fast = UnitIndex::new(&curves).nearest(&p).unwrap().distance;
            // Both are rounded, and the tree takes a square root of a square.
            prop_assert!((fast - slow).abs() <= 1e-12 * (1.0 + slow), "{fast} {slow}");
        }

        #[test]
        fn units_within_reach_are_those_of_a_search_through_all(
            curves in curves(), x in -2.0..12.0, y in -2.0..12.0, reach in 0.0..4.0,
        ) {
            let p = Point2::new(x, y);
            let near = |c: &Curve| c.units().filter(|u| u.distance(&p) <= reach).count();
            let index = UnitIndex::new(&curves);
            prop_assert_eq!(index.within(&p, reach).count(), curves.iter().map(near).sum::<usize>());
        }
    }

    /// The nearest point of these boxes is a corner, and `RTree::nearest_neighbor` misses it.
    #[test]
    fn rounding_at_a_corner_loses_no_unit() {
        let corners = [
            [(6.5, 5.6), (7.6, 5.9)],
            [(7.3, 5.8), (8.2, 6.8)],
            [(4.6, 7.3), (5.4, 8.2)],
            [(8.4, 5.5), (9.1, 5.8)],
            [(0.4, 0.1), (0.9, 1.1)],
            [(6.0, 8.9), (6.1, 9.5)],
            [(8.7, 3.1), (9.5, 3.7)],
        ];
        let boxes = corners.map(|[(left, low), (right, high)]| {
            polyline(&[(left, low), (right, low), (right, high), (left, high)], true)
        });
        let nearest = UnitIndex::new(&boxes).nearest(&Point2::new(3.0, 5.5)).unwrap();
        let to_corner = 1.6_f64.hypot(1.8);
        assert!((nearest.distance - to_corner).abs() < 1e-12, "{}", nearest.distance);
    }

    #[test]
    fn without_units_nothing_is_near() {
        assert!(UnitIndex::new(&[]).nearest(&Point2::origin()).is_none());
        let a_point = polyline(&[(1.0, 1.0), (1.0, 1.0)], false);
        assert!(UnitIndex::new(&[a_point]).nearest(&Point2::origin()).is_none());
    }

    #[test]
    fn at_a_sharp_corner_both_units_are_asked() {
        let hairpin = polyline(&[(0.0, 0.0), (1.0, 0.0), (0.0, 0.1)], false);
        let index = UnitIndex::new(&[hairpin]);
        let beyond = Point2::new(1.5, 0.0);
        let nearest = index.nearest(&beyond).unwrap();
        assert!(index.agrees(&beyond, &Vector2::x(), &nearest));
        assert!(index.agrees(&beyond, &-Vector2::x(), &nearest));
        let beside = Point2::new(0.5, -0.1);
        let nearest = index.nearest(&beside).unwrap();
        assert!(!index.agrees(&beside, &-Vector2::x(), &nearest));
    }
}
