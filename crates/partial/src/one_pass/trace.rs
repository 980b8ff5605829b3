//! From links to pieces: what a band holds of each curve, its vertices in order.

use super::band::{Band, FOLLOWS, NONE, TAKEN, capacity_bytes};
use super::vertex::Vertex;

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
    /// Memory it holds, in bytes.
    pub fn bytes(&self) -> usize {
        let Self { heads, tails, runs_up } = self;
        capacity_bytes(heads) + capacity_bytes(tails) + capacity_bytes(runs_up)
    }

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
    /// How many vertices the part will have, from those of its rows so far.
    pub expected: usize,
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
        // Once and for all, if the rest of the rows is like those so far: new memory costs as much
        // as the work itself.
        out.vertices.reserve_exact(out.expected.max(room + room / 4) - out.vertices.len());
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
    for first in (0..count).step_by(8) {
        // Heads are the bytes without a bit; there are no others while open chains are followed.
        let word = follow.eight(first);
        let mut heads = !(word | word >> 1) & ONES;
        while heads != 0 {
            let head = first + heads.trailing_zeros() as usize / 8;
            heads &= heads - 1;
            let (start, piece) = (follow.at, out.pieces.len() as u32);
            let tail = follow.open(head, band.guests, &mut taken);
            let borders = (&mut *out.top, &mut *out.bottom);
            note_ends(band.last_row.start, (head, tail), piece, borders);
            let level = levels.get(head).copied().unwrap_or_default();
            out.pieces.push(Piece::new(start..follow.at, level, NONE));
        }
    }
    let mut first = 0;
    while taken < count && first < count {
        let mut others = follow.eight(first) & ONES;
        while others != 0 {
            let begin = first + others.trailing_zeros() as usize / 8;
            others &= others - 1;
            if follow.marks.get(begin) == Some(&FOLLOWS) {
                let (start, piece) = (follow.at, out.pieces.len() as u32);
                taken += follow.chain(begin).1;
                let level = levels.get(begin).copied().unwrap_or_default();
                out.pieces.push(Piece::new(start..follow.at, level, piece));
            }
        }
        first += 8;
    }
    *out.used = follow.at;
}

/// One in each of eight bytes.
const ONES: u64 = 0x0101_0101_0101_0101;

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
    /// Eight marks, of which those beyond the last crossing are [`TAKEN`].
    #[inline(always)]
    fn eight(&self, first: usize) -> u64 {
        if let Some(marks) = self.marks.get(first..).and_then(|marks| marks.first_chunk()) {
            return u64::from_le_bytes(*marks);
        }
        let mut eight = [TAKEN; 8];
        for (mark, place) in self.marks.iter().skip(first).zip(&mut eight) {
            *place = *mark;
        }
        u64::from_le_bytes(eight)
    }

    /// Takes the crossings from one to where nothing follows or the first one does; returns the
    /// last one and their number.
    #[inline(always)]
    fn chain(&mut self, first: usize) -> (usize, usize) {
        let count = self.next.len();
        let (Some(vertices), Some(marks), Some(to)) =
            (self.vertices.get(..count), self.marks.get_mut(..count), self.to.get_mut(self.at..))
        else {
            return (first, 0);
        };
        let (mut at, mut last, mut length) = (first, first, 0);
        // NONE is beyond every list.
        for place in to {
            let Some(next) = self.next.get(at) else { break };
            marks[at] = TAKEN;
            *place = vertices[at];
            length += 1;
            last = at;
            at = *next as usize;
            if at == first {
                break;
            }
        }
        self.at += length;
        (last, length)
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
