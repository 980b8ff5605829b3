//! From links to pieces: what a band holds of each curve, its vertices in order.

use super::band::{Band, FOLLOWS, HEAD, NONE, TAKEN};
use super::contours::Vertex;

/// Consecutive vertices of one curve, from one band.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// First vertex in its part's vertices.
    pub start: u32,
    pub len: u32,
    /// Level from the base plane.
    pub level: i32,
    /// The piece that goes on, itself for a loop, or [`NONE`].
    pub next: u32,
    /// Which part holds its vertices.
    pub part: u32,
    /// Whether it goes on from another piece, or from itself.
    pub follows: bool,
    /// Whether it is in a chain already.
    pub taken: bool,
}

/// The crossings of a row's left pairs, seen from the band above or below: which piece begins or
/// ends with each.
#[derive(Debug, Clone, Default)]
pub(super) struct Border {
    pub heads: Vec<u32>,
    pub tails: Vec<u32>,
    /// Whether the crossing runs up (kept on the upper side only).
    pub runs_up: Vec<bool>,
}

impl Border {
    pub fn clear(&mut self, count: usize) {
        for ends in [&mut self.heads, &mut self.tails] {
            ends.clear();
            ends.resize(count, NONE);
        }
    }

    pub fn shift(&mut self, by: u32) {
        let ends = self.heads.iter_mut().chain(&mut self.tails);
        ends.filter(|piece| **piece != NONE).for_each(|piece| *piece += by);
    }
}

/// Where a band's pieces go.
pub(super) struct Pieces<'a> {
    /// Vertices of all pieces; the list is longer than what is used of it.
    pub vertices: &'a mut Vec<Vertex>,
    pub used: &'a mut usize,
    pub pieces: &'a mut Vec<Piece>,
    pub top: &'a mut Border,
    pub bottom: &'a mut Border,
}

/// Follows all links of a band: open pieces from their heads, then loops.
#[inline(always)]
pub(super) fn trace(band: &mut Band, out: &mut Pieces<'_>) {
    out.top.clear(band.guests);
    out.bottom.clear(band.last_row.len());
    let room = *out.used + band.count;
    if out.vertices.len() < room {
        out.vertices.reserve(room / 2);
        out.vertices.resize(room, Vertex::default());
    }
    let (Some(vertices), Some(next), Some(marks)) = (
        band.vertices.get(..band.count),
        band.next.get(..band.count),
        band.marks.get_mut(..band.count),
    ) else {
        return;
    };
    let mut follow =
        Follow { vertices, next, marks, to: out.vertices.as_mut_slice(), at: *out.used };
    let mut taken = 0;
    for head in 0..band.count {
        if follow.marks[head] != HEAD {
            continue;
        }
        let start = follow.at;
        // Guests can only be ends; the band above has their vertices.
        let begin = if head < band.guests { follow.skip(head) } else { head };
        let (tail, count) = follow.chain(begin);
        let tail = if count == 0 { head } else { tail };
        taken += count + usize::from(head < band.guests);
        if tail < band.guests && count > 0 {
            follow.at -= 1;
        }
        let piece = out.pieces.len() as u32;
        note_ends(band.last_row.start, (head, tail), piece, (&mut *out.top, &mut *out.bottom));
        let (len, start, level) = ((follow.at - start) as u32, start as u32, band.levels[head]);
        out.pieces.push(Piece {
            start,
            len,
            level,
            next: NONE,
            part: 0,
            follows: false,
            taken: false,
        });
    }
    for first in 0..band.count {
        if taken == band.count {
            break;
        }
        if follow.marks[first] == FOLLOWS {
            let start = follow.at;
            taken += follow.chain(first).1;
            let piece = out.pieces.len() as u32;
            let (len, start, level) =
                ((follow.at - start) as u32, start as u32, band.levels[first]);
            out.pieces.push(Piece {
                start,
                len,
                level,
                next: piece,
                part: 0,
                follows: true,
                taken: false,
            });
        }
    }
    *out.used = follow.at;
}

/// Follows links and copies what they pass.
struct Follow<'a> {
    vertices: &'a [Vertex],
    next: &'a [u32],
    marks: &'a mut [u8],
    to: &'a mut [Vertex],
    at: usize,
}

impl Follow<'_> {
    /// Takes the crossings from one to where nothing follows or all is taken; returns the last one
    /// and their number.
    #[inline(always)]
    fn chain(&mut self, first: usize) -> (usize, usize) {
        let start = self.at;
        let mut last = first;
        let mut at = first;
        // NONE is beyond every list.
        while let (Some(vertex), Some(mark), Some(place)) =
            (self.vertices.get(at), self.marks.get_mut(at), self.to.get_mut(self.at))
        {
            if *mark == TAKEN {
                break;
            }
            *mark = TAKEN;
            *place = *vertex;
            self.at += 1;
            last = at;
            at = self.next[at] as usize;
        }
        (last, self.at - start)
    }

    /// Takes a crossing without copying it; returns the one that follows.
    #[inline(always)]
    fn skip(&mut self, guest: usize) -> usize {
        self.marks[guest] = TAKEN;
        self.next[guest] as usize
    }
}

#[inline(always)]
fn note_ends(
    first: usize,
    (head, tail): (usize, usize),
    piece: u32,
    (top, bottom): (&mut Border, &mut Border),
) {
    if let Some(end) = top.heads.get_mut(head) {
        *end = piece;
    }
    if let Some(end) = top.tails.get_mut(tail) {
        *end = piece;
    }
    if let Some(end) = bottom.heads.get_mut(head.wrapping_sub(first)) {
        *end = piece;
    }
    if let Some(end) = bottom.tails.get_mut(tail.wrapping_sub(first)) {
        *end = piece;
    }
}

/// Joins the pieces that meet at a row's left pairs.
pub(super) fn stitch(pieces: &mut [Piece], upper: &Border, lower: &Border) {
    for (k, runs_up) in upper.runs_up.iter().enumerate() {
        // A curve that runs up comes from the lower band's tail and goes on with the upper's head.
        let (below, above) = if *runs_up {
            (lower.tails[k], upper.heads[k])
        } else {
            (lower.heads[k], upper.tails[k])
        };
        if pieces[below as usize].len == 0 {
            // Nothing but the guest: the curve ends or begins here.
            let guest = &mut pieces[below as usize];
            (guest.follows, guest.taken) = (true, true);
            continue;
        }
        let (from, to) = if *runs_up { (below, above) } else { (above, below) };
        pieces[from as usize].next = to;
        pieces[to as usize].follows = true;
    }
}
