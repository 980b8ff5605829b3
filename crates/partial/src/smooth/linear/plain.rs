//! Where a window holds samples of one surface and nothing else.

use crate::smooth::REACH;
use crate::smooth::grid::Grid;

/// How many pixels that break a surface are above and to the left of each place. Counts begin again at 0
/// beyond the last number; no window holds so many.
#[derive(Debug)]
pub(super) struct Plain {
    rows: usize,
    /// Places of a row, and one.
    stride: usize,
    sums: Vec<u16>,
}

impl Plain {
    /// `filled` tells the missing pixels that count as samples, one bit each, as in [`Grid::links`].
    pub fn new(grid: &Grid<'_>, rows: usize, cols: usize, filled: &[u64]) -> Self {
        let stride = cols + 2 * REACH + 1;
        let mut sums = vec![0_u16; stride * (rows + 1)];
        let mut breaks = vec![0; grid.links.words()];
        for row in 0..rows {
            grid.links.breaks(row, filled, &mut breaks);
            let (above, here) = sums.split_at_mut((row + 1) * stride);
            let above = &above[row * stride..];
            let mut count = 0_u16;
            for (place, (here, above)) in here[1..stride].iter_mut().zip(&above[1..]).enumerate() {
                let here_breaks = (breaks[place / 64] >> (place % 64) & 1) as u16;
                count = count.wrapping_add(here_breaks);
                *here = above.wrapping_add(count);
            }
        }
        Self { rows, stride, sums }
    }

    /// Whether nothing breaks the surface within some rows and columns of a pixel.
    pub fn around(&self, (row, col): (usize, usize), (rows, cols): (usize, usize)) -> bool {
        if row < rows || row + rows >= self.rows {
            return false;
        }
        let (left, right) = (col + REACH - cols, col + REACH + cols + 1);
        let sum = |row: usize, place: usize| self.sums[row * self.stride + place];
        let (top, bottom) = (row - rows, row + rows + 1);
        let down = |place| sum(bottom, place).wrapping_sub(sum(top, place));
        down(right) == down(left)
    }
}
