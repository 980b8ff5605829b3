//! Where two curves fork, one of them is cut.
//!
//! **Problem.** By the rules of 5.4 no section forks, but curves with errors do. They fork at a
//! corner that one view cut off, at a niche that one view missed, and where bridges or noise lead
//! aside. Two long curves that fork in one place would lie beside each other on all their common
//! ground.
//!
//! **Idea.** Of the two unenclosed parts that make the fork, the shorter one becomes a curve of its
//! own. What is left of its curve overlaps the other as the rules allow.
//!
//! **Departure from the source**, which takes forks as impossible and does not treat them.

use crate::pattern::{Overlap, Overlaps};
use crate::sequence::arc_lengths;
use transect_geometry::Curve;

/// A curve of a pair that was cut in two.
#[derive(Debug, Clone)]
pub(super) struct Cut {
    /// Which of the pair: 0 or 1.
    pub side: usize,
    pub pieces: [Curve; 2],
}

/// Cuts one of two curves at their first fork; `None` if no fork can be cut. Closed curves are
/// never cut.
pub(super) fn cut(pair: [&Curve; 2], overlaps: &Overlaps) -> Option<Cut> {
    overlaps.as_slice().iter().filter(|o| !o.verdict.is_valid()).find_map(|o| cut_at(pair, o))
}

fn cut_at(pair: [&Curve; 2], overlap: &Overlap) -> Option<Cut> {
    let begins = overlap.parts_a.begins_unenclosed && overlap.parts_b.begins_unenclosed;
    let ranges = [overlap.on_a, overlap.on_b];
    let unenclosed = |side: usize| match (pair[side].is_closed(), begins) {
        (true, _) => f64::INFINITY,
        (false, true) => ranges[side].from,
        (false, false) => pair[side].length() - ranges[side].to,
    };
    let side = usize::from(unenclosed(1) < unenclosed(0));
    let (curve, range) = (pair[side], ranges[side]);
    let arc = arc_lengths(curve.units().map(|unit| unit.vector().norm()));
    // The outermost enclosed node belongs to both pieces.
    let at = match begins {
        true => arc.partition_point(|s| *s < range.from),
        false => arc.partition_point(|s| *s <= range.to).checked_sub(1)?,
    };
    let (nodes, [begin, end]) = (curve.nodes(), curve.ends());
    let before = Curve::new(nodes.get(..=at)?.to_vec(), false).ok()?;
    let behind = Curve::new(nodes.get(at..)?.to_vec(), false).ok()?;
    let pieces = [before.with_ends([begin, None]), behind.with_ends([None, end])];
    (!curve.is_closed()).then_some(Cut { side, pieces })
}
