//! The intermediate results of one merge, for pictures that explain the method.

use super::average::average;
use super::splice::{Outcome, Refusal, merge};
use super::strand::Strand;
use super::verify::{Limits, verify};
use crate::pattern::{OverlapTolerance, Overlaps, classify};
use transect_geometry::{Curve, CurveUnit, Node, Point2};

/// The result of each step on two curves.
#[derive(Debug, Clone, PartialEq)]
pub struct MergeSteps {
    /// Where the curves overlap, their parts, and what the rules say (5.4).
    pub overlaps: Overlaps,
    /// The verification of the first overlap (5.5.1); `None` if no unit holds a first point.
    pub verified: Option<VerifiedOverlap>,
    /// The outcome for the curves.
    pub outcome: MergeOutcome,
}

/// A verified overlap, and its average (5.5.1 and 5.5.2).
#[derive(Debug, Clone, PartialEq)]
pub struct VerifiedOverlap {
    /// Which of the two curves is the basis curve: 0 or 1.
    pub basis: usize,
    /// The unit of the basis curve that holds the first point.
    pub unit: CurveUnit,
    /// The first point, on the distant curve.
    pub point: Point2,
    /// The enclosed nodes of both curves.
    pub enclosed: [Vec<Node>; 2],
    /// The averaged nodes.
    pub averaged: Vec<Node>,
    /// Points that were left out as noise.
    pub noise: Vec<Point2>,
}

/// The outcome for two curves.
#[derive(Debug, Clone, PartialEq)]
pub enum MergeOutcome {
    /// They stay beside each other, because they do not overlap.
    Apart,
    /// They stay beside each other, because the rules forbid a merge.
    Refused(Refusal),
    /// One of them, 0 or 1, is cut at a fork.
    Cut(usize),
    /// They become one curve.
    Merged(Curve),
}

/// The steps by which two curves become one, or stay two.
pub fn merge_steps(pair: [&Curve; 2], tolerance: &OverlapTolerance) -> MergeSteps {
    let overlaps = classify(pair[0], pair[1], tolerance);
    let verified = verified(pair, &overlaps, tolerance);
    let outcome = match merge(pair, &overlaps, tolerance) {
        Outcome::Apart => MergeOutcome::Apart,
        Outcome::Refused(refusal) => MergeOutcome::Refused(refusal),
        Outcome::Cut(cut) => MergeOutcome::Cut(cut.side),
        Outcome::Merged(merged) => MergeOutcome::Merged(merged.curve),
    };
    MergeSteps { overlaps, verified, outcome }
}

fn verified(
    pair: [&Curve; 2],
    overlaps: &Overlaps,
    tolerance: &OverlapTolerance,
) -> Option<VerifiedOverlap> {
    let overlap = overlaps.as_slice().first()?;
    let strands = [Strand::new(pair[0], &overlap.on_a), Strand::new(pair[1], &overlap.on_b)];
    let limits =
        Limits { threshold: tolerance.distance(), least_cosine: tolerance.max_angle_rad().cos() };
    let both = [&strands[0], &strands[1]];
    let start = verify(both, &limits)?;
    let averaged = average(both, &start, &limits);
    let place = |&(side, k): &(usize, usize)| Some(strands[side].nodes.get(k)?.position);
    Some(VerifiedOverlap {
        basis: start.basis,
        unit: strands[start.basis].unit(start.unit)?,
        point: strands[1 - start.basis].nodes.get(start.point)?.position,
        enclosed: both.map(|strand| strand.observed(strand.enclosed.clone())),
        noise: averaged.noise.iter().filter_map(place).collect(),
        averaged: averaged.nodes,
    })
}
