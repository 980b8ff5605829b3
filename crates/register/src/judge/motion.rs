//! The motion, or the scale, that would make one view agree with the others.
//!
//! Linear least squares of the distances between patches and surfaces (point to plane; Chen and
//! Medioni, 1992), with Tukey's biweight whose width shrinks with the median distance.
//!
//! A shift along the normal of one wall concerns the patches on that wall alone. Beside the median
//! of all they are outliers. So the motion is sought a second time. In the first half of the rounds
//! the width follows from the distances that contradict. The motion that leaves fewer
//! contradictions is taken.

use super::blame::Counts;
use super::evidence::Evidence;
use super::pair::{Placed, Placing, Sample, samples};
use super::tuning::{MOTION_REACH, MOTION_ROUNDS, REACH};
use nalgebra::{SMatrix, SVector, Translation3, UnitQuaternion};
use transect_device::{Isometry3, Vector3, median, quantile};

/// Weight that holds each direction in place, as a share of all weights. No unit. Chosen by hand:
/// far below the weight of any direction that surfaces determine. Doubled, one more round is
/// needed.
const RIDGE: f64 = 1e-3;

/// Width of the biweight, over the median distance. No unit. Theory: 4.685 standard deviations have
/// 95 % efficiency, and a median is 0.674 of one. Doubled, outliers pull the motion.
const WIDTH: f64 = 6.9;

/// Share of the distances that is usual. Theory: the median.
const MEDIAN: f64 = 0.5;

/// The properties of the view that may change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Change {
    Motion,
    Scale,
}

/// A changed view.
#[derive(Debug, Clone, Copy)]
pub(super) struct Changed {
    pub placing: Placing,
    /// The counts with the other views after the change.
    pub counts: Counts,
    /// Median distance of the patches that meet, increased by the share of contradictions.
    pub cost: f64,
}

/// The best change of a view against the views that `right` lists.
pub(super) fn best(evidence: &Evidence<'_>, view: usize, right: &[usize], of: Change) -> Changed {
    let given = compared(evidence, view, evidence.placings[view], right, REACH);
    let contradicting = evidence.count(given.iter().map(|(sample, _)| sample)).bad_share();
    // Half of the contradictions are within this share of the distances.
    let most = 1.0 - 0.5 * contradicting;
    let start = evidence.placings[view];
    let [narrow, wide] =
        [MEDIAN, most].map(|first| sought(evidence, view, start, right, of, first));
    if wide.counts.bad_share() < narrow.counts.bad_share() { wide } else { narrow }
}

/// A view at another pose than its own.
pub(super) fn moved_to(
    evidence: &Evidence<'_>,
    view: usize,
    pose: &Isometry3,
    right: &[usize],
) -> Changed {
    let placing = Placing { world_from_sensor: *pose, scale: 1.0 };
    changed(evidence, view, placing, right)
}

/// The best motion of a view that begins at another pose than its own.
pub(super) fn moved_from(
    evidence: &Evidence<'_>,
    view: usize,
    start: &Isometry3,
    right: &[usize],
) -> Changed {
    let start = Placing { world_from_sensor: *start, scale: 1.0 };
    sought(evidence, view, start, right, Change::Motion, MEDIAN)
}

/// The change that rounds with a biweight of this quantile, and then of the median, find.
fn sought(
    evidence: &Evidence<'_>,
    view: usize,
    start: Placing,
    right: &[usize],
    of: Change,
    first: f64,
) -> Changed {
    let mut placing = start;
    for round in 0..MOTION_ROUNDS {
        let rows = compared(evidence, view, placing, right, MOTION_REACH);
        let share = if round < MOTION_ROUNDS / 2 { first } else { MEDIAN };
        let Some(next) = step(&rows, placing, of, share) else { break };
        placing = next;
    }
    changed(evidence, view, placing, right)
}

/// The view at a placing, compared with the others there.
fn changed(evidence: &Evidence<'_>, view: usize, placing: Placing, right: &[usize]) -> Changed {
    let rows = compared(evidence, view, placing, right, REACH);
    let met = rows.iter().map(|(s, _)| s).filter(|s| s.met).map(|s| s.distance.abs());
    let usual = median(met).unwrap_or(f64::INFINITY);
    let counts = evidence.count(rows.iter().map(|(sample, _)| sample));
    Changed { placing, counts, cost: usual * (1.0 + counts.bad_share()) }
}

/// Patches of the view in the others, and of the others in the view. With each the sign with which
/// a motion of the view changes the distance.
fn compared(
    evidence: &Evidence<'_>,
    view: usize,
    placing: Placing,
    right: &[usize],
    reach: f64,
) -> Vec<(Sample, f64)> {
    let (probes, views) = (&evidence.probes, evidence.views);
    let both = |other: usize| {
        let here = Placed { view: views[view], at: placing };
        let there = Placed { view: views[other], at: evidence.placings[other] };
        let own = samples(&probes[view], here, there, reach);
        let others = samples(&probes[other], there, here, reach);
        let own = own.into_iter().map(|sample| (sample, 1.0));
        own.chain(others.into_iter().map(|sample| (sample, -1.0))).collect::<Vec<_>>()
    };
    right.iter().flat_map(|other| both(*other)).collect()
}

/// One step of least squares, with a biweight as wide as a share of the distances asks for.
fn step(rows: &[(Sample, f64)], placing: Placing, of: Change, share: f64) -> Option<Placing> {
    let met = || rows.iter().filter(|(sample, _)| sample.met);
    let center = placing.world_from_sensor.translation.vector;
    let width = WIDTH * quantile(met().map(|(s, _)| s.distance.abs()), share)?;
    let size = median(met().map(|(s, _)| (s.point.coords - center).norm()))?;
    let (mut normal, mut right) = (SMatrix::<f64, 7, 7>::zeros(), SVector::<f64, 7>::zeros());
    let mut weights = 0.0;
    for (sample, sign) in met() {
        let arm = (sample.point.coords - center) / size;
        let turn = arm.cross(&sample.normal);
        let shift = sample.normal;
        let stretch = arm.dot(&sample.normal);
        let row = match of {
            Change::Motion => [turn.x, turn.y, turn.z, shift.x, shift.y, shift.z, 0.0],
            Change::Scale => [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, stretch],
        };
        let row = SVector::from(row) * *sign;
        let weight = (1.0 - (sample.distance / width).powi(2)).max(0.0).powi(2);
        normal.syger(weight, &row, &row, 1.0);
        right.axpy(-weight * sample.distance, &row, 1.0);
        weights += weight;
    }
    normal.fill_upper_triangle_with_lower_triangle();
    let ridge = SMatrix::<f64, 7, 7>::identity() * (RIDGE * weights);
    let change = (normal + ridge).cholesky()?.solve(&right);
    let turn = UnitQuaternion::from_scaled_axis(change.fixed_rows::<3>(0) / size);
    let shift: Vector3 = change.fixed_rows::<3>(3).into_owned();
    let world_from_sensor = Isometry3::from_parts(
        Translation3::from(center + shift),
        turn * placing.world_from_sensor.rotation,
    );
    let scale = placing.scale * (1.0 + change[6] / size);
    change.iter().all(|c| c.is_finite()).then_some(Placing { world_from_sensor, scale })
}
