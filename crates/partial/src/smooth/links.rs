//! Which pixels of a window belong to the same surface as its centre.

use super::REACH;

/// Columns of a window.
pub(super) const WIDTH: usize = 2 * REACH + 1;

/// The pixels of a window that are connected to its centre; bit `k` is column offset `k − REACH`.
pub(super) type Connected = [u32; WIDTH];

/// The unbroken pairs of an image, one bit each, with room for a window around every pixel.
#[derive(Debug)]
pub(super) struct Links {
    words: usize,
    /// Bit `col + REACH` of row `row + REACH`: unbroken with the pixel to the left.
    left: Vec<u64>,
    /// The same for the pixel above.
    up: Vec<u64>,
}

impl Links {
    /// No unbroken pair.
    pub fn new(rows: usize, cols: usize) -> Self {
        // One word more than the columns need, so that a window may be read across words.
        let words = (cols + 2 * REACH) / 64 + 2;
        let none = vec![0; words * (rows + 2 * REACH)];
        Self { words, left: none.clone(), up: none }
    }

    /// Notes unbroken pairs of a pixel; `col` counts from `REACH` columns before the image.
    pub fn set(&mut self, row: usize, col: usize, left: bool, up: bool) {
        let at = (row + REACH) * self.words + col / 64;
        self.left[at] |= u64::from(left) << (col % 64);
        self.up[at] |= u64::from(up) << (col % 64);
    }

    /// The pixels connected to a pixel by ways that go up, or down, without turning back.
    ///
    /// A way round a corner of the surface would let in what lies beyond.
    pub fn connected(&self, row: usize, col: usize) -> Connected {
        let mut connected = [0; WIDTH];
        let left = |k: usize| self.window(&self.left, row + k, col);
        let up = |k: usize| self.window(&self.up, row + k, col);
        connected[REACH] = spread(1 << REACH, left(REACH));
        for k in REACH + 1..WIDTH {
            connected[k] = spread(connected[k - 1] & up(k), left(k));
        }
        for k in (0..REACH).rev() {
            connected[k] = spread(connected[k + 1] & up(k + 1), left(k));
        }
        connected
    }

    /// The bits of a padded row in the window around a column of the image.
    fn window(&self, bits: &[u64], padded_row: usize, col: usize) -> u32 {
        let at = padded_row * self.words + col / 64;
        let both = u128::from(bits[at]) | u128::from(bits[at + 1]) << 64;
        (both >> (col % 64)) as u32 & ((1 << WIDTH) - 1)
    }
}

/// All pixels of a row that unbroken pairs join to the given ones.
fn spread(mut seen: u32, left: u32) -> u32 {
    if seen == 0 {
        return 0;
    }
    // Doubling steps: after each, `right` and `back` tell over which ever longer stretches all
    // pairs are unbroken.
    let (mut right, mut back) = (left, left >> 1);
    let (mut upward, mut downward) = (seen, seen);
    for step in [1, 2, 4, 8] {
        upward |= right & (upward << step);
        downward |= back & (downward >> step);
        right &= right << step;
        back &= back >> step;
    }
    seen |= upward | downward;
    seen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_fill_up_to_broken_pairs() {
        assert_eq!(spread(0b0001_0000, 0b0111_1000), 0b0111_1100);
        assert_eq!(spread(0b0000_0001, 0), 1);
        assert_eq!(spread(1 << 7, 0x7fff), 0x7fff);
        assert_eq!(spread(0, 0x7fff), 0);
    }

    #[test]
    fn windows_reach_across_words_and_stop_at_jumps() {
        let (rows, cols) = (20, 150);
        let mut links = Links::new(rows, cols);
        for row in 0..rows {
            for col in 0..cols {
                // A wall of broken pairs left of column 66.
                links.set(row, col + REACH, col > 0 && col != 66, row > 0);
            }
        }
        for (col, lowest) in [(64, 0), (66, REACH), (67, REACH - 1)] {
            let window = links.connected(10, col);
            let highest = if col < 66 { 65 - col + REACH } else { WIDTH - 1 };
            let expected = (1 << (highest + 1)) - (1 << lowest);
            assert_eq!(window, [expected; WIDTH], "column {col}: {window:x?}");
        }
        let corner = links.connected(0, 0);
        assert_eq!(corner[..REACH], [0; REACH]);
        assert_eq!(corner[REACH..], [(1 << WIDTH) - (1 << REACH); REACH + 1]);
    }
}
