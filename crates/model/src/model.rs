//! The root of the tree: section planes sorted by station (dissertation, section 2.5.2, Figure
//! 2.4).
//!
//! Departure from the dissertation: there plane nodes are linked both ways by pointers and carry
//! the frame of their plane. Here a sorted map gives both neighbours, and [`PlaneFamily`] the
//! frames.

use crate::{InvariantError, PlaneSelection, Section};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use transect_geometry::{
    Curve, Envelope, Isometry3, LengthUnit, PlaneFamily, PlaneIndex, crossings,
};

/// One view of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ViewRecord {
    /// Its name in reports.
    #[serde(deserialize_with = "crate::text::read")]
    pub name: String,
    /// Its origin, such as the file of its range image; for information.
    #[serde(deserialize_with = "crate::text::read")]
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

    /// Number of curves on all planes.
    pub fn curve_count(&self) -> usize {
        self.sections.values().map(|s| s.curve_records().len()).sum()
    }

    /// Number of nodes on all planes.
    pub fn node_count(&self) -> usize {
        self.sections.values().map(Section::node_count).sum()
    }

    /// Number of places where curves of a plane cross or touch each other: 0 for fused curves.
    pub fn crossing_count(&self) -> usize {
        self.sections.values().map(|section| crossings(section.curves()).len()).sum()
    }

    /// Length of all curves, in the model's length unit.
    pub fn length(&self) -> f64 {
        // A sum of nothing is -0.
        0.0 + self.sections.values().map(Section::length).sum::<f64>()
    }

    /// The rectangle around the curves of all planes, in plane coordinates; `None` without curves.
    pub fn envelope(&self) -> Option<Envelope> {
        self.sections.values().map(Section::envelope).reduce(|a, b| a.merged(&b))
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
    use crate::samples::{empty, small, strip, tangles};
    use proptest::prelude::*;

    #[test]
    fn planes_with_curves_are_selected_planes() {
        let mut model = empty();
        for k in [0, 4, 5, 8] {
            model.set_curves(PlaneIndex(k), vec![strip()]);
        }
        let mut model = model.with_selection([-4, 7].map(PlaneIndex));
        model.set_curves(PlaneIndex(2), vec![strip()]);
        let selected: Vec<i64> = model.selected().unwrap().iter().map(|k| k.0).collect();
        assert_eq!((selected, model.check()), (vec![-4, 0, 2, 4, 5, 7, 8], Ok(())));
    }

    #[test]
    fn no_curves_remove_the_section() {
        let mut model = small();
        model.set_curves(PlaneIndex(4), Vec::new());
        assert!(model.section(PlaneIndex(4)).is_none());
        assert_eq!((model.sections().len(), model.curve_count(), model.node_count()), (1, 1, 4));
        assert_eq!(model.length(), 4.0);
        model.set_curves(PlaneIndex(-1), Vec::new());
        assert_eq!((model.sections().len(), model.envelope()), (0, None));
    }

    proptest! {
        #[test]
        fn every_invariant_holds_after_every_change(
            changes in prop::collection::vec((0..4i64, prop::option::of(tangles())), 1..20),
        ) {
            let mut model = empty();
            for (plane, curves) in changes {
                model.set_curves(PlaneIndex(plane), curves.unwrap_or_default());
                prop_assert_eq!(model.check(), Ok(()));
            }
            let order: Vec<_> = model.sections().map(|(k, _)| k).collect();
            prop_assert!(order.is_sorted());
        }
    }
}
