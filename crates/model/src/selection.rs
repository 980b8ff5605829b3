//! The selected planes of a family.
//!
//! Where refinement inserts planes, the family has the smallest interval, and most of its planes
//! are not selected. They differ from selected planes without curves. Neighbours are neighbouring
//! selected planes, however many planes of the family lie between them.

use std::collections::BTreeSet;
use std::ops::Bound::{Excluded, Unbounded};
use transect_geometry::PlaneIndex;

/// The selected planes of a family: all of them, or some.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PlaneSelection {
    /// `None` selects all.
    planes: Option<BTreeSet<PlaneIndex>>,
}

/// Distances from a plane to its neighbours, in planes of the family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Steps {
    pub before: f64,
    pub after: f64,
}

impl PlaneSelection {
    /// Every plane of the family.
    pub const ALL: Self = Self { planes: None };

    /// Some planes of the family.
    pub fn of(planes: impl IntoIterator<Item = PlaneIndex>) -> Self {
        Self { planes: Some(planes.into_iter().collect()) }
    }

    /// The planes in order; `None` if all of the family are selected.
    pub fn planes(&self) -> Option<&BTreeSet<PlaneIndex>> {
        self.planes.as_ref()
    }

    /// Whether a plane is selected.
    pub fn contains(&self, plane: PlaneIndex) -> bool {
        self.planes.as_ref().is_none_or(|planes| planes.contains(&plane))
    }

    /// The next selected plane along the guide; `None` after the last.
    pub fn next_after(&self, plane: PlaneIndex) -> Option<PlaneIndex> {
        match &self.planes {
            None => plane.0.checked_add(1).map(PlaneIndex),
            Some(planes) => planes.range((Excluded(plane), Unbounded)).next().copied(),
        }
    }

    /// The previous selected plane along the guide; `None` before the first.
    pub(crate) fn previous_before(&self, plane: PlaneIndex) -> Option<PlaneIndex> {
        match &self.planes {
            None => plane.0.checked_sub(1).map(PlaneIndex),
            Some(planes) => planes.range(..plane).next_back().copied(),
        }
    }

    /// Steps of the family from a plane to its selected neighbours, before and after it. The first
    /// and the last plane have the step of their other side.
    pub(crate) fn steps(&self, plane: PlaneIndex) -> Steps {
        let steps = |other: PlaneIndex| plane.0.abs_diff(other.0) as f64;
        let before = self.previous_before(plane).map(steps);
        let after = self.next_after(plane).map(steps);
        Steps { before: before.or(after).unwrap_or(1.0), after: after.or(before).unwrap_or(1.0) }
    }

    /// Adds a plane to the selected ones.
    pub(crate) fn insert(&mut self, plane: PlaneIndex) {
        if let Some(planes) = &mut self.planes {
            planes.insert(plane);
        }
    }

    /// The two selected planes around a place between plane `below` and the next one; empty beyond
    /// the first and the last.
    pub(crate) fn around(&self, below: PlaneIndex) -> Vec<PlaneIndex> {
        let low = if self.contains(below) { Some(below) } else { self.previous_before(below) };
        match (low, self.next_after(below)) {
            (Some(low), Some(high)) => vec![low, high],
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_planes_that_were_asked_for() {
        let some = PlaneSelection::of([-4, 0, 1, 8].map(PlaneIndex));
        assert_eq!(some.next_after(PlaneIndex(1)), Some(PlaneIndex(8)));
        assert_eq!(some.previous_before(PlaneIndex(0)), Some(PlaneIndex(-4)));
        assert_eq!(some.next_after(PlaneIndex(8)), None);
        assert!(some.contains(PlaneIndex(8)) && !some.contains(PlaneIndex(7)));
        assert_eq!(some.around(PlaneIndex(5)), [PlaneIndex(1), PlaneIndex(8)]);
        assert_eq!(some.around(PlaneIndex(0)), [PlaneIndex(0), PlaneIndex(1)]);
        assert!(some.around(PlaneIndex(8)).is_empty() && some.around(PlaneIndex(-5)).is_empty());
        assert_eq!(some.steps(PlaneIndex(1)), Steps { before: 1.0, after: 7.0 });
        assert_eq!(some.steps(PlaneIndex(8)), Steps { before: 7.0, after: 7.0 });
        let all = PlaneSelection::ALL;
        assert_eq!(all.around(PlaneIndex(5)), [PlaneIndex(5), PlaneIndex(6)]);
        assert_eq!(
            (all.steps(PlaneIndex(1)), all.next_after(PlaneIndex(i64::MAX))),
            (Steps { before: 1.0, after: 1.0 }, None)
        );
    }
}
