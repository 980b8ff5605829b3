//! Refinement: more planes where the surface changes from one to the next.
//!
//! Problem: an interval that keeps the details of a surface everywhere makes far more planes than most of
//! the surface needs. "When the object surface changes greatly, surface details can be preserved by
//! decreasing the interval of the planes" (dissertation, 2.3.6; also 2.4.1), which leaves open where.
//!
//! Idea: bisection. Where the curves of two neighbouring planes differ by more than a tolerance, the plane in
//! the middle is asked for too, and so on down to a smallest interval. Planes are fused independent of
//! each other, so the result on a plane does not depend on which others were asked for.
//!
//! 1. The family of planes has the smallest interval, the interval asked for halved so many times. Views are
//!    modelled once, on all its planes; that costs far less than fusing them.
//! 2. The planes of the interval asked for are fused, with one beyond what was seen on either side.
//! 3. Every two neighbouring planes are compared (`difference`).
//! 4. Where they differ and a plane lies between them, the middle one is fused and makes two new pairs;
//!    steps 3 and 4 are repeated with those. Where none lies between, the report says so.
//!
//! Departures from the dissertation: it chooses one interval for the whole model, by hand.
//!
//! Cost: modelling on the smallest interval, whose crossings are all kept until the end, fusing the
//! planes that were asked for, and a comparison in O(n log n) for n nodes of each pair.
//!
//! Limits: what lies wholly between two planes that agree is not noticed, unless neither of them has any
//! curve. Where a surface lies across the guide, such as the top of a table, planes are inserted down to the
//! smallest interval, since its curves come and go however near the planes are. So they are where the
//! ground that was seen ends.

mod difference;

use crate::fused::{Fused, Observed};
use crate::{ReconstructError, Refinement};
pub use difference::DifferenceReason;
use difference::{Difference, difference, worth_a_plane};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use transect_geometry::{Curve, PlaneFamily, PlaneIndex};

/// Where neighbouring planes differ by more than the tolerance, and what was done about it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RefinedGap {
    /// The plane on its lower side, of the family with the smallest interval.
    pub from: PlaneIndex,
    /// The plane on its upper side.
    pub to: PlaneIndex,
    /// Station of the lower plane.
    pub from_station: f64,
    /// Station of the upper plane.
    pub to_station: f64,
    /// In which way they differ.
    pub reason: DifferenceReason,
    /// Largest distance of a curve from the other plane's; `None` if there is nothing to be far from.
    pub distance: Option<f64>,
    /// Length of curve, of both planes together, that is farther than the tolerance from the other's.
    pub length: f64,
    /// The plane that was inserted; `None` where the smallest interval is reached.
    pub inserted: Option<PlaneIndex>,
}

/// What refinement did. Lengths are in the model's length unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RefinementReport {
    /// How far curves of neighbouring planes may be from each other.
    pub tolerance: f64,
    /// The smallest interval.
    pub least_interval: f64,
    /// Planes that were asked for in all.
    pub planes: usize,
    /// Those of them that were inserted.
    pub planes_inserted: usize,
    /// Intervals of the result whose planes still differ by more than the tolerance.
    pub intervals_above_tolerance: usize,
    /// Every pair of neighbours that differed, in order of station; of those that begin at one plane the widest
    /// first.
    pub gaps: Vec<RefinedGap>,
}

/// The planes that were asked for.
pub(crate) struct Refined {
    pub fused: Vec<Fused>,
    pub selected: BTreeSet<PlaneIndex>,
    pub report: RefinementReport,
}

type Pair = (PlaneIndex, PlaneIndex);

/// Fuses the planes that refinement asks for; `fuse` skips those that no view has curves on.
pub(crate) fn refine(
    refinement: &Refinement,
    planes: &PlaneFamily,
    observed: &Observed<'_>,
    fuse: impl Fn(&[PlaneIndex]) -> Result<Vec<Fused>, ReconstructError>,
) -> Result<Refined, ReconstructError> {
    let mut selected = refinement.first_planes(planes, observed);
    let mut pairs: Vec<Pair> =
        selected.iter().copied().zip(selected.iter().copied().skip(1)).collect();
    let mut asked: Vec<PlaneIndex> = selected.iter().copied().collect();
    let (mut fused, mut gaps, coarse) = (BTreeMap::new(), Vec::new(), selected.len());
    while !pairs.is_empty() {
        fused.extend(fuse(&asked)?.into_iter().map(|plane| (plane.index, plane)));
        let compare = |pair: &Pair| refinement.compare(*pair, &fused, observed);
        let differences: Vec<Option<Difference>> = pairs.par_iter().map(compare).collect();
        let differing = pairs.iter().zip(differences).filter_map(|(pair, d)| Some((*pair, d?)));
        let found: Vec<RefinedGap> = differing.map(|(pair, d)| gap(planes, pair, d)).collect();
        asked = found.iter().filter_map(|gap| gap.inserted).collect();
        selected.extend(asked.iter().copied());
        let halves = |gap: &RefinedGap| Some([(gap.from, gap.inserted?), (gap.inserted?, gap.to)]);
        pairs = found.iter().filter_map(halves).flatten().collect();
        gaps.extend(found);
    }
    gaps.sort_by_key(|gap| (gap.from, std::cmp::Reverse(gap.to)));
    let report = RefinementReport {
        tolerance: refinement.tolerance(),
        least_interval: planes.interval(),
        planes: selected.len(),
        planes_inserted: selected.len() - coarse,
        intervals_above_tolerance: gaps.iter().filter(|gap| gap.inserted.is_none()).count(),
        gaps,
    };
    Ok(Refined { fused: fused.into_values().collect(), selected, report })
}

fn gap(planes: &PlaneFamily, (from, to): Pair, found: Difference) -> RefinedGap {
    let Difference { reason, distance, length } = found;
    RefinedGap {
        from,
        to,
        from_station: planes.station(from),
        to_station: planes.station(to),
        reason,
        distance,
        length,
        inserted: (to.0 - from.0 > 1).then(|| PlaneIndex(from.0 + (to.0 - from.0) / 2)),
    }
}

impl Refinement {
    /// Those planes of the interval asked for that lie around what was seen, one on either side included.
    /// Where nothing was seen for long, there are none.
    fn first_planes(&self, planes: &PlaneFamily, observed: &Observed<'_>) -> BTreeSet<PlaneIndex> {
        let step = self.planes_per_interval();
        let around = |k: &PlaneIndex| {
            let below = |k: i64| k.div_euclid(step).saturating_mul(step);
            let next = below(k.0).saturating_add(step);
            [below(k.0.saturating_sub(1)), below(k.0), next].map(PlaneIndex)
        };
        let ends = planes.ends();
        let on_guide = |k: &PlaneIndex| ends.is_none_or(|(first, last)| (first..=last).contains(k));
        observed.keys().flat_map(around).filter(on_guide).collect()
    }

    fn compare(
        &self,
        (from, to): Pair,
        fused: &BTreeMap<PlaneIndex, Fused>,
        observed: &Observed<'_>,
    ) -> Option<Difference> {
        let curves = |k| fused.get(&k).map_or(&[][..], |found: &Fused| &found.plane.curves);
        let (lower, upper) = (curves(from), curves(to));
        if !(lower.is_empty() && upper.is_empty()) {
            return difference(lower, upper, self.tolerance());
        }
        // Nothing to compare; but something may have been seen that begins and ends between them.
        let between = observed.range(PlaneIndex(from.0 + 1)..to).flat_map(|(_, views)| views);
        let lengths = between.flat_map(|curves| curves.iter()).filter(|curve| worth_a_plane(curve));
        let length = lengths.map(Curve::length).reduce(f64::max)?;
        Some(Difference { reason: DifferenceReason::CurvesBetween, distance: None, length })
    }
}

#[cfg(test)]
mod tests;
