//! Inside, outside or unknown: the side of the model's curves on which a point lies.
//!
//! The idea (dissertation 2.5.2 and 3.7): a curve has its solid on the left, so the nearest piece
//! of curve tells the side of a point. This needs neither closed curves nor counts of crossings,
//! which gaps would falsify.
//!
//! 1. Find the nearest foot among all curve units of the plane, through an R-tree.
//! 2. Take the side at that foot ([`Curve::side_at`]; at a corner both adjoining units decide).
//! 3. Unknown where the foot is an open end and the point lies beyond it, or there is no curve.
//! 4. Between two planes both must exist and agree.
//!
//! Departures from the source: 2.5.2 gives the sign of one unit's line. It does not say which unit
//! decides, nor what happens at ends and between planes; steps 1, 3 and 4 are ours. Where several
//! equally near feet disagree the point is unknown, so the order of curves has no effect.
//!
//! **Limits of an answer.** The ground between a point and its nearest curve may be unseen and may
//! hide a surface that would change the answer. `Inside` and `Outside` are therefore statements
//! about the nearest *observed* surface. The answer has the distance to it, so that a caller can
//! set a limit. Views of a store tell more: `transect::correct_by_free_space` finds the points that
//! they looked through. Where all curves of a plane are closed and do not cross, the answer is that
//! of the winding number. At a corner with a repeated node, one of the two units decides alone.
//!
//! Cost: building an index O(n log n) for n units, a question O(log n) on average; without an index
//! O(n). Do not use it for points within rounding of a curve, which count as inside.

use crate::{InTree, Model, PlaneSelection, Section};
use rstar::RTree;
use std::collections::BTreeMap;
use transect_geometry::{Curve, CurveUnit, Foot, PlaneFamily, PlaneIndex, Point2, Point3, Side};

/// The place of a point with respect to the solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Location {
    /// In the solid, by the nearest observed surface; a point on a curve is inside.
    Inside,
    /// In free space, by the nearest observed surface.
    Outside,
    /// Neither is known.
    Unknown,
}

impl From<Side> for Location {
    fn from(side: Side) -> Self {
        match side {
            Side::Inside => Self::Inside,
            Side::Outside => Self::Outside,
        }
    }
}

/// The answer of one plane about a point.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PlaneAnswer {
    /// Where the point is.
    pub location: Location,
    /// Distance to the curve that decided, in the model's length unit; `None` if there is no curve.
    pub distance_to_nearest_curve: Option<f64>,
}

impl PlaneAnswer {
    const NOTHING: Self = Self { location: Location::Unknown, distance_to_nearest_curve: None };
}

/// The answer of the planes around a point.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SpaceAnswer {
    /// Where the point is.
    pub location: Location,
    /// Distance in space to the nearest curve on these planes, in the model's length unit; `None`
    /// if they have no curves. The surface between the planes may be nearer.
    pub distance_to_nearest_curve: Option<f64>,
    /// The answers of these planes, in order of station: the plane through the point, or those of
    /// its two neighbours that have curves.
    pub planes: Vec<(PlaneIndex, PlaneAnswer)>,
}

/// Locates a point by trying every curve of a section: simple, and slow for many points.
pub fn locate_in_plane(section: &Section, p: &Point2) -> PlaneAnswer {
    let feet: Vec<_> = section.curves().map(|curve| (curve, curve.foot(p))).collect();
    let nearest = feet.iter().map(|(_, foot)| foot.distance).fold(f64::INFINITY, f64::min);
    let nearest_feet = feet.into_iter().filter(|(_, foot)| foot.distance <= nearest);
    answer(nearest, nearest_feet, p)
}

/// The common answer of equally near feet; unknown if they disagree, or all are open ends.
fn answer<'a>(
    distance: f64,
    feet: impl Iterator<Item = (&'a Curve, Foot)>,
    p: &Point2,
) -> PlaneAnswer {
    if !distance.is_finite() {
        return PlaneAnswer::NOTHING;
    }
    let mut sides = feet.filter_map(|(curve, foot)| curve.side_at(&foot, p));
    let location = match sides.next() {
        Some(side) if sides.all(|other| other == side) => side.into(),
        _ => Location::Unknown,
    };
    PlaneAnswer { location, distance_to_nearest_curve: Some(distance) }
}

/// A curve unit in the tree, with its place in the section.
#[derive(Debug, Clone, Copy)]
struct IndexedUnit {
    unit: CurveUnit,
    curve: usize,
    index: usize,
}

impl AsRef<CurveUnit> for IndexedUnit {
    fn as_ref(&self) -> &CurveUnit {
        &self.unit
    }
}

/// Relative rounding error of the distances in the tree. It compares squares and distances to
/// boxes, both rounded, so that another unit may be nearer by a few units in the last place. Chosen
/// by hand, far above rounding. Doubled, a few more units are compared.
const TREE_ROUNDING: f64 = 1e-12;

/// The curve units of one section in a spatial index, for many points.
#[derive(Debug, Clone)]
pub struct SectionIndex {
    section: Section,
    tree: RTree<InTree<IndexedUnit>>,
}

impl SectionIndex {
    /// Indexes the units of a section.
    pub fn new(section: Section) -> Self {
        let units = section.curves().enumerate().flat_map(|(curve, c)| {
            let indexed = move |(index, unit)| InTree(IndexedUnit { unit, curve, index });
            c.units().enumerate().map(indexed)
        });
        let tree = RTree::bulk_load(units.collect());
        Self { section, tree }
    }

    /// The indexed section.
    pub fn section(&self) -> &Section {
        &self.section
    }

    /// The same answer as [`locate_in_plane`], without trying every curve.
    pub fn locate(&self, p: &Point2) -> PlaneAnswer {
        if !(p.x.is_finite() && p.y.is_finite()) {
            return PlaneAnswer::NOTHING;
        }
        let mut by_distance = self.tree.nearest_neighbor_iter([p.x, p.y]);
        let Some(first) = by_distance.next() else {
            return PlaneAnswer::NOTHING;
        };
        let reach = first.unit.distance(p) * (1.0 + TREE_ROUNDING);
        let others = by_distance.take_while(|u| u.unit.distance(p) <= reach);
        let near: Vec<_> = std::iter::once(first).chain(others).collect();
        self.answer_of(&near, p)
    }

    /// The answer of the nearest among some units.
    fn answer_of(&self, near: &[&InTree<IndexedUnit>], p: &Point2) -> PlaneAnswer {
        let nearest = near.iter().map(|u| u.unit.distance(p)).fold(f64::INFINITY, f64::min);
        // The first nearest foot of each curve decides, as in `Curve::foot`.
        let mut first_units = BTreeMap::new();
        for unit in near.iter().filter(|u| u.unit.distance(p) <= nearest) {
            let known = first_units.entry(unit.curve).or_insert(unit);
            if unit.index < known.index {
                *known = unit;
            }
        }
        let curves = self.section.curve_records();
        let feet = first_units
            .into_values()
            .filter_map(|u| Some((curves.get(u.curve)?.curve(), foot_on(u, p))));
        answer(nearest, feet, p)
    }
}

fn foot_on(indexed: &IndexedUnit, p: &Point2) -> Foot {
    let parameter = indexed.unit.parameter(p).clamp(0.0, 1.0);
    let point = indexed.unit.at(parameter);
    Foot { unit: indexed.index, parameter, point, distance: (p - point).norm() }
}

/// All sections of a model in spatial indices, for many points in space.
#[derive(Debug, Clone)]
pub struct ModelIndex {
    planes: PlaneFamily,
    selection: PlaneSelection,
    sections: BTreeMap<PlaneIndex, SectionIndex>,
}

impl ModelIndex {
    /// Indexes every section of a model.
    pub fn new(model: &Model) -> Self {
        let sections = model.sections().map(|(k, section)| (k, SectionIndex::new(section.clone())));
        let (planes, selection) = (model.planes().clone(), model.selection().clone());
        Self { planes, selection, sections: sections.collect() }
    }

    /// The same answer as [`Model::locate`], without trying every curve.
    pub fn locate(&self, in_world: &Point3) -> SpaceAnswer {
        let around = planes_around(&self.planes, &self.selection, in_world);
        let ask = |k, p: &Point2| Some(self.sections.get(&k)?.locate(p));
        locate_between(&self.planes, &around, in_world, ask)
    }
}

impl Model {
    /// Locates a world point, from the plane through it or the two planes around it.
    ///
    /// A point between neighbouring selected planes is projected onto both. Its location is known
    /// if both have curves and agree; so features thinner than the interval are unknown, not
    /// guessed. Tries every curve of those planes; for many points build a [`ModelIndex`].
    pub fn locate(&self, in_world: &Point3) -> SpaceAnswer {
        let around = planes_around(self.planes(), self.selection(), in_world);
        let ask = |k, p: &Point2| Some(locate_in_plane(self.section(k)?, p));
        locate_between(self.planes(), &around, in_world, ask)
    }
}

pub(crate) fn locate_between(
    planes: &PlaneFamily,
    around: &[PlaneIndex],
    in_world: &Point3,
    ask: impl Fn(PlaneIndex, &Point2) -> Option<PlaneAnswer>,
) -> SpaceAnswer {
    let said = |k: &PlaneIndex| {
        let in_plane = planes.frame(*k).plane_from_world(in_world);
        Some((*k, ask(*k, &in_plane)?))
    };
    let answers: Vec<_> = around.iter().filter_map(said).collect();
    let location = match answers.first() {
        Some((_, first)) if answers.len() == around.len() => {
            let agree = answers.iter().all(|(_, answer)| answer.location == first.location);
            if agree { first.location } else { Location::Unknown }
        }
        _ => Location::Unknown,
    };
    let distances = answers.iter().filter_map(|(k, answer)| {
        let height = planes.frame(*k).height(in_world);
        Some(answer.distance_to_nearest_curve?.hypot(height))
    });
    let distance_to_nearest_curve = distances.reduce(f64::min);
    SpaceAnswer { location, distance_to_nearest_curve, planes: answers }
}

/// The selected plane through a point, or the two around it; empty if the point has no station.
pub(crate) fn planes_around(
    planes: &PlaneFamily,
    selection: &PlaneSelection,
    in_world: &Point3,
) -> Vec<PlaneIndex> {
    let level = planes.level(in_world);
    let rounding = planes.rounding(in_world.coords.norm());
    // From here on `f64` holds no fractions: a level cannot lie between planes.
    const LARGEST_LEVEL: f64 = 4.5e15;
    let between_planes = level.abs() < LARGEST_LEVEL;
    if !between_planes {
        return Vec::new();
    }
    if (level - level.round()).abs() <= rounding {
        let plane = PlaneIndex(level.round() as i64);
        return if selection.contains(plane) { vec![plane] } else { selection.around(plane) };
    }
    selection.around(PlaneIndex(level.floor() as i64))
}

#[cfg(test)]
mod tests;
