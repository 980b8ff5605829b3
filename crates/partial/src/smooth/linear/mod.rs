//! The fit where robust weights would change nothing: fixed weights, along rows and then along columns.
//!
//! **Problem.** A robust fit visits every pixel of its window several times, which is nearly all that
//! smoothing costs. On most of an image residuals are noise, and weights that follow from them hardly
//! differ from one (and cost 5 % of the efficiency).
//!
//! **Idea.** With fixed weights a local polynomial fit is a convolution (Savitzky and Golay, 1964), and
//! if they are products of a weight of the row and one of the column, rows and columns are taken in
//! turn: two visits per row or column of the window instead of several per pixel of it.
//!
//! **Steps.**
//! 1. Window radii and noise of every pixel; see `../scales.rs`.
//! 2. Gaps one pixel wide are filled from up to eight samples around them; see `fill.rs`. Nobody sees
//!    those values but the windows around.
//! 3. Along rows, then along columns: the value at the centre of the parabola that is fitted with the
//!    weights of `kernel.rs`. Together that is the fit of all products of `1, x, x²` and `1, y, y²`. Every
//!    pixel has its own radii, to a sixteenth of a pixel. The same for the wider windows.
//! 4. What the fit left of the samples is looked at around every pixel: is it no more than noise, and has
//!    it no direction? A crease or a curvature that bends the fit shows there, where it does; see
//!    `calm.rs`.
//! 5. Pixels for which that is so, and in whose wider window nothing breaks the surface (`plain.rs`), get
//!    the better of both estimates by the rule for all. The others are left to the robust fit.
//!
//! Whether a pixel is among them follows from the image alone: not from what is wanted of it, nor from
//! how many pixels are taken side by side.
//!
//! **Departures from the robust fit.** Windows are squares instead of discs, as wide as gives the same
//! variance, and the polynomial has three terms more. A filled value is one of a parabola or cubic
//! through its neighbours, exact where the surface is one; it repeats their noise, of which the predicted
//! variance knows nothing: with 2 % of the pixels missing, results err by 0.95 of what is predicted,
//! without by 0.92. On noisy smooth surfaces both fits differ by 0.04 to 0.07 standard deviations of
//! a sample (root mean square), and neither is the better one by more than 3 %; on creases and steps
//! of any height the bias is up to 0.17 larger, where it is not left to the robust fit.
//!
//! **Cost.** Some 70 multiplications and additions per pixel where the radius is 4 pixels, and about as many
//! for step 4; steps 3 and 4 are for the blocks of pixels around those that may be taken at all, see
//! `candidates.rs`.

mod calm;
mod candidates;
mod convolve;
mod fill;
mod kernel;
mod plain;

use super::block::CUT;
use super::estimate::{Estimates, Fitted};
use super::lanes::LANES;
use super::output::Output;
use super::pairs::is_set;
use super::scales::Scales;
use super::{REACH, Smoother, window};
use calm::{Residuals, calm};
use candidates::Candidates;
use convolve::{around, load};
use fearless_simd::Simd;
use fearless_simd::prelude::*;
pub(super) use fill::Filled;
use kernel::Kernels;
pub(super) use kernel::{Radius, index_of};
use plain::Plain;

/// Largest change, in standard deviations, so that none is near a cut.
const LARGEST_CHANGE: f32 = 4.0;

/// Rows of sums along rows that are found before those down columns, so that the processor's cache holds them.
const STRIP: usize = 44;

/// Both estimates of every pixel, and where they hold.
#[derive(Debug)]
pub(super) struct Linear<'a> {
    scales: &'a Scales,
    kernels: Kernels,
    candidates: Candidates,
    /// Changes by the window, in standard deviations. Known around candidates.
    narrow: Residuals,
    /// The same by the wider window; row-major as the scales.
    wide: Vec<f32>,
    /// Candidates around which residuals are like noise; row-major as the scales.
    calm: Vec<bool>,
}

impl<'a> Linear<'a> {
    #[inline(always)]
    pub fn new<S: Simd>(
        simd: S,
        smoother: &'a Smoother<'_>,
        filled: &Filled,
        wanted: &[bool],
    ) -> Self {
        let (grid, scales) = (&smoother.samples.grid, &smoother.scales);
        let size = smoother.samples.view.image().size();
        let kernels = Kernels::new();
        let candidates = candidates_of(smoother, filled, wanted, &kernels);
        let narrow = Residuals::new(size.rows, scales.width);
        let mut linear =
            Self { calm: Vec::new(), scales, kernels, candidates, narrow, wide: Vec::new() };
        if linear.candidates.any() {
            linear.wide = vec![0.0; scales.inverse_sigma.len()];
            let cols = grid.wraps().then_some(size.cols);
            simd.vectorize(
                #[inline(always)]
                || linear.find_changes(simd, grid.quantities(), grid.stride(), cols),
            );
            linear.calm = simd.vectorize(
                #[inline(always)]
                || calm(simd, scales, &linear.narrow, cols, &linear.candidates),
            );
        }
        linear
    }

    /// Step 3, some rows at a time; `cols` is the number of columns that a full circle has.
    #[inline(always)]
    fn find_changes<S: Simd>(
        &mut self,
        simd: S,
        quantities: &[f32],
        stride: usize,
        cols: Option<usize>,
    ) {
        let width = self.scales.width;
        let rows = self.scales.inverse_sigma.len() / width;
        // Of the rows of a strip and of REACH rows above and below; none is beyond the image at first.
        let room = || vec![0.0; (STRIP + 2 * REACH) * width];
        let mut along = [room(), room()];
        let mut found = 0;
        for top in (0..rows).step_by(STRIP) {
            let end = (top + STRIP).min(rows);
            if top > 0 {
                along.iter_mut().for_each(|along| along.copy_within(STRIP * width.., 0));
            }
            for row in found..top + STRIP + REACH {
                let start = (row + REACH - top) * width;
                if row < rows {
                    self.along_row(simd, row, (quantities, stride), (&mut along, start));
                } else {
                    along.iter_mut().for_each(|along| along[start..start + width].fill(0.0));
                }
            }
            found = top + STRIP + REACH;
            for row in top..end {
                let sums = (&along, (row + REACH - top) * width);
                self.down_columns(simd, row, sums, (quantities, stride));
                self.narrow.close_row(row, cols);
            }
        }
    }

    /// Sums along a row, by the window and by the wider one.
    #[inline(always)]
    fn along_row<S: Simd>(
        &self,
        simd: S,
        row: usize,
        (quantities, stride): (&[f32], usize),
        (along, start): (&mut [Vec<f32>; 2], usize),
    ) {
        for col in self.candidates.in_windows(row) {
            let at = (row + REACH) * stride + REACH + col;
            let radii = self.radii(1, row * self.scales.width + col);
            let found = around(simd, &self.kernels, &radii, [quantities; 2], (at, 1));
            for (along, found) in along.iter_mut().zip(found) {
                found.store_slice(&mut along[start + col..start + col + LANES]);
            }
        }
    }

    #[inline(always)]
    fn radii(&self, axis: usize, pixel: usize) -> [Radius; LANES] {
        // Rows are filled up to whole blocks.
        self.scales.radii[axis][pixel..].first_chunk().copied().unwrap_or_default()
    }

    /// Sums of those down columns: the changes of a row's pixels.
    #[inline(always)]
    fn down_columns<S: Simd>(
        &mut self,
        simd: S,
        row: usize,
        ([narrow, wide], start): (&[Vec<f32>; 2], usize),
        (quantities, stride): (&[f32], usize),
    ) {
        let width = self.scales.width;
        for col in self.candidates.looked(row) {
            let pixel = row * width + col;
            let radii = self.radii(0, pixel);
            let at = (start + col, width);
            let [narrow, wide] = around(simd, &self.kernels, &radii, [narrow, wide], at);
            let sample = load(simd, quantities, (row + REACH) * stride + REACH + col);
            let scale = load(simd, &self.scales.inverse_sigma, pixel);
            ((narrow - sample) * scale).store_slice(self.narrow.of_mut(row, col));
            ((wide - sample) * scale).store_slice(&mut self.wide[pixel..pixel + LANES]);
        }
    }

    /// Step 5: puts into the image what becomes of the pixels that are wanted. Those of which it is not for
    /// this fit to say are given back.
    #[inline(always)]
    pub fn take<S: Simd>(
        &self,
        simd: S,
        smoother: &Smoother<'_>,
        wanted: &[bool],
        output: &mut Output,
    ) -> Vec<bool> {
        let image = smoother.samples.view.image();
        let cols = image.size().cols;
        let mut rest = vec![false; wanted.len()];
        for (row, (wanted, rest)) in wanted.chunks(cols).zip(rest.chunks_mut(cols)).enumerate() {
            simd.vectorize(
                #[inline(always)]
                || {
                    let known = self.known(row, wanted, (image.row(row), rest));
                    for (block, known) in known.chunks(LANES).enumerate() {
                        if !known.contains(&true) {
                            continue;
                        }
                        let first = row * cols + block * LANES;
                        let (fitted, radii) = self.block(simd, (row, block * LANES), known);
                        output.put(smoother.samples.quantity, first, &fitted, &radii);
                    }
                },
            );
        }
        rest
    }

    /// Which wanted pixels of a row this fit is to say something of; the rest is noted, too.
    #[inline(always)]
    fn known(
        &self,
        row: usize,
        wanted: &[bool],
        (values, rest): (&[f32], &mut [bool]),
    ) -> Vec<bool> {
        let mut known = vec![false; wanted.len()];
        if self.calm.is_empty() {
            let rest = rest.iter_mut().zip(wanted).zip(values);
            rest.for_each(|((rest, wanted), value)| *rest = wanted & !value.is_nan());
            return known;
        }
        let changes = self.narrow.of(row, 0);
        let calm = &self.calm[row * self.scales.width..];
        let pixels = wanted.iter().zip(values).zip(changes.iter().zip(calm));
        let out = known.iter_mut().zip(rest);
        for (((wanted, value), (change, calm)), (known, rest)) in pixels.zip(out) {
            let counts = wanted & !value.is_nan();
            *known = counts & calm & (change.abs() <= LARGEST_CHANGE);
            *rest = counts & !*known;
        }
        known
    }

    /// What becomes of those of a block's pixels that are known, and the radii of their windows.
    #[inline(always)]
    fn block<S: Simd>(
        &self,
        simd: S,
        (row, col): (usize, usize),
        known: &[bool],
    ) -> (Fitted<LANES>, [f32; LANES]) {
        let pixel = row * self.scales.width + col;
        let mut both = [Estimates::none(); 2];
        let changes = [(self.narrow.of(row, col), 0), (self.wide.as_slice(), pixel)];
        for (estimates, (changes, at)) in both.iter_mut().zip(changes) {
            (load(simd, changes, at) / CUT as f32).store_slice(&mut estimates.changes);
        }
        let mut inverse_cuts = [0.0; LANES];
        let scales = load(simd, &self.scales.inverse_sigma, pixel) / CUT as f32;
        scales.store_slice(&mut inverse_cuts);
        for (k, inverse_cut) in inverse_cuts.iter_mut().enumerate() {
            let known = known.get(k).is_some_and(|known| *known);
            *inverse_cut = if known { *inverse_cut } else { 0.0 };
        }
        let mut radii = self.windows([self.radii(0, pixel), self.radii(1, pixel)], &mut both);
        let [narrow, wide] = both;
        let fitted = narrow.fitted(simd, &wide, &inverse_cuts);
        for (radius, share) in radii.iter_mut().zip(fitted.shares) {
            *radius = window::between(*radius, share);
        }
        (fitted, radii)
    }

    /// The variances of a block's fits, and the radii of the windows.
    #[inline(always)]
    fn windows(
        &self,
        [rows, cols]: [[Radius; LANES]; 2],
        [narrow, wide]: &mut [Estimates<LANES>; 2],
    ) -> [f32; LANES] {
        let of = |k: usize| {
            let (down, across) = (self.kernels.of(rows[k]), self.kernels.of(cols[k]));
            let radius = (kernel::radius(rows[k]) * kernel::radius(cols[k])).sqrt();
            [down[0].variance * across[0].variance, down[1].variance * across[1].variance, radius]
        };
        let [first, second, radius] = of(0);
        (narrow.variances, wide.variances) = ([first; LANES], [second; LANES]);
        let mut radii = [radius; LANES];
        // Neighbours mostly share theirs.
        if rows != [rows[0]; LANES] || cols != [cols[0]; LANES] {
            for (k, radius) in radii.iter_mut().enumerate() {
                [narrow.variances[k], wide.variances[k], *radius] = of(k);
            }
        }
        radii
    }
}

/// The pixels that are wanted of an image and may get this fit.
fn candidates_of(
    smoother: &Smoother<'_>,
    filled: &Filled,
    wanted: &[bool],
    kernels: &Kernels,
) -> Candidates {
    let (grid, scales) = (&smoother.samples.grid, &smoother.scales);
    let size = smoother.samples.view.image().size();
    let plain = Plain::new(grid, size.rows, size.cols, &filled.0);
    let smallest = index_of(window::SMALLEST);
    let may_be = |row: usize, col: usize| {
        let pixel = row * scales.width + col;
        let [rows, cols] = [0, 1].map(|axis| scales.radii[axis][pixel]);
        rows.min(cols) >= smallest
            && is_set(grid.links.valid_words(row), REACH + col)
            && plain.around((row, col), (kernels.of(rows)[1].reach, kernels.of(cols)[1].reach))
    };
    let of_row = |row: usize| {
        let wanted = &wanted[row * size.cols..(row + 1) * size.cols];
        let blocks = wanted.chunks(LANES).enumerate().filter(|(_, block)| block.contains(&true));
        let cols = blocks.flat_map(|(at, block)| {
            let wanted = block.iter().enumerate().filter(|(_, wanted)| **wanted);
            wanted.map(move |(k, _)| at * LANES + k)
        });
        cols.filter(move |col| may_be(row, *col))
    };
    Candidates::new((size.rows, size.cols, scales.width), grid.wraps(), of_row)
}
