//! Two curves that overlap become one: what stays of each, and the merged part between.
//!
//! **Problem.** The rule table says which of two curves goes on at either end of an overlap. The
//! unenclosed parts must be joined to the averaged part without losing what was seen.
//!
//! **Steps.**
//! 1. The rules: one valid overlap, or two of a ring. Everything else is cut where it forks
//!    (`fork.rs`), or refused.
//! 2. Verification (5.5.1) and averaging (5.5.2) of the enclosed parts.
//! 3. Before the overlap the curve that has more of it stays, and so it does behind. What the other
//!    one has there is no longer than the remainder that counts as nothing.
//! 4. Of a ring, what either curve has between the two overlaps stays, and the result is closed.
//! 5. Every node that went in must lie within the threshold of what came out, or be counted. If an
//!    enclosed one does not, the better supported of the two curves stays as it is there; in a
//!    ring, such nodes are only counted.
//!
//! **Departures from the source.** The dissertation averages, and does not say what happens at the
//! ends: as printed, the merged curve would lose half a unit at each free end with every merge. The
//! outermost node stays, and with it the reason why its curve ends there. Step 5 is not in the
//! source.

use super::average::{Averaged, average, lost_by};
use super::fork::{Cut, cut};
use super::strand::Strand;
use super::verify::{Limits, verify};
use crate::envelopes::UnitIndex;
use crate::pattern::{
    Fork, Overlap, OverlapTolerance, Overlaps, Parts, Pattern, Relation, Verdict,
};
use transect_geometry::{Curve, EndReason, Node};

/// The outcome of a merge of two curves.
#[derive(Debug, Clone)]
pub(super) enum Outcome {
    /// They do not overlap.
    Apart,
    /// They overlap as the rules forbid.
    Refused(Refusal),
    /// They fork, and one of them was cut there.
    Cut(Cut),
    /// They are one.
    Merged(Merged),
}

/// Why two overlapping curves cannot be merged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// A fork in one place (Rule 1).
    Fork(Fork),
    /// Overlaps in several places that make no ring (Rules 2 and 3).
    Several,
}

/// Two curves that became one.
#[derive(Debug, Clone)]
pub(super) struct Merged {
    pub curve: Curve,
    /// The pattern of the overlap; `None` for a ring.
    pub pattern: Option<Pattern>,
    /// Whether two open curves became a closed one.
    pub ring: bool,
    /// Whether the overlap was averaged; if not, the better supported curve's part was taken.
    pub averaged: bool,
    /// Observations whose nodes are farther than the threshold from the result.
    pub dropped: usize,
}

/// Merges two curves if the rules allow it.
pub(super) fn merge(
    pair: [&Curve; 2],
    overlaps: &Overlaps,
    tolerance: &OverlapTolerance,
) -> Outcome {
    if let Some(refusal) = refusal(pair, overlaps) {
        return cut(pair, overlaps).map_or(Outcome::Refused(refusal), Outcome::Cut);
    }
    let limits =
        Limits { threshold: tolerance.distance(), least_cosine: tolerance.max_angle_rad().cos() };
    let merger = Merger { pair, limits };
    let merged = match overlaps.as_slice() {
        [overlap] => merger.single(overlap),
        [coming, leaving] => merger.ring(coming, leaving),
        _ => None,
    };
    merged.map_or(Outcome::Apart, Outcome::Merged)
}

/// Why the rules forbid to merge two curves, if they do.
fn refusal(pair: [&Curve; 2], overlaps: &Overlaps) -> Option<Refusal> {
    let fork = overlaps.as_slice().iter().find_map(|o| match o.verdict {
        Verdict::Fork(fork) => Some(Refusal::Fork(fork)),
        Verdict::Valid(_) => None,
    });
    match overlaps.relation() {
        Relation::Apart | Relation::Ring => None,
        Relation::Several => Some(Refusal::Several),
        Relation::Single => fork.or_else(|| {
            // A ring that lies on the middle of an open curve: the open one overlaps itself.
            let [a, b] = pair.map(Curve::is_closed);
            let overlap = overlaps.as_slice().first()?;
            let open = if a { overlap.parts_b } else { overlap.parts_a };
            (a != b && open != Parts::WHOLE).then_some(Refusal::Several)
        }),
    }
}

struct Merger<'a> {
    pair: [&'a Curve; 2],
    limits: Limits,
}

impl Merger<'_> {
    fn strands(&self, overlap: &Overlap) -> [Strand; 2] {
        [Strand::new(self.pair[0], &overlap.on_a), Strand::new(self.pair[1], &overlap.on_b)]
    }

    fn average(&self, strands: &[Strand; 2]) -> Option<Averaged> {
        let strands = [&strands[0], &strands[1]];
        let start = verify(strands, &self.limits)?;
        Some(average(strands, &start, &self.limits))
    }

    /// One overlap (Rule 2).
    fn single(&self, overlap: &Overlap) -> Option<Merged> {
        let strands = self.strands(overlap);
        let averaged = self.average(&strands)?;
        let closed = strands.iter().any(|s| s.closed);
        let ends = Ends::of(&strands);
        let nodes = self.assemble(&strands, &averaged, ends);
        let spliced = self.checked(&strands, &[&averaged], nodes, closed);
        let (curve, lost, averaged) = match spliced {
            Some((curve, lost)) if lost.enclosed == 0 => (curve, lost, true),
            _ => {
                let nodes = better_supported(&strands, ends);
                let (curve, lost) = self.checked(&strands, &[], nodes, closed)?;
                (curve, lost, false)
            }
        };
        let curve = if closed { curve } else { curve.with_ends(ends.reasons(&strands)) };
        let pattern = match overlap.verdict {
            Verdict::Valid(pattern) => Some(pattern),
            Verdict::Fork(_) => None,
        };
        Some(Merged { curve, pattern, ring: false, averaged, dropped: lost.total() })
    }

    /// Two overlaps, each the end of one curve on the beginning of the other (Rule 3).
    fn ring(&self, coming: &Overlap, leaving: &Overlap) -> Option<Merged> {
        // The first curve begins on the second one's end, and later ends on its beginning.
        let (ends, beginnings) = (self.strands(leaving), self.strands(coming));
        let (there, back) = match (self.average(&ends), self.average(&beginnings)) {
            (Some(there), Some(back)) => (there, back),
            // Ends that merely touch do not close a ring.
            (Some(_), None) => return self.single(leaving),
            (None, _) => return self.single(coming),
        };
        let of_first = ends[0].nodes.get(back.tails[0]..there.heads[0])?;
        let of_second = ends[1].nodes.get(there.tails[1]..back.heads[1])?;
        let mut nodes = Vec::new();
        for (part, averaged, next) in [(of_first, &there, of_second), (of_second, &back, of_first)]
        {
            nodes.extend_from_slice(part);
            nodes.extend(self.up_to(averaged, next));
        }
        let (curve, lost) = self.checked(&ends, &[&there, &back], nodes, true)?;
        let dropped = lost.total();
        Some(Merged { curve, pattern: None, ring: true, averaged: true, dropped })
    }

    /// The head of one strand, the averaged part, and the tail of one strand.
    fn assemble(&self, strands: &[Strand; 2], averaged: &Averaged, ends: Ends) -> Vec<Node> {
        let (before, behind) = (&strands[ends.before], &strands[ends.behind]);
        if strands.iter().all(|s| s.closed) {
            return averaged.nodes.clone();
        }
        let head = averaged.heads[ends.before].min(before.nodes.len());
        let tail = averaged.tails[ends.behind].min(behind.nodes.len());
        let mut nodes = before.observed(0..head);
        let tail = behind.observed(tail..behind.nodes.len());
        nodes.extend(self.up_to(averaged, &tail));
        nodes.extend(tail);
        nodes
    }

    /// The averaged part, and what the chord to the tail behind it would lose.
    fn up_to(&self, averaged: &Averaged, tail: &[Node]) -> Vec<Node> {
        let mut nodes = averaged.nodes.clone();
        if let (Some(last), Some(next)) = (averaged.nodes.last(), tail.first()) {
            nodes.extend(lost_by(last, next, &averaged.passed, self.limits.threshold));
        }
        nodes
    }

    /// The curve through the nodes, and which nodes of both strands it lost.
    fn checked(
        &self,
        strands: &[Strand; 2],
        averaged: &[&Averaged],
        nodes: Vec<Node>,
        closed: bool,
    ) -> Option<(Curve, Lost)> {
        let curve = Curve::new(nodes, closed).ok()?;
        let index = UnitIndex::new([&curve]);
        let mut lost = Lost::default();
        let mut near = Vec::new();
        for (side, strand) in strands.iter().enumerate() {
            let noise = |k: usize| averaged.iter().any(|a| a.noise.contains(&(side, k)));
            for (k, node) in strand.nodes.iter().enumerate().filter(|(k, _)| strand.is_observed(*k))
            {
                if index.is_near(&node.position, self.limits.threshold, &mut near) {
                    continue;
                }
                let enclosed = strand.enclosed.contains(&k) && !noise(k);
                // A fused node stands for as many observations as its weight says.
                let observations = node.weight.round().max(1.0) as usize;
                let count = if enclosed { &mut lost.enclosed } else { &mut lost.outside };
                *count = count.saturating_add(observations);
            }
        }
        Some((curve, lost))
    }
}

/// Which of two strands stays before and behind their overlap.
#[derive(Debug, Clone, Copy)]
struct Ends {
    before: usize,
    behind: usize,
}

impl Ends {
    /// The longer one; of a closed and an open curve the closed one, which has no ends.
    fn of([a, b]: &[Strand; 2]) -> Self {
        let longer = |side: usize| match (a.closed, b.closed) {
            (true, false) => 0,
            (false, true) => 1,
            _ => usize::from(b.outside[side] > a.outside[side]),
        };
        Self { before: longer(0), behind: longer(1) }
    }

    /// Why the merged curve begins and ends: as the strand that stays there.
    fn reasons(self, strands: &[Strand; 2]) -> [Option<EndReason>; 2] {
        [strands[self.before].ends[0], strands[self.behind].ends[1]]
    }
}

/// Observations whose nodes are farther than the threshold from a merged curve.
#[derive(Debug, Clone, Copy, Default)]
struct Lost {
    /// In the overlap, and not left out as noise.
    enclosed: usize,
    /// Noise, and stubs beyond the overlap.
    outside: usize,
}

impl Lost {
    fn total(&self) -> usize {
        self.enclosed.saturating_add(self.outside)
    }
}

/// The overlap as the strand with more weight in it has it, between the same ends.
fn better_supported(strands: &[Strand; 2], ends: Ends) -> Vec<Node> {
    let weight = |s: &Strand| s.nodes[s.enclosed.clone()].iter().map(|n| n.weight).sum::<f32>();
    let better = &strands[usize::from(weight(&strands[1]) > weight(&strands[0]))];
    if better.closed {
        return better.observed(0..better.nodes.len());
    }
    let (before, behind) = (&strands[ends.before], &strands[ends.behind]);
    let mut nodes = before.observed(0..before.enclosed.start);
    nodes.extend(better.observed(better.enclosed.clone()));
    nodes.extend(behind.observed(behind.enclosed.end..behind.nodes.len()));
    nodes
}
