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
    let (count, levels) = (band.count, band.levels.as_slice());
    let (Some(vertices), Some(next), Some(marks)) =
        (band.vertices.get(..count), band.next.get(..count), band.marks.get_mut(..count))
    else {
        return;
    };
    let to = out.vertices.as_mut_slice();
    let mut follow = Follow { vertices, next, marks, to, at: *out.used };
    let mut taken = 0;
    for (head, &level) in levels.iter().enumerate().take(count) {
        if follow.marks[head] == HEAD {
            let (start, piece) = (follow.at, out.pieces.len() as u32);
            let tail = follow.open(head, band.guests, &mut taken);
            let borders = (&mut *out.top, &mut *out.bottom);
            note_ends(band.last_row.start, (head, tail), piece, borders);
            out.pieces.push(Piece::new(start..follow.at, level, NONE));
        }
    }
    let mut first = 0;
    while taken < count && first < count {
        if follow.marks[first] == FOLLOWS {
            let (start, piece) = (follow.at, out.pieces.len() as u32);
            taken += follow.chain(first).1;
            out.pieces.push(Piece::new(start..follow.at, levels[first], piece));
        }
        first += 1;
    }
    *out.used = follow.at;
}

impl Piece {
    /// A piece of some vertices; a loop if it goes on with another than none, which is itself.
    fn new(vertices: std::ops::Range<usize>, level: i32, next: u32) -> Self {
        let (start, len) = (vertices.start as u32, vertices.len() as u32);
        Self { start, len, level, next, part: 0, follows: next != NONE, taken: false }
    }
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

    /// Takes the open chain that begins with a crossing; returns the last one.
    ///
    /// Guests can only be ends; they are not copied, since the band above has their vertices.
    #[inline(always)]
    fn open(&mut self, head: usize, guests: usize, taken: &mut usize) -> usize {
        let mut first = head;
        if head < guests {
            self.marks[head] = TAKEN;
            first = self.next[head] as usize;
            *taken += 1;
        }
        let (last, count) = self.chain(first);
        *taken += count;
        if count == 0 {
            return head;
        }
        if last < guests {
            self.at -= 1;
        }
        last
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
