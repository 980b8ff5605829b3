//! The figures of an evaluation.

use super::closeness::Closeness;
use super::own::Own;
use super::quantile::quantile;
use serde::Serialize;

/// Figures of the comparison of curves with the truth.
///
/// Lengths are in the model's length unit, shares from 0 to 1. Only planes from
/// [`EvaluateOptions::from`](super::EvaluateOptions::from) on count. A share is `None` where there
/// is no length to share.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Accuracy {
    /// Planes on which the truth has a curve.
    pub planes_with_truth: usize,
    /// Curves.
    pub pieces: usize,
    /// Closed ones among them.
    pub closed: usize,
    /// Open ones among them.
    pub open: usize,
    /// Nodes of the curves.
    pub vertices: usize,
    /// Curves of the truth.
    pub truth_pieces: usize,
    /// Curves to expect: stretches of the truth's curves that the views could see. Gaps shorter
    /// than the tolerance, or than four sample spacings of the plane's curves, do not end a
    /// stretch. Stretches shorter than that do not count.
    pub expected_pieces: usize,
    /// Length of the curves.
    pub length: f64,
    /// Length of the truth.
    pub truth_length: f64,
    /// Length of the curves on planes without truth. They count as infinitely far, and in `off`.
    pub length_without_truth: f64,
    /// Median distance of the curves from the truth; `None` if half of the samples are on planes
    /// without truth (the median is infinite), or if there are no samples.
    pub median: Option<f64>,
    /// Distance that 95 % of the curves' samples stay below; `None` as for the median.
    pub p95: Option<f64>,
    /// Largest distance of the curves from the truth on planes that have truth.
    pub max: Option<f64>,
    /// Share of the truth's length that the views could see; 1 if visibility is not known.
    pub truth_seen: Option<f64>,
    /// Share of the seen truth's length with a curve within the tolerance.
    pub completeness: Option<f64>,
    /// Share of the curves' length that is a tolerance or more away from the truth.
    pub off: Option<f64>,
    /// Share of the length within the tolerance whose direction agrees with the truth's.
    pub oriented: Option<f64>,
    /// Share of the curves' length that runs beside another piece, see [`Duplication`].
    pub duplicated: Option<f64>,
    /// Share of the planes with truth that have curves, and only closed ones.
    pub planes_closed_only: Option<f64>,
    /// Share of the planes with truth that have only closed curves, and as many as the truth.
    pub planes_same_loops: Option<f64>,
}

/// Figures of curves without a truth.
///
/// Lengths are in the model's length unit, shares from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Duplication {
    /// Curves.
    pub pieces: usize,
    /// Closed ones among them.
    pub closed: usize,
    /// Open ones among them.
    pub open: usize,
    /// Nodes of the curves.
    pub vertices: usize,
    /// Length of the curves.
    pub length: f64,
    /// Share of the length that runs beside another piece of the same direction (within 60°) within
    /// the tolerance; `None` without any length.
    pub duplicated: Option<f64>,
}

impl From<Own> for Duplication {
    fn from(own: Own) -> Self {
        Self {
            pieces: own.pieces,
            closed: own.closed,
            open: own.pieces - own.closed,
            vertices: own.vertices,
            length: own.length,
            duplicated: share(own.duplicated, own.length),
        }
    }
}

impl Accuracy {
    pub(super) fn new(own: Own, closeness: Closeness) -> Self {
        let Closeness { mut distances, planes, .. } = closeness;
        distances.sort_unstable_by(f64::total_cmp);
        let own = Duplication::from(own);
        Self {
            planes_with_truth: planes,
            pieces: own.pieces,
            closed: own.closed,
            open: own.open,
            vertices: own.vertices,
            truth_pieces: closeness.truth_pieces,
            expected_pieces: closeness.truth_stretches,
            length: own.length,
            truth_length: closeness.truth_length,
            length_without_truth: closeness.without_truth,
            median: quantile(&distances, 0.5),
            p95: quantile(&distances, 0.95),
            max: distances.iter().rev().copied().find(|d| d.is_finite()),
            truth_seen: share(closeness.truth_seen, closeness.truth_length),
            completeness: share(closeness.truth_found, closeness.truth_seen),
            off: share(closeness.far, closeness.near + closeness.far),
            oriented: share(closeness.oriented, closeness.near),
            duplicated: own.duplicated,
            planes_closed_only: share(closeness.planes_closed_only as f64, planes as f64),
            planes_same_loops: share(closeness.planes_same_loops as f64, planes as f64),
        }
    }
}

fn share(part: f64, whole: f64) -> Option<f64> {
    (whole > 0.0).then(|| part / whole)
}
