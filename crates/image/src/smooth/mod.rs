//! Edge-preserving smoothing of a range image before its contours are found.
//!
//! **Problem.** Where a section plane is nearly tangent to a surface, range noise moves the section
//! by many times its own size and shatters it. The neighbours of each pixel hold the information
//! that reduces this noise; more views help less.
//!
//! **Idea.** Image processing before modelling, as the dissertation proposes (section 6.4): every
//! pixel takes the value of a polynomial of second order in row and column, fitted to its
//! neighbourhood. An affine fit would flatten curved surfaces. Robust weights keep creases and low
//! steps out of the fit (iteratively reweighted least squares with Tukey's biweight; Beaton and
//! Tukey, 1974; local fits: Cleveland, 1979).
//!
//! **Steps**, per pixel.
//! 1. The window is round. Its radius follows from the noise per spacing of the rays; see
//!    `window.rs`. Rows and columns that are spaced differently make an ellipse. Weights fall
//!    smoothly to 0 at its rim, so that the result is smooth from pixel to pixel.
//!    Where neighbours share most of their noise, every second row of a window is left out. Two
//!    neighbours in a column then have no sample in common, so their own noise is independent.
//! 2. Only pixels that unbroken pairs connect to the centre count; see `links.rs`. Nothing is
//!    smoothed across a range jump.
//!    Flying pixels are left out before, and become missing; see `flying.rs`.
//! 3. Three fits of the quantity in which planes are flat, see `quantity.rs`: the first with
//!    weights by distance alone, the others also with weights by the residuals.
//! 4. A fit in a wider window, with weights by the residuals of the last fit.
//! 5. The wider window counts where noise explains the difference of both fits, the narrow one
//!    where it does not, and a mean of both in between. These are two steps of the method of
//!    intersecting confidence intervals (Goldenshluger and Nemirovski, 1997). Walls get the gain of
//!    wide windows, and bends keep their shape.
//! 6. The pixel takes that value, and its standard deviation follows from the weights. It stays as
//!    it is if the fit is no less noisy, or differs from its sample by more than noise does.
//!
//! Missing pixels stay missing. An image whose noise is negligible against the spacing of the rays
//! keeps every bit. The noise of a result is shared with its neighbours over the window.
//!
//! **Tunables** are in `tuning.rs`.
//!
//! **Cost.** Four passes over the places of the windows and two half ones, for as many pixels side
//! by side as a vector of the processor holds; see `block.rs`. Only the pixels that [`PixelChoice`]
//! asks for are fitted.
//!
//! ```
//! use std::sync::Arc;
//! use transect_device::{ImageSize, Isometry3, RangeImage, View};
//! use transect_image::{BreakRule, RangeNoise, smooth::smooth};
//! use transect_sensors::{Intrinsics, Pinhole};
//!
//! // A wall two units ahead, with an error of 0.01 up or down at every pixel.
//! let size = ImageSize { rows: 48, cols: 64 };
//! let camera = Pinhole::new(size, Intrinsics { fx: 120.0, fy: 120.0, cx: 31.5, cy: 23.5 })?;
//! let error = |k: usize| if k * 7 % 11 < 5 { 0.01 } else { -0.01 };
//! let values = (0..size.pixels()).map(|k| 2.0 + error(k)).collect();
//! let image = RangeImage::from_values(size, values)?;
//! let view = View::new("wall", image, Arc::new(camera), Isometry3::identity(), Some(0.01))?;
//!
//! let noise = RangeNoise::of(&view);
//! let rule = BreakRule::new(78_f64.to_radians(), 4.0 * noise.length());
//! let smoothed = smooth(&view, &noise, &rule)?;
//! assert!(smoothed.changed > size.pixels() * 9 / 10);
//! let less_noisy = smoothed.sigma_factors.iter().filter(|factor| **factor < 0.4).count();
//! assert!(less_noisy > size.pixels() / 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod block;
mod bounds;
mod estimate;
mod flying;
mod grid;
mod lanes;
mod links;
mod normal_equations;
mod output;
mod pairs;
mod quantity;
mod window;

pub use bounds::ValueBounds;
pub(crate) use quantity::Quantity;

use crate::tuning::HALF_WINDOW;
use crate::{BreakRule, Instructions, RangeNoise};
use block::{Block, Scales, Workspace};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch};
use flying::flying_pixels;
use grid::Grid;
use lanes::Native;
use output::Output;
use pairs::is_set;
use transect_device::{Pixel, View, ViewError};

/// A view after smoothing.
#[derive(Debug, Clone)]
pub struct Smoothed {
    /// The view with its new image.
    pub view: View,
    /// Factor of each pixel's standard deviation, row-major; 1 where the pixel stayed.
    pub sigma_factors: Vec<f32>,
    /// How many pixels changed.
    pub changed: usize,
    /// Pixels between the two surfaces of a range jump, which became missing; see `flying.rs`.
    pub flying: usize,
}

impl Smoothed {
    /// The factor of a pixel's standard deviation; 1 outside the image.
    pub fn factor(&self, pixel: Pixel) -> f64 {
        let size = self.view.image().size();
        let inside = pixel.row < size.rows && pixel.col < size.cols;
        let at =
            inside.then(|| self.sigma_factors.get(pixel.row * size.cols + pixel.col)).flatten();
        at.map_or(1.0, |factor| f64::from(*factor))
    }
}

/// Chooses the pixels that are smoothed, row-major, from the bounds of every value.
pub type PixelChoice<'a> = dyn Fn(&ValueBounds) -> Vec<bool> + 'a;

/// Steps that can be left out, so that an experiment can tell what each is worth. All are taken by
/// default.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SmoothingSteps {
    /// Noise that neighbours share counts. Windows are wider, and every second row of them is left
    /// out where neighbours share most of the noise. Regions beside a plane must rise farther above
    /// it. Without this step no view is halved, either.
    pub shared_noise: bool,
    /// Every other row and column is left out where neighbours share most of the noise.
    pub half_resolution: bool,
    /// Only pixels near a plane are smoothed. It saves time and changes no curve.
    pub near_planes: bool,
    /// The fit in a second, wider window counts where both windows agree.
    pub wider_window: bool,
    /// The fit is repeated with weights by its residuals.
    pub robust_weights: bool,
    /// Flying pixels are left out.
    pub flying_pixels: bool,
    /// Missing pixels and outliers are filled.
    pub fill: bool,
}

impl Default for SmoothingSteps {
    fn default() -> Self {
        Self {
            shared_noise: true,
            half_resolution: true,
            near_planes: true,
            wider_window: true,
            robust_weights: true,
            flying_pixels: true,
            fill: true,
        }
    }
}

/// Which pixels are smoothed, and how.
#[derive(Clone, Copy, Default)]
pub struct Smoothing<'a> {
    /// The pixels to be smoothed; `None` for all.
    pub pixels: Option<&'a PixelChoice<'a>>,
    /// Instructions of the inner loops. Results are the same to the bit.
    pub instructions: Instructions,
    /// Steps to be taken.
    #[doc(hidden)]
    pub steps: SmoothingSteps,
}

impl std::fmt::Debug for Smoothing<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Smoothing")
            .field("all_pixels", &self.pixels.is_none())
            .field("instructions", &self.instructions)
            .field("steps", &self.steps)
            .finish()
    }
}

/// Smooths the image of a view.
///
/// `rule` tells which neighbouring pixels belong to one surface; its slack should be that of the
/// same noise.
///
/// # Errors
/// [`ViewError`] if the smoothed image does not make a view.
pub fn smooth(view: &View, noise: &RangeNoise, rule: &BreakRule) -> Result<Smoothed, ViewError> {
    smooth_with(view, noise, rule, &Smoothing::default())
}

/// Smooths some pixels of a view.
///
/// # Errors
/// As [`smooth`].
pub fn smooth_with(
    view: &View,
    noise: &RangeNoise,
    rule: &BreakRule,
    smoothing: &Smoothing<'_>,
) -> Result<Smoothed, ViewError> {
    if noise.length() <= 0.0 {
        return Output::new(view.image()).finish(view);
    }
    let level = smoothing.instructions.level();
    let smoother =
        dispatch!(level, simd => Smoother::new(simd, view, noise, rule, smoothing.steps));
    let pixels = smoothing.pixels.filter(|_| smoothing.steps.near_planes);
    let bounds = || dispatch!(level, simd => ValueBounds::new(simd, &smoother));
    let wanted = match pixels.and_then(|choice| Some(choice(&bounds()?))) {
        Some(wanted) => wanted,
        None => vec![true; view.image().size().pixels()],
    };
    let mut output = Output::new(view.image());
    if smoothing.steps.flying_pixels {
        output.leave_out(&flying_pixels(view.image(), &smoother.grid.links));
    }
    dispatch!(level, simd => smoother.image(simd, &wanted, &mut output));
    output.finish(view)
}

/// An image, ready to be fitted.
struct Smoother<'a> {
    view: &'a View,
    noise: &'a RangeNoise,
    quantity: Quantity,
    grid: Grid<'a>,
    steps: SmoothingSteps,
}

impl<'a> Smoother<'a> {
    #[inline(always)]
    fn new<S: Simd>(
        simd: S,
        view: &'a View,
        noise: &'a RangeNoise,
        rule: &'a BreakRule,
        steps: SmoothingSteps,
    ) -> Self {
        let quantity = Quantity::of(view);
        // A closure takes the loops into a function of their own, with all instructions.
        let grid = simd.vectorize(
            #[inline(always)]
            || Grid::new(simd, view, (rule, noise), quantity),
        );
        Self { view, noise, quantity, grid, steps }
    }

    #[inline(always)]
    fn image<S: Simd>(&self, simd: S, wanted: &[bool], output: &mut Output) {
        let mut work = Workspace::new();
        let (image, cols) = (self.view.image(), self.view.image().size().cols);
        let mut rates = vec![0.0; cols];
        let mut paired = vec![0; self.grid.links.words()];
        for (row, wanted) in wanted.chunks(cols).enumerate() {
            self.grid.links.paired(row, &mut paired);
            self.grid.pairs.lengths_per_value(row, image.row(row), &mut rates);
            let mut first = 0;
            // Blocks begin at pixels that are wanted; that changes nothing in any pixel's fit.
            while let Some(skip) = wanted[first..].iter().position(|wanted| *wanted) {
                first += skip;
                let end = (first + Native::<S>::LEN).min(cols);
                let counts = |col: usize| wanted[col] && is_set(&paired, HALF_WINDOW + col);
                simd.vectorize(
                    #[inline(always)]
                    || {
                        let wanted = (first..end).filter(|col| counts(*col));
                        let block = self.block(simd, row, &rates, wanted, first);
                        if !block.is_empty() {
                            let fitted = block.fit(simd, &self.grid, self.steps, &mut work);
                            output.put(self.quantity, row * cols + first, &fitted);
                        }
                    },
                );
                first = end;
            }
        }
    }

    /// Some pixels of a row with their windows. Pixels whose noise or ray spacing is not known, or
    /// whose noise is negligible, are left out. `rates` are the lengths along the row's rays per
    /// unit of their values.
    #[inline(always)]
    fn block<S: Simd>(
        &self,
        simd: S,
        row: usize,
        rates: &[f32],
        cols: impl Iterator<Item = usize>,
        first: usize,
    ) -> Block {
        let mut scales = Scales::default();
        let values = self.view.image().row(row);
        for col in cols {
            let pixel = Pixel { row, col };
            let Some((across, down)) = self.grid.spacings(pixel) else { continue };
            let rate = f64::from(rates[col]);
            let sigma = self.noise.value_sigma(f64::from(values[col]), rate);
            let lane = col - first;
            (scales.across[lane], scales.down[lane]) = (across, down);
            scales.sigma[lane] = (sigma * rate) as f32;
            let inverse_sigma = self.quantity.inverse_sigma(values[col], (1.0 / sigma) as f32);
            scales.inverse_sigma[lane] = inverse_sigma;
        }
        Block::new(simd, row, first, &scales)
    }
}
