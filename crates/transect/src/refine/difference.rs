//! By how much the curves of two neighbouring planes differ.
//!
//! Both are laid into one plane. Samples of each plane's curves look for the nearest curve of the other that runs the
//! same way. A sample is far if that is beyond the tolerance and three standard deviations of both; a stretch of far
//! samples counts if it is longer than a few footprints, so that neither noise nor ragged ends count.

use rstar::RTree;
use serde::Serialize;
use transect_geometry::{Curve, CurveUnit, Node};
use transect_model::InTree;

/// In which way the curves of two neighbouring planes differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum DifferenceReason {
    /// Curves of one lie beside those of the other.
    CurvesMove,
    /// The upper plane has a curve without counterpart on the lower one.
    CurveAppears,
    /// The lower plane has a curve without counterpart on the upper one.
    CurveVanishes,
    /// Curves go on beyond the open ends of their counterparts.
    EndsShift,
    /// Neither plane has curves, but planes between them do.
    CurvesBetween,
}

/// How the curves of two planes differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Difference {
    pub reason: DifferenceReason,
    /// Largest distance; `None` if there is nothing to be far from.
    pub distance: Option<f64>,
    /// Length of all that is far, of both planes.
    pub length: f64,
}

/// Standard deviations of both nodes within which a distance may be noise.
const SIGMAS: f64 = 3.0;

/// Footprints that a stretch has to be longer than.
const FOOTPRINTS: f64 = 4.0;

/// Most samples of one curve unit, whatever the tolerance.
const SAMPLES_PER_UNIT: f64 = 256.0;

/// Whether a curve is long enough to be no accident.
pub(super) fn worth_a_plane(curve: &Curve) -> bool {
    let footprint = curve.nodes().iter().map(|n| f64::from(n.footprint)).fold(0.0, f64::max);
    curve.length() > FOOTPRINTS * footprint
}

/// How the curves of two neighbouring planes differ; `None` if by no more than the tolerance.
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

/// What a walk along one curve found on the other plane.
struct Walked {
    /// Length of the stretches that count.
    far: f64,
    /// Largest distance on them; infinite if there is nothing to be far from.
    distance: f64,
    /// Whether every sample of them lies beyond an open end.
    only_beyond_ends: bool,
    /// Whether some sample is not far.
    touches: bool,
    /// Which of the other plane's curves is nearest for most of its length.
    counterpart: Option<usize>,
}

/// A sample of a curve, which stands for a part of its length.
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
            // No stretch goes across where a closed curve begins.
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

    /// Whether curve `k` has no counterpart among the others: none is near, nor nearest both ways.
    fn is_alone(&self, k: usize, others: &[Self]) -> bool {
        let other = self.counterpart.and_then(|other| others.get(other));
        !self.touches && other.is_none_or(|other| other.counterpart != Some(k))
    }
}

/// The curve that is nearest for most of the samples' length; the first of several.
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
    /// Whether the curve begins and ends here, being open.
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
