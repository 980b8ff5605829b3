//! Refinement: more planes where the surface changes from one plane to the next.
//!
//! Problem: an interval that keeps all details of a surface makes more planes than most of the
//! surface needs. "When the object surface changes greatly, surface details can be preserved by
//! decreasing the interval of the planes" (dissertation, 2.3.6; also 2.4.1), which does not say
//! where.
//!
//! Idea: bisection. Where the curves of two neighbouring planes differ by more than a tolerance,
//! the plane in the middle is selected too, and so on down to a smallest interval. Planes are fused
//! independent of each other, so the result on a plane does not depend on the selection of others.
//!
//! 1. The family of planes has the smallest interval: the interval of the setup, halved `levels`
//!    times. Views are modelled once, on all planes of the family. That costs far less than fusing
//!    them.
//! 2. The planes of the setup's interval are fused, and one more on either side of the seen ones.
//! 3. Every two neighbouring planes are compared (`difference`).
//! 4. Where two planes differ, the plane in the middle is fused and makes two new pairs, for which
//!    steps 3 and 4 are repeated. Pairs at the smallest interval are listed in the report.
//!
//! Departure from the dissertation: there one interval is chosen for the whole model, by hand.
//!
//! Cost: modelling on the smallest interval, whose crossings are all kept until the end. Then
//! fusing the selected planes, and for each pair with n nodes a comparison in O(n log n).
//!
//! Limits: a detail that lies wholly between two planes that agree is missed, except where both
//! planes are empty. Where a surface lies across the guide, such as the top of a table, planes are
//! inserted down to the smallest interval. Its curves come and go at any interval. The same happens
//! where the seen ground ends.

mod difference;

use crate::fused::{Fused, Observed};
use crate::packed::PackedCurves;
use crate::{ReconstructError, Refinement};
pub use difference::DifferenceReason;
use difference::{Difference, difference, worth_a_plane};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use transect_geometry::{PlaneFamily, PlaneIndex};

/// Two neighbouring planes that differ by more than the tolerance, and the plane inserted between
/// them.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RefinedGap {
    /// The plane on its lower side, of the family with the smallest interval.
    pub from: PlaneIndex,
    /// The plane on its upper side.
    pub to: PlaneIndex,
    /// Station of the lower plane.
    pub from_station: f64,
    /// Station of the upper plane.
    pub to_station: f64,
    /// The kind of difference.
    pub reason: DifferenceReason,
    /// Largest distance of a curve from the other plane's curves; `None` if that plane has none.
    pub distance: Option<f64>,
    /// Length of curve, of both planes together, that is farther than the tolerance from the
    /// other's.
    pub length: f64,
    /// The inserted plane; `None` where the smallest interval is reached.
    pub inserted: Option<PlaneIndex>,
}

/// The result of refinement. Lengths are in the model's length unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RefinementReport {
    /// Largest accepted distance between curves of neighbouring planes.
    pub tolerance: f64,
    /// The smallest interval.
    pub least_interval: f64,
    /// Number of selected planes.
    pub planes: usize,
    /// Number of inserted planes among them.
    pub planes_inserted: usize,
    /// Pairs of neighbouring planes in the result that still differ by more than the tolerance.
    pub intervals_above_tolerance: usize,
    /// Every pair of neighbours that differed, in order of station; of pairs that begin at one
    /// plane the widest first.
    pub gaps: Vec<RefinedGap>,
}

/// The selected planes, fused.
pub(crate) struct Refined {
    pub fused: Vec<Fused>,
    pub selected: BTreeSet<PlaneIndex>,
    pub report: RefinementReport,
}

type Pair = (PlaneIndex, PlaneIndex);

/// Fuses the planes that refinement selects; `fuse` skips planes without curves.
pub(crate) fn refine(
    refinement: &Refinement,
    planes: &PlaneFamily,
    observed: &Observed,
    fuse: impl Fn(&[PlaneIndex]) -> Result<Vec<Fused>, ReconstructError>,
) -> Result<Refined, ReconstructError> {
    let mut selected = refinement.first_planes(planes, observed);
    let mut pairs: Vec<Pair> =
        selected.iter().copied().zip(selected.iter().copied().skip(1)).collect();
    let mut asked: Vec<PlaneIndex> = selected.iter().copied().collect();
    let (mut fused, mut gaps, coarse) = (BTreeMap::new(), Vec::new(), selected.len());
    while !asked.is_empty() {
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
    /// The planes of the setup's interval around the seen ones, with one more on either side. Long
    /// stretches without curves have no planes.
    fn first_planes(&self, planes: &PlaneFamily, observed: &Observed) -> BTreeSet<PlaneIndex> {
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
        observed: &Observed,
    ) -> Option<Difference> {
        let curves = |k| fused.get(&k).map_or(&[][..], |found: &Fused| &found.plane.curves);
        let (lower, upper) = (curves(from), curves(to));
        if !(lower.is_empty() && upper.is_empty()) {
            return difference(lower, upper, self.tolerance());
        }
        // Both planes are empty, but a surface may begin and end between them.
        let between = observed.range(PlaneIndex(from.0 + 1)..to).flat_map(|(_, views)| views);
        let curves = between.flat_map(PackedCurves::curves).filter(worth_a_plane);
        let length = curves.map(|curve| curve.length()).reduce(f64::max)?;
        Some(Difference { reason: DifferenceReason::CurvesBetween, distance: None, length })
    }
}

#[cfg(test)]
mod tests;
