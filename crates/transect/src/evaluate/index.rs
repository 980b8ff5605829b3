//! The curve units of one plane in a spatial index.
//!
//! Samples are looked up in groups of neighbours. One search around the group finds the units that
//! matter to any of its samples; each sample then goes through these few units.

use super::sample::{PlacedUnit, Sample, placed_units};
use std::ops::Range;
use transect_geometry::{Curve, Envelope, Point2, Vector2};

/// Entries of a box. Chosen by hand. Doubled, more units are looked at, and fewer boxes; the
/// figures stay the same.
const SPAN: usize = 8;

/// Units count as equally near if their distances differ by less than this share. Chosen by hand:
/// rounding at the common end of two units stays far below it. Doubled or halved, it still does.
const EQUALLY_NEAR: f64 = 1e-9;

/// Factor on the radius of a search, against rounding. Chosen by hand: far above rounding. Doubled,
/// more units are looked at, with equal results.
const WIDER: f64 = 1.001;

/// A unit in the index.
#[derive(Debug, Clone, Copy)]
pub(super) struct IndexedUnit {
    /// The unit and its place along its curve.
    pub placed: PlacedUnit,
    /// Which of the plane's curves it belongs to.
    pub curve: usize,
}

/// The unit nearest to a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearest {
    /// How far it is, in the coordinates' unit.
    pub distance: f64,
    /// Its direction, a unit vector.
    pub direction: Vector2,
}

/// All units with a length of some curves of one plane, and the boxes around them.
///
/// Neighbours along a curve lie close together, so boxes around eight of them in turn are as good
/// as those of a sorted tree, and need no sorting.
pub(super) struct UnitIndex {
    units: Vec<IndexedUnit>,
    /// Boxes around [`SPAN`] units, around [`SPAN`] of these boxes, and so on up to one box.
    boxes: Vec<Vec<Envelope>>,
}

impl UnitIndex {
    /// Sorts the units of the curves into boxes.
    pub fn new(curves: &[Curve]) -> Self {
        let placed = |(curve, c)| placed_units(c).map(move |placed| IndexedUnit { placed, curve });
        let units: Vec<IndexedUnit> = curves.iter().enumerate().flat_map(placed).collect();
        let around = |envelopes: &[Envelope]| {
            let all = envelopes.chunks(SPAN);
            all.filter_map(|e| e.iter().copied().reduce(|a, b| a.merged(&b))).collect::<Vec<_>>()
        };
        let own: Vec<Envelope> = units.iter().map(|u| u.placed.unit.envelope()).collect();
        let mut boxes = vec![around(&own)];
        while let Some(last) = boxes.last().filter(|last| last.len() > 1) {
            boxes.push(around(last));
        }
        Self { units, boxes }
    }

    /// The units that can be nearest to a sample of a group, or as near as the nearest one.
    pub fn nearest_to(&self, group: &[Sample]) -> Nearby {
        let found = disc(group).and_then(|(centre, radius)| {
            let distance = |u: &IndexedUnit| u.placed.squared_distance(&centre).sqrt();
            let mut units =
                self.around(&centre, distance(self.unit_near(&centre)?) + 2.0 * radius, |_| true);
            // A sample's nearest unit is at most `radius` farther from the sample than from the
            // centre.
            let nearest = units.iter().map(distance).fold(f64::INFINITY, f64::min);
            units.retain(|u| distance(u) <= WIDER * (nearest + 2.0 * radius));
            Some(Nearby(units))
        });
        found.unwrap_or(Nearby(Vec::new()))
    }

    /// The units no farther than `reach` from some sample of a group, as far as they count.
    pub fn within(
        &self,
        group: &[Sample],
        reach: f64,
        counts: impl Fn(&IndexedUnit) -> bool,
    ) -> Nearby {
        let units = disc(group).map(|(centre, r)| self.around(&centre, reach + r, counts));
        Nearby(units.unwrap_or_default())
    }

    /// A unit of the nearest box of the nearest box; mostly, it is about as near as any.
    fn unit_near(&self, centre: &Point2) -> Option<&IndexedUnit> {
        let mut nearest = 0;
        for boxes in self.boxes.iter().rev() {
            let inner = children(nearest, boxes.len());
            nearest = least(inner, |k| squared_distance(&boxes[k], centre))?;
        }
        let inner = children(nearest, self.units.len());
        self.units.get(least(inner, |k| self.units[k].placed.squared_distance(centre))?)
    }

    fn around(
        &self,
        centre: &Point2,
        reach: f64,
        counts: impl Fn(&IndexedUnit) -> bool,
    ) -> Vec<IndexedUnit> {
        let reach = WIDER * reach;
        let is_near = |squared: f64| squared <= reach * reach;
        let (mut open, mut found) = (Vec::new(), Vec::new());
        open.push((self.boxes.len(), 0));
        while let Some((level, parent)) = open.pop() {
            if let Some(below) = level.checked_sub(1) {
                let boxes = &self.boxes[below];
                let near = children(parent, boxes.len())
                    .filter(|k| is_near(squared_distance(&boxes[*k], centre)));
                open.extend(near.map(|k| (below, k)));
            } else {
                let units = &self.units[children(parent, self.units.len())];
                let near =
                    |u: &&IndexedUnit| counts(u) && is_near(u.placed.squared_distance(centre));
                found.extend(units.iter().filter(near));
            }
        }
        found
    }
}

/// The entries of a box among a number of them.
fn children(parent: usize, count: usize) -> Range<usize> {
    (SPAN * parent).min(count)..(SPAN * (parent + 1)).min(count)
}

fn least(of: Range<usize>, distance: impl Fn(usize) -> f64) -> Option<usize> {
    of.min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
}

/// Squared distance of a point from a box.
fn squared_distance(around: &Envelope, p: &Point2) -> f64 {
    let beyond = |low: f64, high: f64, at: f64| (low - at).max(at - high).max(0.0);
    let x = beyond(around.min.x, around.max.x, p.x);
    let y = beyond(around.min.y, around.max.y, p.y);
    x * x + y * y
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
    /// The unit nearest to a sample, any one of those equally near; `None` if there is no unit.
    pub fn nearest(&self, p: &Point2) -> Option<Nearest> {
        let placed = self.0.iter().map(|u| (u.placed.squared_distance(p), u));
        let (squared, found) = placed.reduce(|a, b| if b.0 < a.0 { b } else { a })?;
        Some(Nearest { distance: squared.sqrt(), direction: found.placed.direction })
    }

    /// Whether some unit is nearer to a sample than `reach`. It becomes the first one, as it mostly
    /// is near to the next sample, too.
    pub fn reaches(&mut self, p: &Point2, reach: f64) -> bool {
        let found = self.0.iter().position(|u| u.placed.squared_distance(p) < reach * reach);
        found.inspect(|k| self.0.swap(0, *k)).is_some()
    }

    /// Whether a direction agrees with a unit that is as near to a sample as the nearest one.
    pub fn agrees(&self, p: &Point2, direction: &Vector2, nearest: &Nearest) -> bool {
        // Most samples have one nearest unit and need no second look.
        direction.dot(&nearest.direction) > 0.0 || {
            let reach = nearest.distance * (1.0 + EQUALLY_NEAR);
            self.within(p, reach).any(|u| direction.dot(&u.placed.direction) > 0.0)
        }
    }

    /// The units no farther than `reach` from a sample.
    pub fn within(&self, p: &Point2, reach: f64) -> impl Iterator<Item = &IndexedUnit> {
        self.0.iter().filter(move |u| u.placed.squared_distance(p) <= reach * reach)
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
            let nearby = UnitIndex::new(&curves).within(&group, reach, |_| true);
            for p in group.iter().map(|sample| sample.position) {
                let near = |c: &Curve| c.units().filter(|u| u.distance(&p) <= reach).count();
                let all = curves.iter().map(near).sum::<usize>();
                prop_assert_eq!(nearby.within(&p, reach).count(), all);
            }
        }
    }

    /// The nearest point of these boxes is a corner.
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
