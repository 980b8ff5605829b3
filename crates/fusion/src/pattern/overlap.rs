//! Finding the overlaps of two oriented curves and the parts they leave (dissertation 5.4, 5.5.1).
//!
//! The idea: a node of one curve that projects onto a unit of the other, near enough and running
//! the same way, is seen by both. Such nodes of both curves, as pairs of arc lengths, line up into
//! overlaps; what is left of each curve before and behind gives its parts, and those the verdict.
//!
//! 1. Match the nodes of each curve with their nearest agreeing place on the other (5.5.1 with
//!    |y| below the threshold: errata).
//! 2. Sort the matches along the first curve and link each to the one before, as long as both
//!    curves advance together and no unenclosed ground lies between.
//! 3. On closed curves, link the last to the first as well.
//! 4. An overlap is a chain of two matches or more. Remainders no longer than the tolerance are
//!    empty parts; [`verdict`] judges the parts.
//! 5. Count the overlaps: one obeys Rule 2, two that close a ring obey Rule 3, more break the
//!    rules.
//!
//! Departures from the source: 5.5.1 looks for the first projected point only; matching all nodes
//! also finds where the overlap ends, and how many there are. A node up to one threshold beyond an
//! open end lies on that end: of two noisy ends at one place, each may project beyond the other.
//! Ends that merely touch are therefore an overlap, of length zero, from end to beginning. A closed
//! curve has no ends: its parts are `abc` if some of it is unenclosed, `âbĉ` otherwise.
//!
//! Cost: n log m for the n nodes of one curve and the m units of the other in the common rectangle;
//! each match is then compared with the chains that there are. Not for a curve that overlaps
//! itself: each node is matched once, with the nearest place.

use super::matches::{Match, Measured, NodePlaces, find};
use super::{Parts, Verdict, verdict};
use serde::{Deserialize, Serialize};
use transect_geometry::Curve;

/// When two curves count as overlapping. Lengths are in the model's length unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Unchecked")]
pub struct OverlapTolerance {
    distance: f64,
    max_angle_rad: f64,
    remainder: f64,
}

/// A tolerance as settings state it.
#[derive(Deserialize)]
#[serde(rename = "OverlapTolerance", deny_unknown_fields)]
struct Unchecked {
    distance: f64,
    max_angle_rad: f64,
    remainder: f64,
}

impl TryFrom<Unchecked> for OverlapTolerance {
    type Error = ToleranceError;

    fn try_from(stated: Unchecked) -> Result<Self, ToleranceError> {
        Self::new(stated.distance, stated.max_angle_rad, stated.remainder)
    }
}

/// A tolerance that makes no sense.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ToleranceError {
    /// The distance or remainder is negative, NaN or infinite.
    #[error("an overlap tolerance must be a finite length of at least 0, got {0}")]
    BadLength(f64),
    /// The angle is not between 0 and a quarter turn.
    #[error("the largest angle between overlapping curves must be within 0 and 90°, got {0} rad")]
    BadAngle(f64),
}

impl OverlapTolerance {
    /// Tolerances of one's own.
    ///
    /// `distance`: the farthest a node may be from the other curve. `max_angle_rad`: the largest
    /// angle between the two directions there. `remainder`: the longest unenclosed stretch, at an
    /// end or within an overlap, that counts as nothing.
    ///
    /// # Errors
    /// [`ToleranceError`], with the value. From a quarter turn on, the two directions would no
    /// longer tell the opposite sides of a sheet apart.
    pub fn new(distance: f64, max_angle_rad: f64, remainder: f64) -> Result<Self, ToleranceError> {
        let bad = [distance, remainder].into_iter().find(|&x| !(x.is_finite() && x >= 0.0));
        if let Some(bad) = bad {
            return Err(ToleranceError::BadLength(bad));
        }
        if !(0.0..=std::f64::consts::FRAC_PI_2).contains(&max_angle_rad) {
            return Err(ToleranceError::BadAngle(max_angle_rad));
        }
        Ok(Self { distance, max_angle_rad, remainder })
    }

    /// Tolerances that follow from the distance: 60°, and remainders of up to four distances.
    ///
    /// Doubling the angle would accept opposite directions; halving it loses noisy curves whose
    /// nodes are closer together than their noise. Four distances are what a curve needs to come
    /// within reach of another under a flat angle.
    ///
    /// # Errors
    /// [`ToleranceError::BadLength`] unless the distance is finite and not negative.
    pub fn within(distance: f64) -> Result<Self, ToleranceError> {
        Self::new(distance, std::f64::consts::FRAC_PI_3, 4.0 * distance)
    }

    /// The farthest a node may be from the other curve.
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// The largest angle between the two directions, in radians.
    pub fn max_angle_rad(&self) -> f64 {
        self.max_angle_rad
    }

    /// The longest unenclosed stretch that counts as nothing.
    pub fn remainder(&self) -> f64 {
        self.remainder
    }
}

/// A stretch of a curve, by arc length from its first node in the model's length unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveRange {
    /// Where it begins: at least 0, and on a closed curve less than the curve's length.
    pub from: f64,
    /// Where it ends; on a closed curve past the curve's length if it runs over node 0.
    pub to: f64,
}

impl CurveRange {
    /// How long the stretch is.
    pub fn length(&self) -> f64 {
        self.to - self.from
    }
}

/// One overlap of two curves: the enclosed parts `b` and `B`, and what is around them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// The enclosed part of the first curve.
    pub on_a: CurveRange,
    /// The enclosed part of the second curve.
    pub on_b: CurveRange,
    /// The parts of the first curve outside the overlap.
    pub parts_a: Parts,
    /// The parts of the second curve outside the overlap.
    pub parts_b: Parts,
    /// The verdict of the rules.
    pub verdict: Verdict,
}

/// How two curves lie to each other, by the number of their overlaps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Relation {
    /// They do not overlap.
    Apart,
    /// One overlap, as Rule 2 wants it.
    Single,
    /// Two overlaps of open curves, each the end of one on the beginning of the other: a ring
    /// (Rule 3). Remainders no longer than the tolerance may be left at these ends.
    Ring,
    /// More overlaps than the rules allow; merging would make a fork somewhere.
    Several,
}

/// All overlaps of two curves, in order along the first.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlaps {
    overlaps: Vec<Overlap>,
    relation: Relation,
}

impl Overlaps {
    /// The overlaps in order along the first curve.
    pub fn as_slice(&self) -> &[Overlap] {
        &self.overlaps
    }

    /// How the two curves lie to each other.
    pub fn relation(&self) -> Relation {
        self.relation
    }
}

/// Finds where two curves overlap, and judges it by the rules.
///
/// ```
/// use transect_fusion::pattern::{OverlapTolerance, Pattern, Relation, Verdict, classify};
/// use transect_geometry::{Curve, Node, Point2};
/// let along_x = |from: i32, to: i32| {
///     let nodes = (from..=to).map(|x| Node::at(Point2::new(x.into(), 0.0))).collect();
///     Curve::new(nodes, false).unwrap()
/// };
/// let tolerance = OverlapTolerance::within(0.1).unwrap();
/// let found = classify(&along_x(0, 6), &along_x(4, 9), &tolerance);
/// assert_eq!(found.relation(), Relation::Single);
/// let overlap = found.as_slice()[0];
/// assert_eq!(overlap.verdict, Verdict::Valid(Pattern::EndToBeginning));
/// assert!((overlap.on_a.length() - 2.0).abs() < 1e-12); // length units
/// ```
pub fn classify(a: &Curve, b: &Curve, tolerance: &OverlapTolerance) -> Overlaps {
    let (a, b) = (Measured::new(a), Measured::new(b));
    // All nodes of such a curve are at one place: it has no direction to agree with.
    if a.length == 0.0 || b.length == 0.0 {
        return Overlaps { overlaps: Vec::new(), relation: Relation::Apart };
    }
    let (matches, nodes_a, nodes_b) = find(&a, &b, tolerance);
    let linker = Linker { a: &a, b: &b, nodes_a, nodes_b, tolerance };
    let mut chains = linker.chains(&matches);
    if a.curve.is_closed() {
        linker.close(&mut chains);
    }
    let overlap = |chain: &Chain| overlap_of(chain, &a, &b, tolerance);
    let mut overlaps: Vec<_> = chains.iter().filter(|c| c.len() > 1).map(overlap).collect();
    overlaps.sort_by(|p, q| p.on_a.from.total_cmp(&q.on_a.from));
    let closed = a.curve.is_closed() || b.curve.is_closed();
    let mut relation = relation_of(&overlaps, closed);
    if relation == Relation::Several {
        // Ends that touch where the curves overlap elsewhere are the ends of a gap in one of them.
        overlaps.retain(|o| o.on_a.length() > 0.0 && o.on_b.length() > 0.0);
        relation = relation_of(&overlaps, closed);
    }
    Overlaps { overlaps, relation }
}

fn relation_of(overlaps: &[Overlap], closed: bool) -> Relation {
    match overlaps {
        [] => Relation::Apart,
        [_] => Relation::Single,
        [p, q] if !closed && is_ring(p, q) => Relation::Ring,
        _ => Relation::Several,
    }
}

/// Whether the first curve begins on the second one's end, and ends on its beginning.
///
/// Parts that count as nothing may be left there. Curves that go all the way round but for a short
/// gap may be enclosed whole by both overlaps. They make a ring with what bridges the gap.
fn is_ring(p: &Overlap, q: &Overlap) -> bool {
    let begins_on_end = !p.parts_a.begins_unenclosed && !p.parts_b.ends_unenclosed;
    let ends_on_beginning = !q.parts_a.ends_unenclosed && !q.parts_b.begins_unenclosed;
    begins_on_end && ends_on_beginning && p.on_a.to <= q.on_a.from && q.on_b.to <= p.on_b.from
}

/// Linked matches, with arc lengths made continuous where a closed curve runs over its node 0.
type Chain = Vec<Match>;

/// Steps backwards, and differences between the two steps, that noise of one distance can cause.
const JITTER_DISTANCES: f64 = 4.0;

/// How much longer one curve's way between two matches may be than the other's, as a share of it:
/// the way along a curve that noise has roughened. A loop on one curve only is longer.
const UNEVEN_SHARE: f64 = 0.5;

struct Linker<'a> {
    a: &'a Measured<'a>,
    b: &'a Measured<'a>,
    nodes_a: NodePlaces,
    nodes_b: NodePlaces,
    tolerance: &'a OverlapTolerance,
}

impl Linker<'_> {
    /// Links every match to the latest chain that it continues.
    fn chains(&self, matches: &[Match]) -> Vec<Chain> {
        let mut chains: Vec<Chain> = Vec::new();
        for next in matches {
            let continued = chains.iter_mut().rev().find_map(|chain| {
                let continued = self.continues(chain.last()?, next)?;
                Some((chain, continued))
            });
            match continued {
                Some((chain, next)) => chain.push(next),
                None => chains.push(vec![*next]),
            }
        }
        chains
    }

    /// Links the last chain to the first over node 0 of a closed first curve.
    fn close(&self, chains: &mut [Chain]) {
        let over = |m: &Match| Match { on_a: m.on_a + self.a.length, ..*m };
        let heads: Vec<_> = chains.iter().filter_map(|c| c.first().map(over)).collect();
        for (first, head) in heads.iter().enumerate() {
            let joint = chains
                .iter()
                .enumerate()
                .rev()
                .find_map(|(last, chain)| Some((last, self.continues(chain.last()?, head)?)));
            let Some((last, joined)) = joint else { continue };
            if first == last {
                // The whole ring is one overlap: its first match, one round later, ends it.
                chains[last].push(joined);
                return;
            }
            let shift = joined.on_b - head.on_b;
            let head_chain = std::mem::take(&mut chains[first]);
            let moved = head_chain.iter().map(over);
            chains[last].extend(moved.map(|m| Match { on_b: m.on_b + shift, ..m }));
            return;
        }
    }

    /// The next match, continuous with the one before it, if both belong to one overlap.
    fn continues(&self, last: &Match, next: &Match) -> Option<Match> {
        let step_a = next.on_a - last.on_a;
        let mut step_b = next.on_b - last.on_b;
        if self.b.curve.is_closed() {
            step_b -= self.b.length * ((step_b - step_a) / self.b.length).round();
        }
        let jitter = JITTER_DISTANCES * self.tolerance.distance;
        let uneven = (step_b - step_a).abs();
        if step_b < -jitter || uneven > jitter + UNEVEN_SHARE * step_a.max(step_b) {
            return None;
        }
        let gap = self.tolerance.remainder;
        let open_a = step_a > gap && self.nodes_a.unenclosed(last.on_a, step_a, self.a.length);
        let open_b = step_b > gap && self.nodes_b.unenclosed(last.on_b, step_b, self.b.length);
        (!open_a && !open_b).then_some(Match { on_a: next.on_a, on_b: last.on_b + step_b })
    }
}

fn overlap_of(
    chain: &Chain,
    a: &Measured<'_>,
    b: &Measured<'_>,
    tolerance: &OverlapTolerance,
) -> Overlap {
    let on_a = range(chain.iter().map(|m| m.on_a), a);
    let on_b = range(chain.iter().map(|m| m.on_b), b);
    let parts_a = parts(&on_a, a, tolerance.remainder);
    let parts_b = parts(&on_b, b, tolerance.remainder);
    Overlap { on_a, on_b, parts_a, parts_b, verdict: verdict(parts_a, parts_b) }
}

/// From the least to the largest arc length, beginning in the first round of a closed curve.
fn range(places: impl Iterator<Item = f64>, curve: &Measured<'_>) -> CurveRange {
    let (from, to) =
        places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| (low.min(s), high.max(s)));
    if !curve.curve.is_closed() {
        return CurveRange { from, to };
    }
    let begin = from.rem_euclid(curve.length);
    CurveRange { from: begin, to: begin + (to - from).min(curve.length) }
}

fn parts(range: &CurveRange, curve: &Measured<'_>, remainder: f64) -> Parts {
    if curve.curve.is_closed() {
        let unenclosed = curve.length - range.length() > remainder;
        return Parts::new(unenclosed, unenclosed);
    }
    Parts::new(range.from > remainder, curve.length - range.to > remainder)
}
