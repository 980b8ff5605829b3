//! Polylines from the separate lines of a drawing.

use super::Placed;
use std::collections::{BTreeMap, BTreeSet};
use transect_geometry::Point3;

/// A line of a drawing: its start and its end.
pub(super) type Line = [Placed; 2];

/// The place of a line in a list, and one of its two ends.
type End = (usize, usize);

/// Lines that follow each other.
#[derive(Default)]
pub(super) struct Chain {
    pub(super) points: Vec<Placed>,
    /// Numbers of lines that were drawn along the chain and against it.
    counts: [usize; 2],
    /// Their lengths, in the unit of the drawing.
    lengths: [f64; 2],
    /// Whether the first of its lines in the drawing was drawn against the chain.
    first_is_against: bool,
}

impl Chain {
    /// Gives the chain the direction in which most of its length was drawn. Equal lengths take the
    /// direction of the first line in the drawing.
    fn directed(mut self) -> Self {
        let [along, against] = self.lengths;
        if against > along || (against == along && self.first_is_against) {
            self.points.reverse();
            self.counts.reverse();
        }
        self
    }

    /// A note if some lines were drawn against the chain.
    pub(super) fn note(&self) -> Option<String> {
        let [along, against] = self.counts;
        let (first, last) = (self.points.first()?.point, self.points.last()?.point);
        let place = |p: Point3| format!("({}, {}, {})", p.x, p.y, p.z);
        (against > 0).then(|| {
            format!(
                "{against} of {} LINEs are drawn against the direction of most of the length; the \
                 guide runs from {} to {}; draw one polyline to state another direction",
                along + against,
                place(first),
                place(last)
            )
        })
    }
}

/// Joins lines whose ends are equal, in any order of the lines and in any direction. Lines that
/// touch nothing are chains of their own.
pub(super) fn join(lines: &[Line]) -> Vec<Chain> {
    let mut ends: BTreeMap<[u64; 3], Vec<End>> = BTreeMap::new();
    for (k, line) in lines.iter().enumerate() {
        for (end, placed) in line.iter().enumerate() {
            ends.entry(key(&placed.point)).or_default().push((k, end));
        }
    }
    let mut free: Vec<End> =
        ends.values().filter(|there| there.len() == 1).flatten().copied().collect();
    free.sort_unstable();
    let (mut used, mut chains) = (BTreeSet::new(), Vec::new());
    // A closed chain has no free end, and begins at its first line.
    for begin in free.into_iter().chain((0..lines.len()).map(|k| (k, 0))) {
        if !used.contains(&begin.0) {
            chains.push(walk(lines, &ends, &mut used, begin).directed());
        }
    }
    chains
}

/// The chain that begins with an end of a line.
fn walk(
    lines: &[Line],
    ends: &BTreeMap<[u64; 3], Vec<End>>,
    used: &mut BTreeSet<usize>,
    begin: End,
) -> Chain {
    let (mut chain, mut next, mut first) = (Chain::default(), Some(begin), usize::MAX);
    while let Some((k, end)) = next.take() {
        let Some([start, stop]) = lines.get(k) else { break };
        let is_against = end == 1;
        let (from, to) = if is_against { (stop, start) } else { (start, stop) };
        if chain.points.is_empty() {
            chain.points.push(from.clone());
        }
        chain.points.push(to.clone());
        used.insert(k);
        let [along, against] = &mut chain.counts;
        *(if is_against { against } else { along }) += 1;
        let [along, against] = &mut chain.lengths;
        *(if is_against { against } else { along }) += (to.point - from.point).norm();
        if k < first {
            (first, chain.first_is_against) = (k, is_against);
        }
        let there = ends.get(&key(&to.point)).into_iter().flatten();
        next = there.copied().find(|(line, _)| !used.contains(line));
    }
    chain
}

/// Equal points have equal keys, also those with 0 and −0.
fn key(point: &Point3) -> [u64; 3] {
    let [x, y, z] = point.coords.into();
    [x, y, z].map(|c: f64| (c + 0.0).to_bits())
}
