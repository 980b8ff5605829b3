//! The curve units of one plane in a spatial index.
//!
//! Samples are looked up in groups of neighbours. One search around the group finds the units that
//! matter to any of its samples; each sample then goes through these few units.

use super::sample::{PlacedUnit, Sample, placed_units};
use rstar::RTree;
use transect_geometry::{Curve, CurveUnit, Point2, Vector2};
use transect_model::InTree;

/// Units count as equally near if their distances differ by less than this share. Chosen by hand:
/// rounding at the common end of two units stays far below it. Doubled or halved, it still does.
const EQUALLY_NEAR: f64 = 1e-9;

/// Factor on the radius of a search, against rounding. Chosen by hand: far above rounding. Doubled,
/// more units are looked at, with equal results.
const WIDER: f64 = 1.001;

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

    /// The units that can be nearest to a sample of a group, or as near as the nearest one.
    pub fn nearest_to(&self, group: &[Sample]) -> Nearby {
        let Some((centre, radius)) = disc(group) else { return Nearby(Vec::new()) };
        // Not `nearest_neighbor`: it prunes with an upper bound of the distance to a box's content.
        // Where the nearest point is a corner of the box, rounding can put that bound below the
        // true distance. The unit is then lost, and one several times as far may be returned.
        let nearest = self.tree.nearest_neighbor_iter_with_distance_2(centre.into()).next();
        // A sample's nearest unit is at most `radius` farther from the sample than from the centre.
        let units = nearest.map(|(_, squared)| self.around(&centre, squared.sqrt() + 2.0 * radius));
        Nearby(units.unwrap_or_default())
    }

    /// The units no farther than `reach` from some sample of a group.
    pub fn within(&self, group: &[Sample], reach: f64) -> Nearby {
        let units = disc(group).map(|(centre, radius)| self.around(&centre, reach + radius));
        Nearby(units.unwrap_or_default())
    }

    fn around(&self, centre: &Point2, reach: f64) -> Vec<IndexedUnit> {
        let reach = WIDER * reach;
        self.tree.locate_within_distance((*centre).into(), reach * reach).map(|u| u.0).collect()
    }
}

/// A disc around the samples of a group: its centre is the middle sample.
fn disc(group: &[Sample]) -> Option<(Point2, f64)> {
    let centre = group.get(group.len() / 2)?.position;
    let distances = group.iter().map(|sample| (sample.position - centre).norm());
    Some((centre, distances.fold(0.0, f64::max)))
}

/// The units that one search found for a group of samples, in no particular order.
pub(super) struct Nearby(Vec<IndexedUnit>);

impl Nearby {
    /// Forgets units.
    pub fn retain(&mut self, keep: impl FnMut(&IndexedUnit) -> bool) {
        self.0.retain(keep);
    }

    /// The unit nearest to a sample, any one of those equally near; `None` if there is no unit.
    pub fn nearest(&self, p: &Point2) -> Option<Nearest> {
        let placed = self.0.iter().map(|u| (u.placed.unit.distance(p), u));
        let (distance, found) = placed.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Nearest { distance, direction: found.placed.direction() })
    }

    /// Whether a direction agrees with a unit that is as near to a sample as the nearest one.
    pub fn agrees(&self, p: &Point2, direction: &Vector2, nearest: &Nearest) -> bool {
        // Most samples have one nearest unit and need no second look.
        direction.dot(&nearest.direction) > 0.0 || {
            let reach = nearest.distance * (1.0 + EQUALLY_NEAR);
            self.within(p, reach).any(|u| direction.dot(&u.placed.direction()) > 0.0)
        }
    }

    /// The units no farther than `reach` from a sample.
    pub fn within(&self, p: &Point2, reach: f64) -> impl Iterator<Item = &IndexedUnit> {
        self.0.iter().filter(move |u| u.placed.unit.distance(p) <= reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::tests::{curves, polyline};
    use proptest::prelude::*;

    /// Samples at some places; the searches need no more of them.
    fn group(places: &[(f64, f64)]) -> Vec<Sample> {
        let at = |&(x, y)| Point2::new(x, y);
        let sample =
            |position| Sample { position, direction: Vector2::x(), length: 1.0, along: 0.0 };
        places.iter().map(at).map(sample).collect()
    }

    fn places() -> impl Strategy<Value = Vec<(f64, f64)>> {
        proptest::collection::vec((-2.0..12.0, -2.0..12.0), 1..5)
    }

    proptest! {
        #[test]
        fn nearest_unit_is_that_of_a_search_through_all(curves in curves(), places in places()) {
            let group = group(&places);
            let nearby = UnitIndex::new(&curves).nearest_to(&group);
            for p in group.iter().map(|sample| sample.position) {
                let slow = curves.iter().map(|c| c.foot(&p).distance).fold(f64::INFINITY, f64::min);
                let fast = nearby.nearest(&p).unwrap().distance;
                // Both are rounded.
                prop_assert!((fast - slow).abs() <= 1e-12 * (1.0 + slow), "{fast} {slow}");
            }
        }

        #[test]
        fn units_within_reach_are_those_of_a_search_through_all(
            curves in curves(), places in places(), reach in 0.0..4.0,
        ) {
            let group = group(&places);
            let nearby = UnitIndex::new(&curves).within(&group, reach);
            for p in group.iter().map(|sample| sample.position) {
                let near = |c: &Curve| c.units().filter(|u| u.distance(&p) <= reach).count();
                let all = curves.iter().map(near).sum::<usize>();
                prop_assert_eq!(nearby.within(&p, reach).count(), all);
            }
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
        let nearby = UnitIndex::new(&boxes).nearest_to(&group(&[(3.0, 5.5)]));
        let nearest = nearby.nearest(&Point2::new(3.0, 5.5)).unwrap();
        let to_corner = 1.6_f64.hypot(1.8);
        assert!((nearest.distance - to_corner).abs() < 1e-12, "{}", nearest.distance);
    }

    #[test]
    fn without_units_nothing_is_near() {
        let a_point = polyline(&[(1.0, 1.0), (1.0, 1.0)], false);
        for curves in [vec![], vec![a_point]] {
            let nearby = UnitIndex::new(&curves).nearest_to(&group(&[(0.0, 0.0)]));
            assert!(nearby.nearest(&Point2::origin()).is_none());
        }
    }

    #[test]
    fn at_a_sharp_corner_both_units_are_asked() {
        let hairpin = polyline(&[(0.0, 0.0), (1.0, 0.0), (0.0, 0.1)], false);
        let index = UnitIndex::new(&[hairpin]).nearest_to(&group(&[(1.5, 0.0), (0.5, -0.1)]));
        let beyond = Point2::new(1.5, 0.0);
        let nearest = index.nearest(&beyond).unwrap();
        assert!(index.agrees(&beyond, &Vector2::x(), &nearest));
        assert!(index.agrees(&beyond, &-Vector2::x(), &nearest));
        let beside = Point2::new(0.5, -0.1);
        let nearest = index.nearest(&beside).unwrap();
        assert!(!index.agrees(&beside, &-Vector2::x(), &nearest));
    }
}
