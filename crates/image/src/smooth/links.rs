//! Which pixels of a window belong to the same surface as its centre.

use super::lanes::{LANES, MOST, Native};
use crate::tuning::{HALF_WINDOW, WINDOW_COLUMNS};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, u32x8};

/// For each row of the window, the pixels that are connected to each lane's centre; bit `k` is
/// column offset `k − HALF_WINDOW`.
pub(super) type Connected<S> = [u32x8<S>; WINDOW_COLUMNS];

/// The bits of a row whose pairs are all unbroken, over the windows of all [`LANES`].
const UNBROKEN: u32 = (1 << (WINDOW_COLUMNS + LANES - 1)) - 1;

/// The unbroken pairs of an image, one bit each, with room for a window around every pixel.
#[derive(Debug)]
pub(super) struct Links {
    words: usize,
    /// Bit `col + HALF_WINDOW` of row `row + HALF_WINDOW`: unbroken with the pixel to the left.
    left: Vec<u64>,
    /// The same for the pixel above.
    up: Vec<u64>,
}

impl Links {
    /// No unbroken pair.
    pub fn new(rows: usize, cols: usize) -> Self {
        // One word more than the columns need, so that a window may be read across words.
        let words = (cols + 2 * HALF_WINDOW) / 64 + 2;
        let none = vec![0; words * (rows + 2 * HALF_WINDOW)];
        Self { words, left: none.clone(), up: none }
    }

    /// Takes the pairs of a row of the image with the pixels to the left and above, one bit each.
    /// Beyond either side, `beyond` columns are there once more.
    pub fn set_row(&mut self, row: usize, bits: [&[u64]; 2], (cols, beyond): (usize, usize)) {
        let line = (row + HALF_WINDOW) * self.words..(row + HALF_WINDOW + 1) * self.words;
        for (all, bits) in [&mut self.left, &mut self.up].into_iter().zip(bits) {
            let line = &mut all[line.clone()];
            for (at, bits) in bits.iter().enumerate() {
                line[at] |= bits << HALF_WINDOW;
                line[at + 1] |= bits >> (64 - HALF_WINDOW);
            }
            for k in 0..beyond {
                copy(line, HALF_WINDOW + cols - beyond + k, HALF_WINDOW - beyond + k);
                copy(line, HALF_WINDOW + k, HALF_WINDOW + cols + k);
            }
        }
    }

    /// Words of a row.
    pub fn words(&self) -> usize {
        self.words
    }

    /// The pixels of a row of the image that have a neighbour of their surface in the row and one
    /// in the column, one bit per place.
    pub fn paired(&self, row: usize, found: &mut [u64]) {
        let start = (row + HALF_WINDOW) * self.words;
        for (word, found) in found.iter_mut().enumerate() {
            let at = start + word;
            let next = if word + 1 < self.words { self.left[at + 1] << 63 } else { 0 };
            let along = self.left[at] | self.left[at] >> 1 | next;
            *found = along & (self.up[at] | self.up[at + self.words]);
        }
    }

    /// The places of a row of the image that are joined to no neighbour, while those on either side
    /// across are joined to the next ones; and the same down the column.
    pub fn lone(&self, row: usize, found: &mut [[u64; 2]]) {
        let rows = |k: usize| &self.up[(row + HALF_WINDOW + k - 1) * self.words..][..self.words];
        let [before, here, after, beyond] = [0, 1, 2, 3].map(rows);
        let left = &self.left[(row + HALF_WINDOW) * self.words..][..self.words];
        for (word, found) in found.iter_mut().enumerate() {
            let earlier = if word > 0 { left[word - 1] >> 63 } else { 0 };
            let next = left.get(word + 1).copied().unwrap_or_default();
            let at = left[word];
            let alone = !(at | at >> 1 | next << 63 | here[word] | after[word]);
            let across = (at << 1 | earlier) & (at >> 2 | next << 62);
            *found = [alone & across, alone & before[word] & beyond[word]];
        }
    }

    /// Whether a place and the one to the left are joined.
    pub fn left(&self, row: usize, col: usize) -> bool {
        self.bit(&self.left, row, col)
    }

    /// Whether a place and the one above are joined.
    pub fn up(&self, row: usize, col: usize) -> bool {
        self.bit(&self.up, row, col)
    }

    fn bit(&self, bits: &[u64], row: usize, col: usize) -> bool {
        bits[row * self.words + col / 64] >> (col % 64) & 1 == 1
    }

    /// The pixels connected to each of [`LANES`] pixels of a row by ways that go up, or down,
    /// without turning back.
    ///
    /// A way around a corner of the surface would add the surface behind it. Rows beyond `reach`
    /// are left out.
    #[inline(always)]
    pub fn connected<S: Simd>(
        &self,
        simd: S,
        (row, col): (usize, usize),
        reach: usize,
    ) -> Connected<S> {
        // All lanes' windows side by side, each within bits of its own.
        let lanes = u32x8::load_array(simd, std::array::from_fn(|lane| lane as u32));
        let windows = u32x8::splat(simd, (1 << WINDOW_COLUMNS) - 1) << lanes;
        let up = |k: usize| u32x8::splat(simd, self.bits(&self.up, row + k, col));
        let fill = |seen: u32x8<S>, k: usize| {
            joined(simd, seen, self.bits(&self.left, row + k, col), windows)
        };
        let mut connected = [u32x8::splat(simd, 0); WINDOW_COLUMNS];
        connected[HALF_WINDOW] = fill(u32x8::splat(simd, 1 << HALF_WINDOW) << lanes, HALF_WINDOW);
        for k in HALF_WINDOW + 1..=HALF_WINDOW + reach {
            connected[k] = fill(connected[k - 1] & up(k), k);
        }
        for k in (HALF_WINDOW - reach..HALF_WINDOW).rev() {
            connected[k] = fill(connected[k + 1] & up(k + 1), k);
        }
        connected.map(|row| row >> lanes)
    }

    /// The same for as many pixels as are fitted together, [`MOST`] places per row; and the columns
    /// that are connected to any of those pixels that count.
    #[inline(always)]
    pub fn windows<S: Simd>(
        &self,
        simd: S,
        (row, col): (usize, usize),
        reach: usize,
        counts: &[bool; MOST],
        windows: &mut [[u32; MOST]; WINDOW_COLUMNS],
    ) -> [u32; WINDOW_COLUMNS] {
        const { assert!(MOST.is_multiple_of(LANES)) };
        let mut seen = [0; WINDOW_COLUMNS];
        for first in (0..Native::<S>::LEN).step_by(LANES) {
            let connected = self.connected(simd, (row, col + first), reach);
            let counts = std::array::from_fn(|lane| if counts[first + lane] { !0 } else { 0 });
            let counts = u32x8::load_array(simd, counts);
            for k in HALF_WINDOW - reach..=HALF_WINDOW + reach {
                connected[k].store_slice(&mut windows[k][first..first + LANES]);
                let any = (connected[k] & counts).to_array();
                seen[k] |= any.into_iter().fold(0, |any, columns| any | columns);
            }
        }
        seen
    }

    /// The bits of a padded row in the windows around some columns of the image.
    #[inline(always)]
    fn bits(&self, bits: &[u64], padded_row: usize, col: usize) -> u32 {
        const { assert!(WINDOW_COLUMNS + LANES <= 32) };
        let at = padded_row * self.words + col / 64;
        // Two shifts, since one by 64 would be none.
        let beyond = bits[at + 1] << 1 << (63 - col % 64);
        (bits[at] >> (col % 64) | beyond) as u32
    }
}

/// Sets a bit where another one is set.
fn copy(bits: &mut [u64], from: usize, to: usize) {
    bits[to / 64] |= (bits[from / 64] >> (from % 64) & 1) << (to % 64);
}

/// The pixels of each lane's window that unbroken pairs of the row join to the given ones.
#[inline(always)]
fn joined<S: Simd>(simd: S, seen: u32x8<S>, left: u32, windows: u32x8<S>) -> u32x8<S> {
    // In most rows no pair is broken: one pixel that is seen joins the whole window.
    if left & UNBROKEN == UNBROKEN {
        let none = u32x8::splat(simd, 0);
        return seen.simd_eq(none).select(none, windows);
    }
    spread(seen, u32x8::splat(simd, left) & windows) & windows
}

/// All pixels of a row that unbroken pairs join to the given ones.
#[inline(always)]
fn spread<S: Simd>(seen: u32x8<S>, left: u32x8<S>) -> u32x8<S> {
    // Doubling steps: after each, `right` and `back` tell over which ever longer stretches all
    // pairs are unbroken.
    let (mut right, mut back) = (left, left >> 1);
    let (mut upward, mut downward) = (seen, seen);
    for step in [1, 2, 4, 8, 16] {
        upward |= right & (upward << step);
        downward |= back & (downward >> step);
        right &= right << step;
        back &= back >> step;
    }
    upward | downward
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    /// The window of a pixel, which its seven neighbours to the left must see the same.
    fn first_window(links: &Links, row: usize, col: usize) -> [u32; WINDOW_COLUMNS] {
        let window = |first: usize, lane: usize| dispatch!(Level::new(), simd => links.connected(simd, (row, first), HALF_WINDOW).map(|r| r[lane]));
        let found = window(col, 0);
        for lane in 1..LANES.min(col + 1) {
            assert_eq!(window(col - lane, lane), found, "lane {lane}");
        }
        found
    }

    #[test]
    fn rows_fill_up_to_broken_pairs() {
        let cases = [
            (0b0001_0000, 0b0111_1000, 0b0111_1100),
            (0b0000_0001, 0, 1),
            (1 << 7, 0x7fff, 0x7fff),
            (1, (1 << WINDOW_COLUMNS) - 1, (1 << WINDOW_COLUMNS) - 1),
            (1 << (WINDOW_COLUMNS - 1), (1 << WINDOW_COLUMNS) - 1, (1 << WINDOW_COLUMNS) - 1),
            (0, 0x7fff, 0),
        ];
        for (seen, left, expected) in cases {
            let found = dispatch!(Level::new(), simd => {
                spread(u32x8::splat(simd, seen), u32x8::splat(simd, left)).to_array()
            });
            assert_eq!(found, [expected; LANES]);
        }
    }

    /// The short way for rows without a broken pair against the doubling steps.
    #[test]
    fn unbroken_rows_join_the_same_pixels() {
        for seen in [0, 1, 1 << HALF_WINDOW, 0b1010 << HALF_WINDOW, 1 << (WINDOW_COLUMNS - 1)] {
            for left in [UNBROKEN, !0, UNBROKEN & !(1 << 12), UNBROKEN >> 1] {
                let [found, expected] = dispatch!(Level::new(), simd => {
                    let lanes = u32x8::load_array(simd, std::array::from_fn(|lane| lane as u32));
                    let windows = u32x8::splat(simd, (1 << WINDOW_COLUMNS) - 1) << lanes;
                    let seen = u32x8::splat(simd, seen) << lanes;
                    let slow = spread(seen, u32x8::splat(simd, left) & windows) & windows;
                    [joined(simd, seen, left, windows), slow].map(|lanes| lanes.to_array())
                });
                assert_eq!(found, expected, "{seen:b} {left:b}");
            }
        }
    }

    #[test]
    fn windows_reach_across_words_and_stop_at_jumps() {
        let (rows, cols) = (26, 150);
        let mut links = Links::new(rows, cols);
        // A wall of broken pairs left of column 66.
        let left = [u64::MAX - 1, u64::MAX - 4, (1 << 22) - 1];
        let all = [u64::MAX, u64::MAX, (1 << 22) - 1];
        for row in 0..rows {
            let up = if row > 0 { all } else { [0; 3] };
            links.set_row(row, [&left, &up], (cols, 0));
        }
        for (col, lowest) in [(64, 0), (66, HALF_WINDOW), (67, HALF_WINDOW - 1)] {
            let window = first_window(&links, 12, col);
            let highest = if col < 66 { 65 - col + HALF_WINDOW } else { WINDOW_COLUMNS - 1 };
            let expected = (1 << (highest + 1)) - (1 << lowest);
            assert_eq!(window, [expected; WINDOW_COLUMNS], "column {col}: {window:x?}");
        }
        let corner = first_window(&links, 0, 0);
        assert_eq!(corner[..HALF_WINDOW], [0; HALF_WINDOW]);
        assert_eq!(
            corner[HALF_WINDOW..],
            [(1 << WINDOW_COLUMNS) - (1 << HALF_WINDOW); HALF_WINDOW + 1]
        );
    }
}
