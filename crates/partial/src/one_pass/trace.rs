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
    pub vertices: &'a mut Vec<Vertex>,
    pub pieces: &'a mut Vec<Piece>,
    pub top: &'a mut Border,
    pub bottom: &'a mut Border,
}

/// Follows all links of a band: open pieces from their heads, then loops.
pub(super) fn trace(band: &mut Band, out: &mut Pieces<'_>) {
    out.top.clear(band.guests);
    out.bottom.clear(band.last_row.len());
    out.vertices.reserve(band.count);
    let mut taken = 0;
    for head in 0..band.count {
        if band.marks[head] == HEAD {
            taken += follow(band, head, out);
        }
    }
    if taken < band.count {
        for first in 0..band.count {
            if band.marks[first] == FOLLOWS {
                follow_loop(band, first, out);
            }
        }
    }
}

/// Takes the piece that begins with a crossing; returns how many crossings it has, guests included.
fn follow(band: &mut Band, head: usize, out: &mut Pieces<'_>) -> usize {
    let (piece, start) = (out.pieces.len() as u32, out.vertices.len());
    // Guests can only be ends; the band above has their vertices.
    if head >= band.guests {
        out.vertices.push(band.vertices[head]);
    }
    band.marks[head] = TAKEN;
    let (mut tail, mut count) = (head, 1);
    while band.next[tail] != NONE {
        tail = band.next[tail] as usize;
        band.marks[tail] = TAKEN;
        out.vertices.push(band.vertices[tail]);
        count += 1;
    }
    if tail < band.guests && tail != head {
        out.vertices.pop();
    }
    note_ends(band, (head, tail), piece, out);
    let len = (out.vertices.len() - start) as u32;
    let (start, level) = (start as u32, band.levels[head]);
    out.pieces.push(Piece { start, len, level, next: NONE, part: 0, follows: false, taken: false });
    count
}

#[inline(always)]
fn note_ends(band: &Band, (head, tail): (usize, usize), piece: u32, out: &mut Pieces<'_>) {
    if let Some(end) = out.top.heads.get_mut(head) {
        *end = piece;
    }
    if let Some(end) = out.top.tails.get_mut(tail) {
        *end = piece;
    }
    let first = band.last_row.start;
    if let Some(end) = out.bottom.heads.get_mut(head.wrapping_sub(first)) {
        *end = piece;
    }
    if let Some(end) = out.bottom.tails.get_mut(tail.wrapping_sub(first)) {
        *end = piece;
    }
}

fn follow_loop(band: &mut Band, first: usize, out: &mut Pieces<'_>) {
    let (piece, start) = (out.pieces.len() as u32, out.vertices.len());
    let mut at = first;
    while band.marks[at] == FOLLOWS {
        band.marks[at] = TAKEN;
        out.vertices.push(band.vertices[at]);
        at = band.next[at] as usize;
    }
    let len = (out.vertices.len() - start) as u32;
    let (start, level) = (start as u32, band.levels[first]);
    out.pieces.push(Piece { start, len, level, next: piece, part: 0, follows: true, taken: false });
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
