//! Curves cut by a few missing pixels, put together again (3.5.1).
//!
//! **Problem.** Where pixels are missing, the lines of the sweep end, and one curve becomes
//! several.
//!
//! **Idea.** Lines run with the solid on their left, so the last vertex of a line can only go on
//! with the first vertex of another one, or of its own. Both lie between the pixels beside the gap,
//! so a first vertex is looked for near each last one.
//!
//! **Steps**, for the open lines of one plane.
//! 1. First vertices are sorted into squares of the image that are as wide as the largest gap
//!    spans; those near the seam of a full circle are entered on both sides of it.
//! 2. For each last vertex, the first ones in the nine squares around it that are near enough and
//!    that the line may continue to; the rules for range and direction are those of
//!    `continuation.rs`. At least one pixel must be missing in between, and no more than the gap.
//! 3. Closest pairs are joined first; of equally close ones the straightest.
//!
//! **Departures from the source.** It searches a window of pixels in an order by code, which here
//! is the distance; the expected codes and the side of the high pixels are in the direction of the
//! lines. The straight way across must not be longer than the gap in rows or in columns, whatever
//! the outline of the missing pixels.
//!
//! **Cost.** That of sorting the ends.

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

/// A first vertex in its square of the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    square: (i64, i64),
    line: usize,
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
        let mut entries = Vec::new();
        for to in (0..lines.len()).filter(open) {
            let Some(head) = self.place(&lines[to], 0) else { continue };
            for square in self.squares(&head) {
                entries.push(Entry { square, line: to });
            }
        }
        entries.sort_unstable();
        let mut found = Vec::new();
        for from in (0..lines.len()).filter(open) {
            let Some(tail) = self.place(&lines[from], lines[from].crossings.len() - 1) else {
                continue;
            };
            let (row, col) = self.square(&tail);
            for row in row - 1..=row + 1 {
                let first = entries.partition_point(|e| e.square < (row, col - 1));
                let near = entries[first..].iter().take_while(|e| e.square <= (row, col + 1));
                found.extend(near.filter_map(|e| self.candidate(lines, from, e.line)));
            }
        }
        found
    }

    /// Longest way across a gap, in rows and in columns.
    fn reach(&self) -> f64 {
        self.gap as f64 + 1.0
    }

    fn square(&self, at: &Point2) -> (i64, i64) {
        ((at.x / self.reach()).floor() as i64, (at.y / self.reach()).floor() as i64)
    }

    /// The square of a place, and those of its images across the seam.
    fn squares(&self, at: &Point2) -> impl Iterator<Item = (i64, i64)> {
        let circle = self.grid.size().cols as f64;
        let shifts: &[f64] = if self.grid.wraps() { &[0.0, -1.0, 1.0] } else { &[0.0] };
        let near = move |col: f64, reach: f64| col > -reach && col < circle + reach;
        let mut squares: Vec<_> = Vec::with_capacity(1);
        for shift in shifts {
            let moved = Point2::new(at.x, at.y + shift * circle);
            if near(moved.y, 2.0 * self.reach()) {
                squares.push(self.square(&moved));
            }
        }
        squares.sort_unstable();
        squares.dedup();
        squares.into_iter()
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

    /// Row and column of a crossing.
    fn place(&self, solved: &Solved<'_>, k: usize) -> Option<Point2> {
        let first = self.contours.pair(solved.line.vertices.get(k)?).1[0];
        let from = self.place_from(solved, k, first)?;
        Some(Point2::new(from.x + first.row as f64, from.y + first.col as f64))
    }

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
