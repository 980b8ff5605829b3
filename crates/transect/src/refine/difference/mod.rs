//! The difference between the curves of two neighbouring planes.
//!
//! Both planes are compared in plane coordinates. For samples of each plane's curves, the nearest
//! curve of the other plane with the same direction is found. A sample is far if the distance
//! exceeds the tolerance plus three standard deviations. A stretch of far samples counts if it is
//! longer than a few footprints, so that noise and ragged ends do not count.

use rstar::RTree;
use serde::Serialize;
use transect_geometry::{Curve, CurveUnit, Node};
use transect_model::InTree;

/// The kind of difference between the curves of two neighbouring planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum DifferenceReason {
    /// Curves of one plane lie beside those of the other.
    CurvesMove,
    /// The upper plane has a curve without counterpart on the lower one.
    CurveAppears,
    /// The lower plane has a curve without counterpart on the upper one.
    CurveVanishes,
    /// Curves continue beyond the open ends of their counterparts.
    EndsShift,
    /// Neither plane has curves, but planes between them do.
    CurvesBetween,
}

/// The difference between the curves of two planes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Difference {
    pub reason: DifferenceReason,
    /// Largest distance; `None` if the other plane has no curves.
    pub distance: Option<f64>,
    /// Length of the far stretches on both planes.
    pub length: f64,
}

/// Standard deviations within which a distance may be noise. Theory: three cover 99.7 %. Doubled,
/// small differences are missed; halved, noise asks for planes.
const SIGMAS: f64 = 3.0;

/// Length in footprints that a stretch must exceed. Chosen by hand: the shortest curve that fusion
/// keeps. Doubled, short details are missed; halved, ragged ends ask for planes.
const FOOTPRINTS: f64 = 4.0;

/// Largest number of samples of one curve unit. Chosen by hand, against tolerances in the wrong
/// unit.
const SAMPLES_PER_UNIT: f64 = 256.0;

/// Whether a curve is long enough to ask for a plane.
pub(super) fn worth_a_plane(curve: &Curve) -> bool {
    let footprint = curve.nodes().iter().map(|n| f64::from(n.footprint)).fold(0.0, f64::max);
    curve.length() > FOOTPRINTS * footprint
}

/// The difference between two neighbouring planes; `None` if it is within the tolerance.
pub(super) fn difference(lower: &[Curve], upper: &[Curve], tolerance: f64) -> Option<Difference> {
    let (below, above) = (Units::new(lower), Units::new(upper));
    let walk = |curves: &[Curve], other: &Units| -> Vec<Walked> {
        curves.iter().map(|curve| Walked::along(curve, other, tolerance)).collect()
    };
    let (up, down) = (walk(lower, &above), walk(upper, &below));
    let far = || up.iter().chain(&down).filter(|walked| walked.far > 0.0);
    let length: f64 = far().map(|walked| walked.far).sum();
    far().next()?;
    let alone = |own: &[Walked], others: &[Walked]| -> f64 {
        let alone = |(k, w): &(usize, &Walked)| w.far > 0.0 && w.is_alone(*k, others);
        own.iter().enumerate().filter(alone).map(|(_, walked)| walked.far).sum()
    };
    let (vanished, appeared) = (alone(&up, &down), alone(&down, &up));
    let reason = if vanished.max(appeared) > 0.0 {
        let more_vanished = vanished > appeared;
        if more_vanished { DifferenceReason::CurveVanishes } else { DifferenceReason::CurveAppears }
    } else if far().all(|walked| walked.only_beyond_ends) {
        DifferenceReason::EndsShift
    } else {
        DifferenceReason::CurvesMove
    };
    let distance = far().map(|walked| walked.distance).fold(0.0, f64::max);
    Some(Difference { reason, distance: distance.is_finite().then_some(distance), length })
}

/// The result of a walk along one curve, compared with the other plane.
struct Walked {
    /// Length of the far stretches that count.
    far: f64,
    /// Largest distance on them; infinite if the other plane has no curves.
    distance: f64,
    /// Whether every sample of them lies beyond an open end.
    only_beyond_ends: bool,
    /// Whether at least one sample is near.
    touches: bool,
    /// Which of the other plane's curves is nearest for most of its length.
    counterpart: Option<usize>,
}

/// A sample of a curve, with the length of its part of the curve.
struct Sample {
    length: f64,
    footprint: f64,
    far: bool,
    nearest: Option<Nearest>,
}

/// The other plane's unit that is nearest to a sample and runs the same way.
struct Nearest {
    distance: f64,
    /// The unit's curve.
    curve: usize,
    /// Standard deviation at the unit.
    sigma: f64,
    /// Whether the sample lies beyond the open end of that curve.
    beyond_end: bool,
}

impl Walked {
    fn along(curve: &Curve, other: &Units, tolerance: f64) -> Self {
        let mut samples = samples(curve, other, tolerance);
        let near = samples.iter().position(|sample| !sample.far);
        if let (Some(near), true) = (near, curve.is_closed()) {
            // A closed curve starts at a near sample, so that no stretch spans the start.
            samples.rotate_left(near);
        }
        let counts = |stretch: &&[Sample]| {
            let footprint = stretch.iter().map(|s| s.footprint).fold(0.0, f64::max);
            let length: f64 = stretch.iter().map(|s| s.length).sum();
            stretch.iter().all(|s| s.far) && length > FOOTPRINTS * footprint
        };
        let stretches = samples.chunk_by(|a, b| a.far == b.far).filter(counts);
        let counted: Vec<&Sample> = stretches.flatten().collect();
        let distance = |s: &&Sample| s.nearest.as_ref().map_or(f64::INFINITY, |n| n.distance);
        Self {
            far: counted.iter().map(|s| s.length).sum(),
            distance: counted.iter().map(distance).fold(0.0, f64::max),
            only_beyond_ends: counted
                .iter()
                .all(|s| s.nearest.as_ref().is_some_and(|n| n.beyond_end)),
            touches: near.is_some(),
            counterpart: counterpart(&samples),
        }
    }

    /// Whether curve `k` has no counterpart: no sample of it is near, and no other curve is its
    /// nearest one both ways.
    fn is_alone(&self, k: usize, others: &[Self]) -> bool {
        let other = self.counterpart.and_then(|other| others.get(other));
        !self.touches && other.is_none_or(|other| other.counterpart != Some(k))
    }
}

/// The curve that is nearest for the largest part of the samples' length; the first of equals.
fn counterpart(samples: &[Sample]) -> Option<usize> {
    let mut lengths = std::collections::BTreeMap::new();
    for sample in samples {
        if let Some(nearest) = &sample.nearest {
            *lengths.entry(nearest.curve).or_insert(0.0) += sample.length;
        }
    }
    let longest = lengths.values().copied().fold(0.0, f64::max);
    lengths.into_iter().find(|(_, length)| *length >= longest).map(|(curve, _)| curve)
}

fn samples(curve: &Curve, other: &Units, tolerance: f64) -> Vec<Sample> {
    let mut samples = Vec::new();
    for (unit, node) in curve.units().zip(curve.nodes()) {
        let (length, footprint) = (unit.vector().norm(), f64::from(node.footprint));
        let parts = (length / footprint.max(tolerance)).ceil().clamp(1.0, SAMPLES_PER_UNIT);
        for part in 0..parts as usize {
            let nearest = other.nearest(&unit, (part as f64 + 0.5) / parts);
            let far = nearest.as_ref().is_none_or(|nearest| {
                let sigma = nearest.sigma.hypot(f64::from(node.sigma));
                nearest.distance > tolerance + SIGMAS * sigma
            });
            samples.push(Sample { length: length / parts, footprint, far, nearest });
        }
    }
    samples
}

/// A unit of the other plane's curves.
#[derive(Debug, Clone, Copy)]
struct IndexedUnit {
    unit: CurveUnit,
    curve: usize,
    sigma: f64,
    /// Whether an open curve begins here, and whether it ends here.
    ends: [bool; 2],
}

impl AsRef<CurveUnit> for IndexedUnit {
    fn as_ref(&self) -> &CurveUnit {
        &self.unit
    }
}

/// All units of a plane's curves.
struct Units {
    tree: RTree<InTree<IndexedUnit>>,
}

impl Units {
    fn new(curves: &[Curve]) -> Self {
        let units = curves.iter().enumerate().flat_map(|(curve, c)| {
            let (last, open) = (c.units().len() - 1, !c.is_closed());
            let of = move |(k, (unit, node)): (usize, (CurveUnit, &Node))| {
                let ends = [open && k == 0, open && k == last];
                InTree(IndexedUnit { unit, curve, sigma: f64::from(node.sigma), ends })
            };
            c.units().zip(c.nodes()).enumerate().map(of)
        });
        Self { tree: RTree::bulk_load(units.collect()) }
    }

    /// The unit nearest to a place on `own` that runs the same way.
    fn nearest(&self, own: &CurveUnit, parameter: f64) -> Option<Nearest> {
        let (p, direction) = (own.at(parameter), own.vector());
        let mut by_distance = self.tree.nearest_neighbor_iter_with_distance_2(p.into());
        let (found, squared) =
            by_distance.find(|(found, _)| found.unit.vector().dot(&direction) > 0.0)?;
        let t = found.unit.parameter(&p);
        let beyond_end = (found.ends[0] && t < 0.0) || (found.ends[1] && t > 1.0);
        let (distance, curve, sigma) = (squared.sqrt(), found.curve, found.sigma);
        Some(Nearest { distance, curve, sigma, beyond_end })
    }
}

#[cfg(test)]
mod tests;
