//! Which pixels may get the fit without robust weights, and what has to be known around them for that.
//!
//! Small windows, breaks of the surface and missing pixels rule out most of some images before any sum is
//! found. What is left is looked at in blocks of pixels side by side: residuals as far around a candidate
//! as they have a say in it, and sums along rows as far as the windows of those.

use super::calm::LOOKED;
use crate::smooth::REACH;
use crate::smooth::lanes::LANES;

/// Rows of flags, one per block of [`LANES`] columns.
#[derive(Debug)]
pub(super) struct Candidates {
    width: usize,
    /// Row-major, as the scales.
    pixels: Vec<bool>,
    /// Blocks that hold residuals which count for a candidate; one more before and after those of a row.
    looked: Vec<bool>,
    /// Those that hold a pixel in the window of one of these.
    windows: Vec<bool>,
}

impl Candidates {
    /// Of an image whose rows are filled up to a width, from the columns of each row's candidates; `wraps`
    /// tells whether columns make a full circle.
    pub fn new<C: Iterator<Item = usize>>(
        (rows, cols, width): (usize, usize, usize),
        wraps: bool,
        of_row: impl Fn(usize) -> C,
    ) -> Self {
        let stride = width / LANES + 2;
        let mut pixels = vec![false; rows * width];
        let mut near = vec![false; rows * stride];
        for (row, (pixels, near)) in
            pixels.chunks_exact_mut(width).zip(near.chunks_exact_mut(stride)).enumerate()
        {
            for col in of_row(row) {
                pixels[col] = true;
                mark(near, col, wraps.then_some(cols));
            }
        }
        let looked = above_and_below(&near, stride, LOOKED);
        let windows = above_and_below(&looked, stride, REACH);
        Self { width, pixels, looked, windows }
    }

    pub fn any(&self) -> bool {
        self.looked.contains(&true)
    }

    /// Leaves what is set for candidates.
    #[inline(always)]
    pub fn retain(&self, flags: &mut [bool]) {
        flags.iter_mut().zip(&self.pixels).for_each(|(flag, pixel)| *flag &= pixel);
    }

    /// First columns of the blocks of a row whose residuals count.
    pub fn looked(&self, row: usize) -> impl Iterator<Item = usize> {
        let blocks = self.looked_at(row);
        columns(&blocks[1..blocks.len() - 1])
    }

    /// The same as flags, with the blocks before and after the row.
    pub fn looked_at(&self, row: usize) -> &[bool] {
        let stride = self.width / LANES + 2;
        &self.looked[row * stride..(row + 1) * stride]
    }

    /// First columns of the blocks of a row that are in windows around those.
    pub fn in_windows(&self, row: usize) -> impl Iterator<Item = usize> {
        let stride = self.width / LANES + 2;
        columns(&self.windows[row * stride + 1..(row + 1) * stride - 1])
    }
}

fn columns(blocks: &[bool]) -> impl Iterator<Item = usize> {
    let marked = blocks.iter().enumerate().filter(|(_, marked)| **marked);
    marked.map(|(block, _)| block * LANES)
}

/// Marks the blocks in which residuals count for a pixel; `cols` is what a full circle has.
fn mark(near: &mut [bool], col: usize, cols: Option<usize>) {
    const { assert!(LOOKED <= LANES) };
    let (first, last) = ((col + LANES - LOOKED) / LANES, (col + LANES + LOOKED) / LANES);
    near[first..=last].fill(true);
    // Across the seam, too, where the residuals themselves are, and beyond it as seen from there.
    let Some(cols) = cols else { return };
    if col < LOOKED {
        near[(cols + col - LOOKED) / LANES + 1..=(cols + LOOKED - 1) / LANES + 1].fill(true);
    }
    if col + LOOKED >= cols {
        near[..=(col + LOOKED - cols) / LANES + 1].fill(true);
    }
}

/// What is marked in any row up to some rows away.
fn above_and_below(marked: &[bool], stride: usize, away: usize) -> Vec<bool> {
    let rows = marked.len() / stride;
    let mut all = vec![false; marked.len()];
    for (row, marked) in marked.chunks_exact(stride).enumerate() {
        if marked.contains(&true) {
            let (first, end) = (row.saturating_sub(away), (row + away + 1).min(rows));
            for all in all[first * stride..end * stride].chunks_exact_mut(stride) {
                all.iter_mut().zip(marked).for_each(|(all, marked)| *all |= marked);
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_around_a_candidate_are_marked_across_the_seam_of_a_full_circle() {
        let (rows, cols, width) = (60, 43, 48);
        for wraps in [false, true] {
            for (row, col) in [(30, 0), (30, 20), (5, 42), (59, 38)] {
                let of_row = |r: usize| (r == row).then_some(col).into_iter();
                let candidates = Candidates::new((rows, cols, width), wraps, of_row);
                assert!(candidates.any());
                let mut flags = vec![true; rows * width];
                candidates.retain(&mut flags);
                assert_eq!(flags.iter().position(|flag| *flag), Some(row * width + col));
                for r in 0..rows {
                    let looked: Vec<_> = candidates.looked(r).collect();
                    let in_windows: Vec<_> = candidates.in_windows(r).collect();
                    for c in 0..cols {
                        let across = c.abs_diff(col);
                        let across = if wraps { across.min(cols - across) } else { across };
                        let (down, block) = (r.abs_diff(row), c / LANES * LANES);
                        let near = across <= LOOKED;
                        assert!(!(near && down <= LOOKED) || looked.contains(&block));
                        assert!(!(near && down <= LOOKED + REACH) || in_windows.contains(&block));
                        assert!(across < LOOKED + LANES || !in_windows.contains(&block));
                    }
                }
            }
        }
        assert!(!Candidates::new((rows, cols, width), true, |_| 0..0).any());
    }
}
