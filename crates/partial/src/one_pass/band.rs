//! The crossings of a few rows, numbered as they are found, and which follows which.
//!
//! A band is small enough for the processor's cache, so following its links costs little. It begins
//! with the left pairs of the row before it, its *guests*, which belong to the band above.

use super::contours::Vertex;

/// No crossing, no piece.
pub(super) const NONE: u32 = u32::MAX;

/// Nothing leads to the crossing.
pub(super) const HEAD: u8 = 0;
/// Another crossing leads to it.
pub(super) const FOLLOWS: u8 = 1;
/// It is in a piece.
pub(super) const TAKEN: u8 = 2;

/// Crossings in order of emission: guests, then per row upward pairs, left pairs, diagonals.
#[derive(Debug, Clone, Default)]
pub(super) struct Band {
    pub vertices: Vec<Vertex>,
    /// Level from the base plane.
    pub levels: Vec<i32>,
    /// Number of the crossing that follows, or [`NONE`].
    pub next: Vec<u32>,
    /// [`HEAD`], [`FOLLOWS`] or [`TAKEN`].
    pub marks: Vec<u8>,
    /// How many crossings at the beginning are guests.
    pub guests: usize,
    /// Numbers of the left pairs' crossings of the last row.
    pub last_row: std::ops::Range<usize>,
}

impl Band {
    /// Makes room for more crossings; the first of them has the number that is returned.
    pub fn grow(&mut self, count: usize) -> usize {
        let first = self.vertices.len();
        let new = first + count;
        self.vertices.resize(new, Vertex::default());
        self.levels.resize(new, 0);
        self.next.resize(new, NONE);
        self.marks.resize(new, HEAD);
        first
    }

    /// Empties the band for the rows after a row that has a number of left crossings.
    pub fn restart(&mut self, guests: usize) {
        self.vertices.clear();
        self.levels.clear();
        self.next.clear();
        self.marks.clear();
        self.guests = guests;
        self.last_row = 0..guests;
        self.grow(guests);
    }
}
