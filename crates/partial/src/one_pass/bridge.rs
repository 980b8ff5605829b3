//! Curves cut by a few missing pixels, put together again (3.5.1).
//!
//! **Problem.** Where pixels are missing, the lines of the sweep end, and one curve becomes
//! several.
//!
//! **Idea.** Lines run with the solid on their left. The last vertex of a line can therefore only
//! go on with a first vertex, of another line or of its own. Both lie between the pixels beside the
//! gap, so a first vertex is looked for near each last one.
//!
//! **Steps**, for the open lines of one plane.
//! 1. First vertices are sorted by their rows.
//! 2. For each last vertex, the first ones of the rows around it that are near enough and that the
//!    line may continue to. The rules for range and direction are those of `continuation.rs`. At
//!    least one pixel must be missing in between, and at most as many as the gap.
//! 3. Closest pairs are joined first; of equally close ones the straightest.
//!
//! **Departures from the source.** It searches a window of pixels in an order by code, which here
//! is the distance. The expected codes and the side of the high pixels are in the direction of the
//! lines. The straight way across must not be longer than the gap in rows or in columns, whatever
//! the outline of the missing pixels.
//!
//! **Cost.** That of sorting the ends, and of comparing the ends of neighbouring rows.

use super::contours::{Contours, Polyline};
use super::crossing::Crossing;
use super::vertex::Vertex;
use crate::continuation::{self, Place, REACH};
use crate::pixel_grid::Grid;
use transect_device::{Pixel, View};
use transect_geometry::Point2;
use transect_image::BreakRule;

/// A line with its solved crossings.
#[derive(Debug, Clone, Copy)]
pub(super) struct Solved<'a> {
    pub line: Polyline<'a>,
    pub crossings: &'a [Crossing],
}

/// Lines that make one curve, in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Strand {
    /// Their numbers; at least one.
    pub lines: Vec<usize>,
    pub closed: bool,
}

/// The view and the rules by which ends are compared.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gaps<'a> {
    pub view: &'a View,
    pub rule: &'a BreakRule,
    pub contours: &'a Contours<'a>,
    pub grid: Grid,
    /// Most missing pixels in a row.
    pub gap: usize,
}

/// A last vertex that a first one may follow.
struct Candidate {
    /// Squared distance in pixels.
    distance: f64,
    /// How much the curve turns at both ends together; no unit.
    turn: f64,
    from: usize,
    to: usize,
}

impl Gaps<'_> {
    /// The lines of one plane as curves, in the order of their smallest numbers.
    pub fn bridge(&self, lines: &[Solved<'_>]) -> Vec<Strand> {
        let mut next = vec![None; lines.len()];
        let mut follows = vec![false; lines.len()];
        if self.gap > 0 {
            let mut candidates = self.candidates(lines);
            candidates.sort_by(|a, b| {
                let order = a.distance.total_cmp(&b.distance).then(a.turn.total_cmp(&b.turn));
                order.then((a.from, a.to).cmp(&(b.from, b.to)))
            });
            for c in candidates {
                if next[c.from].is_none() && !follows[c.to] {
                    next[c.from] = Some(c.to);
                    follows[c.to] = true;
                }
            }
        }
        strands(lines, &next, &follows)
    }

    fn candidates(&self, lines: &[Solved<'_>]) -> Vec<Candidate> {
        let open = |k: &usize| !lines[*k].line.closed && !lines[*k].crossings.is_empty();
        let place = |line: usize, k: usize| Some((self.row(&lines[line], k)?, line));
        let mut heads: Vec<(f64, usize)> =
            (0..lines.len()).filter(open).filter_map(|line| place(line, 0)).collect();
        heads.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // One row more than the gap, because of rounding.
        let rows = self.reach() + 1.0;
        let last = |line: usize| place(line, lines[line].crossings.len() - 1);
        let mut found = Vec::new();
        for (row, from) in (0..lines.len()).filter(open).filter_map(last) {
            let first = heads.partition_point(|head| head.0 < row - rows);
            let near = heads[first..].iter().take_while(|head| head.0 <= row + rows);
            found.extend(near.filter_map(|head| self.candidate(lines, from, head.1)));
        }
        found
    }

    /// Longest way across a gap, in rows and in columns.
    fn reach(&self) -> f64 {
        self.gap as f64 + 1.0
    }

    fn candidate(&self, lines: &[Solved<'_>], from: usize, to: usize) -> Option<Candidate> {
        let (tail, head) = (&lines[from], &lines[to]);
        let pixels = [tail.crossings.last()?.pixel, head.crossings.first()?.pixel];
        let end = self.place_from(tail, tail.crossings.len() - 1, pixels[0])?;
        let across = self.place_from(head, 0, pixels[0])? - end;
        if across.x.abs().max(across.y.abs()) > self.reach() {
            return None;
        }
        let missing = self.missing(tail, head)?;
        if missing == 0 || missing > self.gap {
            return None;
        }
        let continues =
            |miss| continuation::continues(self.view, &self.grid, self.rule, pixels, miss);
        let (behind, ahead) =
            (self.inward(tail, true, pixels[0]), self.inward(head, false, pixels[0]));
        let turn = continuation::turn(&behind, &ahead, continues)?;
        Some(Candidate { distance: across.norm_squared(), turn, from, to })
    }

    /// Most missing pixels on the way from one end to the other on the high and on the low side;
    /// `None` where valid pixels are of different surfaces.
    fn missing(&self, tail: &Solved<'_>, head: &Solved<'_>) -> Option<usize> {
        let sides = |vertex: &Vertex, crossing: &Crossing| {
            let [a, b] = self.contours.pair(vertex).1;
            if crossing.pair.z > 0.0 { [b, a] } else { [a, b] }
        };
        let end = sides(tail.line.vertices.last()?, tail.crossings.last()?);
        let begin = sides(head.line.vertices.first()?, head.crossings.first()?);
        let valid = |p: Pixel| self.view.image().get(p).is_some();
        let alike = |a, b| continuation::alike(self.view, self.rule, a, b);
        let between =
            |k: usize| continuation::missing_between(&self.grid, [end[k], begin[k]], valid, alike);
        Some(between(0)?.max(between(1)?))
    }

    /// The first few places from an end of a line inward, counted from an anchor so that the seam
    /// of a full circle does not show.
    fn inward(&self, solved: &Solved<'_>, from_tail: bool, anchor: Pixel) -> Vec<Place> {
        let count = solved.crossings.len();
        let at = |k: usize| if from_tail { count - 1 - k } else { k };
        let place = |k: usize| {
            let image = self.place_from(solved, at(k), anchor)?;
            Some(Place { image, in_plane: solved.crossings[at(k)].position })
        };
        (0..count.min(REACH)).filter_map(place).collect()
    }

    /// Row of a crossing.
    fn row(&self, solved: &Solved<'_>, k: usize) -> Option<f64> {
        let share = f64::from(solved.crossings.get(k)?.share);
        let [first, second] = self.contours.pair(solved.line.vertices.get(k)?).1;
        Some(first.row as f64 + share * (second.row as f64 - first.row as f64))
    }

    /// Row and column of a crossing, counted from an anchor.
    fn place_from(&self, solved: &Solved<'_>, k: usize, anchor: Pixel) -> Option<Point2> {
        let vertex = solved.line.vertices.get(k)?;
        let share = f64::from(solved.crossings.get(k)?.share);
        let [first, second] = self.contours.pair(vertex).1;
        let (row, col) = self.grid.offset(anchor, first);
        let (rows, cols) = self.grid.offset(first, second);
        Some(Point2::new(row + share * rows, col + share * cols))
    }
}

/// Lines and what follows them as curves.
fn strands(lines: &[Solved<'_>], next: &[Option<usize>], follows: &[bool]) -> Vec<Strand> {
    let mut taken = vec![false; lines.len()];
    let mut found = Vec::with_capacity(lines.len());
    let mut walk = |first: usize| {
        let mut strand = Strand { lines: Vec::new(), closed: lines[first].line.closed };
        let mut at = Some(first);
        while let Some(k) = at.filter(|k| !taken[*k]) {
            taken[k] = true;
            strand.lines.push(k);
            at = next[k];
        }
        strand.closed |= at == Some(first);
        if !strand.lines.is_empty() {
            found.push(strand);
        }
    };
    // Open ones from their beginnings; what is left then are rings.
    (0..lines.len()).filter(|k| !follows[*k]).for_each(&mut walk);
    (0..lines.len()).for_each(&mut walk);
    found.sort_by_key(|s| s.lines.iter().copied().min());
    found
}
