//! The root of the tree: section planes sorted by station (dissertation, section 2.5.2, Figure
//! 2.4).
//!
//! Departure from the dissertation: there plane nodes are linked both ways by pointers and carry
//! the frame of their plane. Here a sorted map gives both neighbours, and [`PlaneFamily`] the
//! frames.

use crate::{CurveIndex, InvariantError, PlaneSelection, Section};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Bound::{Excluded, Unbounded};
use std::ops::RangeInclusive;
use transect_geometry::{Curve, Envelope, Isometry3, LengthUnit, PlaneFamily, PlaneIndex};

/// One view of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ViewRecord {
    /// Its name in reports.
    pub name: String,
    /// Its origin, such as the file of its range image; for information.
    pub source: String,
    /// Its pose; the translation is in the model's length unit.
    pub world_from_sensor: Isometry3,
    /// Standard deviation of its range values in the model's length unit; `None` if unknown.
    pub sigma: Option<f64>,
    /// Number of nodes of its partial model, on all planes.
    pub nodes: u64,
}

/// A cross-section model: oriented curves on the planes of a family, with the solid on their left.
///
/// Guaranteed, and checked again when a file is loaded ([`Model::check`]): planes sorted by index,
/// every section with at least one curve, every envelope the tightest. All lengths are in
/// [`Model::unit`], curves in the plane coordinates of their plane's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    unit: LengthUnit,
    planes: PlaneFamily,
    selection: PlaneSelection,
    views: Vec<ViewRecord>,
    sections: BTreeMap<PlaneIndex, Section>,
}

impl Model {
    /// A model without curves or views.
    pub fn new(unit: LengthUnit, planes: PlaneFamily) -> Self {
        let selection = PlaneSelection::ALL;
        Self { unit, planes, selection, views: Vec::new(), sections: BTreeMap::new() }
    }

    /// The same model with these planes of its family, and all planes with curves, as selected
    /// planes.
    #[must_use]
    pub fn with_selection(mut self, planes: impl IntoIterator<Item = PlaneIndex>) -> Self {
        let own: Vec<PlaneIndex> = self.sections.keys().copied().collect();
        self.selection = PlaneSelection::of(planes.into_iter().chain(own));
        self
    }

    /// The unit of every length in the model.
    pub fn unit(&self) -> LengthUnit {
        self.unit
    }

    /// Where the section planes are.
    pub fn planes(&self) -> &PlaneFamily {
        &self.planes
    }

    /// The selected planes. Neighbours are neighbours among them.
    pub fn selection(&self) -> &PlaneSelection {
        &self.selection
    }

    /// The selected planes in order of station; `None` if all of the family are.
    pub fn selected(&self) -> Option<&BTreeSet<PlaneIndex>> {
        self.selection.planes()
    }

    /// The views in the order in which they were added.
    pub fn views(&self) -> &[ViewRecord] {
        &self.views
    }

    /// Records a view.
    pub fn add_view(&mut self, view: ViewRecord) {
        self.views.push(view);
    }

    /// The curves of a plane; `None` if it has none.
    pub fn section(&self, plane: PlaneIndex) -> Option<&Section> {
        self.sections.get(&plane)
    }

    /// The planes that have curves, in order of station.
    pub fn sections(
        &self,
    ) -> impl ExactSizeIterator<Item = (PlaneIndex, &Section)> + DoubleEndedIterator {
        self.sections.iter().map(|(&plane, section)| (plane, section))
    }

    /// Runs of neighbouring planes with curves, in order of station: the sub-families between gaps.
    pub fn sub_families(&self) -> Vec<RangeInclusive<PlaneIndex>> {
        let mut runs: Vec<RangeInclusive<PlaneIndex>> = Vec::new();
        for &plane in self.sections.keys() {
            let previous = self.selection.previous_before(plane);
            match runs.last_mut().filter(|run| Some(*run.end()) == previous) {
                Some(run) => *run = *run.start()..=plane,
                None => runs.push(plane..=plane),
            }
        }
        runs
    }

    /// The first plane with curves beyond `plane` along the guide, whether or not `plane` has any.
    pub fn next_after(&self, plane: PlaneIndex) -> Option<(PlaneIndex, &Section)> {
        let (&next, section) = self.sections.range((Excluded(plane), Unbounded)).next()?;
        Some((next, section))
    }

    /// The last plane with curves before `plane` along the guide, whether or not `plane` has any.
    pub fn previous_before(&self, plane: PlaneIndex) -> Option<(PlaneIndex, &Section)> {
        let (&previous, section) = self.sections.range(..plane).next_back()?;
        Some((previous, section))
    }

    /// Replaces all curves of a plane. An empty list removes its section. A plane with curves
    /// becomes a selected one.
    pub fn set_curves(&mut self, plane: PlaneIndex, curves: Vec<Curve>) {
        match Section::new(curves) {
            Some(section) => {
                self.selection.insert(plane);
                self.sections.insert(plane, section)
            }
            None => self.sections.remove(&plane),
        };
    }

    /// Appends a curve to a plane and returns its place.
    pub fn insert_curve(&mut self, plane: PlaneIndex, curve: Curve) -> CurveIndex {
        if let Some(section) = self.sections.get_mut(&plane) {
            return section.push(curve);
        }
        self.set_curves(plane, vec![curve]);
        CurveIndex(0)
    }

    /// Removes a curve from a plane; later curves of the plane move up by one place.
    pub fn remove_curve(&mut self, plane: PlaneIndex, index: CurveIndex) -> Option<Curve> {
        self.section(plane)?.curve(index)?;
        let mut curves = self.take_curves(plane);
        let removed = curves.remove(index.0);
        self.set_curves(plane, curves);
        Some(removed)
    }

    /// Number of curves on all planes.
    pub fn curve_count(&self) -> usize {
        self.sections.values().map(|s| s.curve_records().len()).sum()
    }

    /// Number of nodes on all planes.
    pub fn node_count(&self) -> usize {
        self.sections.values().map(Section::node_count).sum()
    }

    /// Length of all curves, in the model's length unit.
    pub fn length(&self) -> f64 {
        self.sections.values().map(Section::length).sum()
    }

    /// The rectangle around the curves of all planes, in plane coordinates; `None` without curves.
    pub fn envelope(&self) -> Option<Envelope> {
        self.sections.values().map(Section::envelope).reduce(|a, b| a.merged(&b))
    }

    /// Removes the curves of a plane from the tree and returns them.
    pub(crate) fn take_curves(&mut self, plane: PlaneIndex) -> Vec<Curve> {
        self.sections.remove(&plane).map(Section::into_curves).unwrap_or_default()
    }

    /// The model of unchecked parts, such as those of a file.
    ///
    /// # Errors
    /// [`InvariantError`] if the planes are not in order, or [`Model::check`] finds something.
    pub(crate) fn from_parts(
        unit: LengthUnit,
        planes: PlaneFamily,
        selected: Option<Vec<PlaneIndex>>,
        views: Vec<ViewRecord>,
        sections: Vec<(PlaneIndex, Section)>,
    ) -> Result<Self, InvariantError> {
        let mut neighbours = sections.iter().zip(sections.iter().skip(1));
        if let Some(((_, _), (plane, _))) = neighbours.find(|((a, _), (b, _))| a >= b) {
            return Err(InvariantError::PlaneOutOfOrder(*plane));
        }
        let mut pairs = selected.iter().flat_map(|planes| planes.iter().zip(planes.iter().skip(1)));
        if let Some((_, plane)) = pairs.find(|(a, b)| a >= b) {
            return Err(InvariantError::PlaneOutOfOrder(*plane));
        }
        let selection = selected.map_or(PlaneSelection::ALL, PlaneSelection::of);
        let sections = sections.into_iter().collect();
        let model = Self { unit, planes, selection, views, sections };
        model.check().map(|()| model)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{empty, rectangle, small, strip, tangles};
    use proptest::prelude::*;

    #[test]
    fn gaps_part_the_planes_into_sub_families() {
        let mut model = empty();
        assert!(model.sub_families().is_empty());
        for k in [i64::MIN, -3, -2, 5, 6, 7, i64::MAX] {
            model.set_curves(PlaneIndex(k), vec![strip()]);
        }
        let runs = |model: &Model| -> Vec<(i64, i64)> {
            model.sub_families().iter().map(|run| (run.start().0, run.end().0)).collect()
        };
        let (first, last) = (i64::MIN, i64::MAX);
        assert_eq!(runs(&model), [(first, first), (-3, -2), (5, 7), (last, last)]);
        model.set_curves(PlaneIndex(6), Vec::new());
        assert_eq!(runs(&model), [(first, first), (-3, -2), (5, 5), (7, 7), (last, last)]);
        assert_eq!(model.check(), Ok(()));
    }

    #[test]
    fn planes_that_nobody_asked_for_make_no_gap() {
        let mut model = empty();
        for k in [0, 4, 5, 8] {
            model.set_curves(PlaneIndex(k), vec![strip()]);
        }
        let mut model = model.with_selection([-4, 7].map(PlaneIndex));
        let runs: Vec<_> =
            model.sub_families().iter().map(|run| (run.start().0, run.end().0)).collect();
        assert_eq!(runs, [(0, 5), (8, 8)]);
        model.set_curves(PlaneIndex(7), vec![strip()]);
        assert_eq!(model.sub_families().len(), 1);
        model.set_curves(PlaneIndex(2), vec![strip()]);
        let selected: Vec<i64> = model.selected().unwrap().iter().map(|k| k.0).collect();
        assert_eq!((selected, model.check()), (vec![-4, 0, 2, 4, 5, 7, 8], Ok(())));
    }

    #[test]
    fn planes_are_walked_both_ways_in_order_of_station() {
        let mut model = small();
        model.set_curves(PlaneIndex(2), vec![strip()]);
        let order: Vec<_> = model.sections().map(|(k, _)| k.0).collect();
        assert_eq!(order, [-1, 2, 4]);
        assert_eq!(model.next_after(PlaneIndex(-1)).unwrap().0, PlaneIndex(2));
        assert_eq!(model.next_after(PlaneIndex(3)).unwrap().0, PlaneIndex(4));
        assert!(model.next_after(PlaneIndex(4)).is_none());
        assert_eq!(model.previous_before(PlaneIndex(4)).unwrap().0, PlaneIndex(2));
        assert!(model.previous_before(PlaneIndex(-1)).is_none());
    }

    #[test]
    fn no_curves_remove_the_section() {
        let mut model = small();
        model.set_curves(PlaneIndex(4), Vec::new());
        assert!(model.section(PlaneIndex(4)).is_none());
        assert_eq!((model.sections().len(), model.curve_count(), model.node_count()), (1, 1, 4));
        assert_eq!(model.length(), 4.0);
        model.remove_curve(PlaneIndex(-1), CurveIndex(0)).unwrap();
        assert_eq!((model.sections().len(), model.envelope()), (0, None));
    }

    #[test]
    fn a_removed_curve_is_the_one_asked_for() {
        let mut model = small();
        assert!(model.remove_curve(PlaneIndex(4), CurveIndex(2)).is_none());
        assert!(model.remove_curve(PlaneIndex(0), CurveIndex(0)).is_none());
        assert_eq!(model, small());
        assert_eq!(model.remove_curve(PlaneIndex(4), CurveIndex(1)), Some(strip()));
        assert_eq!(model.section(PlaneIndex(4)).unwrap().envelope(), {
            rectangle(0.0, 0.0, 2.0, 1.0).envelope()
        });
    }

    /// What can be done to a model.
    #[derive(Debug, Clone)]
    enum Step {
        Set(i64, Vec<Curve>),
        Insert(i64, Curve),
        Remove(i64, usize),
    }

    fn steps() -> impl Strategy<Value = Vec<Step>> {
        let one = tangles().prop_map(|mut curves| curves.swap_remove(0));
        let step = prop_oneof![
            (0..4i64, tangles()).prop_map(|(k, curves)| Step::Set(k, curves)),
            (0..4i64, one).prop_map(|(k, curve)| Step::Insert(k, curve)),
            (0..4i64, 0..6usize).prop_map(|(k, i)| Step::Remove(k, i)),
        ];
        prop::collection::vec(step, 1..20)
    }

    proptest! {
        #[test]
        fn every_invariant_holds_after_every_edit(steps in steps()) {
            let mut model = empty();
            for step in steps {
                match step {
                    Step::Set(k, curves) => model.set_curves(PlaneIndex(k), curves),
                    Step::Insert(k, curve) => _ = model.insert_curve(PlaneIndex(k), curve),
                    Step::Remove(k, i) => _ = model.remove_curve(PlaneIndex(k), CurveIndex(i)),
                }
                prop_assert_eq!(model.check(), Ok(()));
            }
        }
    }
}
