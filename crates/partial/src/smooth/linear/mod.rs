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

use super::Smoother;
use super::block::CUT;
use super::estimate::{Estimate, Fitted};
use super::lanes::LANES;
use super::pairs::ones;
use super::scales::Scales;
use super::{REACH, window};
use calm::calm;
use candidates::Candidates;
use convolve::{around, load};
use fearless_simd::Simd;
use fearless_simd::prelude::*;
use fill::Filled;
use kernel::Kernels;
pub(super) use kernel::{Radius, index_of};
use plain::Plain;

/// Largest change, in standard deviations, so that none is near a cut.
const LARGEST_CHANGE: f32 = 4.0;

/// Both estimates of every pixel, and where they hold.
#[derive(Debug)]
pub(super) struct Linear<'a> {
    scales: &'a Scales,
    kernels: Kernels,
    candidates: Candidates,
    /// Changes by the window and by the wider one, in standard deviations; row-major as the scales. Known
    /// around candidates.
    changes: [Vec<f32>; 2],
    /// Where residuals are like noise; row-major as the scales. Known of candidates.
    calm: Vec<bool>,
}

/// What becomes of a pixel, and the radius of its window.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinearFit {
    pub fitted: Fitted,
    pub radius: f32,
}

impl<'a> Linear<'a> {
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, smoother: &'a Smoother<'_>, wanted: &[bool]) -> Self {
        let (grid, scales) = (&smoother.samples.grid, &smoother.scales);
        let size = smoother.samples.view.image().size();
        let filled = Filled::new(grid, scales, (size.rows, size.cols));
        let plain = Plain::new(grid, size.rows, size.cols, &filled.places);
        let kernels = Kernels::new();
        let smallest = index_of(window::SMALLEST);
        let may_be = |row: usize, col: usize| {
            let pixel = row * scales.width + col;
            let [rows, cols] = [0, 1].map(|axis| scales.radii[axis][pixel]);
            wanted[row * size.cols + col]
                && rows.min(cols) >= smallest
                && plain.around((row, col), (kernels.of(rows)[1].reach, kernels.of(cols)[1].reach))
        };
        let of_row = |row: usize| {
            let valid =
                ones(grid.links.valid_words(row)).filter_map(|place| place.checked_sub(REACH));
            valid.filter(move |col| *col < size.cols && may_be(row, *col))
        };
        let shape = (size.rows, size.cols, scales.width);
        let candidates = Candidates::new(shape, grid.wraps(), of_row);
        let none = || vec![0.0; scales.inverse_sigma.len()];
        let mut linear =
            Self { calm: Vec::new(), scales, kernels, candidates, changes: [none(), none()] };
        if linear.candidates.any() {
            simd.vectorize(
                #[inline(always)]
                || {
                    let along = linear.along_rows(simd, &filled.quantities, grid.stride());
                    linear.down_columns(simd, &along, &filled.quantities, grid.stride());
                },
            );
            let cols = grid.wraps().then_some(size.cols);
            linear.calm = simd.vectorize(
                #[inline(always)]
                || calm(simd, scales, &linear.changes[0], cols, &linear.candidates),
            );
        }
        linear
    }

    /// Step 3 along rows; results have [`REACH`] empty rows above and below.
    #[inline(always)]
    fn along_rows<S: Simd>(&self, simd: S, quantities: &[f32], stride: usize) -> [Vec<f32>; 2] {
        let width = self.scales.width;
        // What is never written costs nothing so: a copy would be written.
        let room = || vec![0.0; self.scales.inverse_sigma.len() + 2 * REACH * width];
        let mut along = [room(), room()];
        for row in 0..self.scales.radii[1].len() / width {
            for col in self.candidates.in_windows(row) {
                let at = (row + REACH) * stride + REACH + col;
                let radii = self.radii(1, row * width + col);
                let found = around(simd, &self.kernels, &radii, [quantities; 2], (at, 1));
                let out = (row + REACH) * width + col;
                found[0].store_slice(&mut along[0][out..out + LANES]);
                found[1].store_slice(&mut along[1][out..out + LANES]);
            }
        }
        along
    }

    fn radii(&self, axis: usize, pixel: usize) -> [Radius; LANES] {
        let radii = &self.scales.radii[axis][pixel..pixel + LANES];
        std::array::from_fn(|k| radii[k])
    }

    /// Step 3 down columns: the changes of all pixels.
    #[inline(always)]
    fn down_columns<S: Simd>(
        &mut self,
        simd: S,
        [narrow, wide]: &[Vec<f32>; 2],
        quantities: &[f32],
        stride: usize,
    ) {
        let width = self.scales.width;
        for row in 0..self.scales.radii[0].len() / width {
            for col in self.candidates.looked(row) {
                let pixel = row * width + col;
                let at = (pixel + REACH * width, width);
                let radii = self.radii(0, pixel);
                let [narrow, wide] = around(simd, &self.kernels, &radii, [narrow, wide], at);
                let sample = load(simd, quantities, (row + REACH) * stride + REACH + col);
                let scale = load(simd, &self.scales.inverse_sigma, pixel);
                let out = pixel..pixel + LANES;
                ((narrow - sample) * scale).store_slice(&mut self.changes[0][out.clone()]);
                ((wide - sample) * scale).store_slice(&mut self.changes[1][out]);
            }
        }
    }

    /// Step 5: what becomes of a pixel that is wanted; `None` where that is not for this fit to say.
    pub fn at(&self, row: usize, col: usize) -> Option<LinearFit> {
        let pixel = row * self.scales.width + col;
        if !self.candidates.holds(pixel) || !self.calm[pixel] {
            return None;
        }
        let [rows, cols] = [0, 1].map(|axis| self.scales.radii[axis][pixel]);
        let (down, across) = (self.kernels.of(rows), self.kernels.of(cols));
        let changes = [0, 1].map(|k| self.changes[k][pixel]);
        if changes[0].abs() > LARGEST_CHANGE {
            return None;
        }
        let [narrow, wide] = [0, 1].map(|k| Estimate {
            change: changes[k] / CUT as f32,
            variance: down[k].variance * across[k].variance,
        });
        let fitted = narrow.fitted(&wide, self.scales.inverse_sigma[pixel] / CUT as f32)?;
        let radius = (kernel::radius(rows) * kernel::radius(cols)).sqrt();
        let wider = window::wider(radius);
        let radius = radius + f64::from(fitted.share) * (wider - radius);
        Some(LinearFit { fitted, radius: radius as f32 })
    }
}
