//! The crossings of a few rows, numbered as they are found, and which follows which.
//!
//! A band is small enough for the processor's cache, so following its links costs little. It begins
//! with the left pairs of the row before it, its *guests*, which belong to the band above.

use super::vertex::Vertex;

/// No crossing, no piece.
pub(super) const NONE: u32 = u32::MAX;

/// Nothing leads to the crossing.
pub(super) const HEAD: u8 = 0;
/// Another crossing leads to it.
pub(super) const FOLLOWS: u8 = 1;
/// It is in a piece.
pub(super) const TAKEN: u8 = 2;

/// Crossings in order of emission: guests, then per row upward pairs, left pairs, diagonals.
///
/// The lists are longer than there are crossings, so that emission seldom has to make room.
#[derive(Debug, Clone, Default)]
pub(super) struct Band {
    pub vertices: Vec<Vertex>,
    /// Level from the base plane.
    pub levels: Vec<i32>,
    /// Number of the crossing that follows, or [`NONE`], as beyond the last crossing.
    pub next: Vec<u32>,
    /// [`HEAD`], as beyond the last crossing, [`FOLLOWS`] or [`TAKEN`].
    pub marks: Vec<u8>,
    /// How many crossings there are.
    pub count: usize,
    /// How many crossings at the beginning are guests.
    pub guests: usize,
    /// Numbers of the left pairs' crossings of the last row.
    pub last_row: std::ops::Range<usize>,
    /// How many there may be; beyond that, emission stops and `full` is set.
    pub limit: usize,
    pub full: bool,
}

/// Memory that a list holds, in bytes.
pub(super) fn capacity_bytes<T>(list: &Vec<T>) -> usize {
    list.capacity() * size_of::<T>()
}

impl Band {
    /// Memory it holds, in bytes.
    pub fn bytes(&self) -> usize {
        let Self { vertices, levels, next, marks, .. } = self;
        capacity_bytes(vertices)
            + capacity_bytes(levels)
            + capacity_bytes(next)
            + capacity_bytes(marks)
    }

    /// Makes room for crossings up to a number; false beyond the limit.
    #[inline(always)]
    pub fn reach(&mut self, count: usize) -> bool {
        count <= self.vertices.len() || self.grow(count)
    }

    #[cold]
    fn grow(&mut self, count: usize) -> bool {
        if count > self.limit {
            self.full = true;
            return false;
        }
        let len = (count + count / 2).max(1 << 12);
        self.vertices.resize(len, Vertex::default());
        self.levels.resize(len, 0);
        self.next.resize(len, NONE);
        self.marks.resize(len, HEAD);
        true
    }

    /// Empties the band for the rows after a row that has a number of left crossings.
    pub fn restart(&mut self, guests: usize, limit: usize) {
        if let (Some(next), Some(marks)) =
            (self.next.get_mut(..self.count), self.marks.get_mut(..self.count))
        {
            next.fill(NONE);
            marks.fill(HEAD);
        }
        (self.limit, self.full, self.count) = (limit, false, 0);
        self.last_row = 0..guests;
        self.guests = guests;
        if self.reach(guests) {
            self.count = guests;
        }
    }
}
