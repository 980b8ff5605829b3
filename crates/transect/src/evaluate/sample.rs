//! Even samples along curves.

use transect_geometry::{Curve, CurveUnit, Point2, Vector2};

/// A curve unit that has a length, with its place along its curve; lengths in the model's unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlacedUnit {
    /// The unit.
    pub unit: CurveUnit,
    /// Its length, greater than zero.
    pub length: f64,
    /// Unit vector from start to end.
    pub direction: Vector2,
    /// Length of the curve before it.
    pub before: f64,
}

impl PlacedUnit {
    /// Squared distance of a point from the unit.
    #[inline]
    pub fn squared_distance(&self, p: &Point2) -> f64 {
        let from_start = p - self.unit.start;
        let along = self.direction.dot(&from_start).max(0.0).min(self.length);
        (from_start - self.direction * along).norm_squared()
    }
}

/// The units of a curve in order; units without length have no direction and are left out.
pub(super) fn placed_units(curve: &Curve) -> impl Iterator<Item = PlacedUnit> + '_ {
    let placed = curve.units().scan(0.0, |along, unit| {
        let (before, length) = (*along, unit.vector().norm());
        *along += length;
        Some(PlacedUnit { unit, length, direction: unit.vector() / length, before })
    });
    placed.filter(|placed| placed.length > 0.0)
}

/// The midpoint of a short part of a curve unit; lengths in the model's unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    /// Where it is, in plane coordinates.
    pub position: Point2,
    /// Direction of the curve, a unit vector.
    pub direction: Vector2,
    /// Length of the part it stands for.
    pub length: f64,
    /// Length of the curve before it.
    pub along: f64,
}

/// Most samples of a group. Chosen by hand. Doubled, each sample goes through more units; halved,
/// there are twice as many searches. The figures stay the same.
pub(super) const GROUP: usize = 32;

/// Most samples that are held at once. Chosen by hand: a few hundred kilobytes, and many groups.
/// Doubled, so is the memory; the figures stay the same.
const RUN: usize = 128 * GROUP;

/// The samples of a curve in order, in runs of neighbours.
pub(super) fn runs(curve: &Curve, step: f64) -> impl Iterator<Item = Vec<Sample>> + '_ {
    let mut samples = samples(curve, step);
    std::iter::from_fn(move || {
        let run: Vec<Sample> = samples.by_ref().take(RUN).collect();
        (!run.is_empty()).then_some(run)
    })
}

/// Samples of a curve in order: every unit in equal parts of at most `step`.
fn samples(curve: &Curve, step: f64) -> impl Iterator<Item = Sample> + '_ {
    placed_units(curve).flat_map(move |placed| {
        let parts = (placed.length / step).ceil().max(1.0);
        let (direction, length) = (placed.direction, placed.length / parts);
        (0..parts as u64).map(move |i| {
            let t = (i as f64 + 0.5) / parts;
            let (position, along) = (placed.unit.at(t), placed.before + placed.length * t);
            Sample { position, direction, length, along }
        })
    })
}
