//! Edge-preserving smoothing of a range image before its contours are found.
//!
//! **Problem.** Where a section plane is nearly tangent to a surface, range noise moves the section
//! by many times its own size and shatters it. More views do not help much; the pixels around each
//! pixel do.
//!
//! **Idea.** Image processing before modelling, as the dissertation proposes (section 6.4): every
//! pixel is replaced by the value there of a polynomial of second order in row and column, fitted
//! to its neighbourhood. An affine fit would flatten what is curved. Robust weights keep creases
//! and what the break rule lets pass out of the fit (iteratively reweighted least squares with
//! Tukey's biweight; Beaton and Tukey, 1974; local fits: Cleveland, 1979).
//!
//! **Steps**, per pixel.
//! 1. The window: round, its radius a power of noise per spacing of the rays; see `window.rs`.
//!    Rows and columns that are spaced differently make an ellipse. Weights fall smoothly to 0 at
//!    its rim, so that the result is smooth from pixel to pixel.
//! 2. Where the surface goes on all around and residuals are noise, robust weights would hardly differ
//!    from one: then the fit is a convolution, and whole images of it cost little; see `linear/mod.rs`.
//!    Steps 3 to 5 are for all other pixels.
//! 3. The pixels in the window that unbroken pairs connect to the centre; see `links.rs`. Nothing is
//!    smoothed across a range jump.
//! 4. Three fits of the quantity in which planes are flat, see `quantity.rs`: the first one with
//!    the weights of 1, then with those of the residuals.
//! 5. The same in a wider window, whose weights follow from the residuals of the last fit.
//! 6. Where both windows agree within noise the wider one counts, where they do not the narrower one, and
//!    in between a mean of both: two steps of the method of intersecting confidence intervals
//!    (Goldenshluger and Nemirovski, 1997). Walls get the gain of wide windows, and what bends stays.
//! 7. The pixel takes that value, with a standard deviation that follows from the weights, unless
//!    that is no smaller, or the pixel itself is none of the fit's surface.
//!
//! Missing pixels stay missing, and where noise is negligible against the spacing of the rays no
//! bit changes. Noise of a result is shared with its neighbours over the window.
//!
//! **Cost.** Step 2 visits every pixel of the image about as often as a window has rows and columns. The
//! robust fit takes three passes over the window's pixels and two over the wider one's, some ten times
//! as much; both take several pixels side by side, see `lanes.rs`. Where section planes are far apart,
//! most pixels can be left as they are; see `reach.rs`.

mod block;
mod estimate;
mod grid;
mod lanes;
mod linear;
mod links;
mod normal_equations;
mod output;
mod pairs;
mod quantity;
mod reach;
mod scales;
mod window;

use crate::one_pass::Instructions;
use crate::{BreakRule, RangeNoise, SectionAxes};
use block::{Block, Weights};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch};
use grid::Grid;
use lanes::Native;
use linear::{Filled, Linear};
use output::Output;
use pairs::is_set;
use quantity::Quantity;
use reach::Reach;
use scales::Scales;
use transect_device::{Pixel, RangeImage, View, ViewError};

/// Pixels from a window's centre to its border at most.
const REACH: usize = 10;

/// A view after smoothing.
#[derive(Debug, Clone)]
pub struct Smoothed {
    /// The view with its new image.
    pub view: View,
    /// Row-major: by what each pixel's standard deviation was multiplied; 1 where it stayed.
    pub sigma_factors: Vec<f32>,
    /// The median of these over the valid pixels that were to be smoothed.
    pub median_factor: f64,
    /// Diameter of the window at the median smoothed pixel, in pixels; 0 if none was smoothed.
    pub window: f64,
    /// How many pixels changed.
    pub changed: usize,
    /// How many of these by the fit without robust weights.
    pub linear: usize,
}

impl Smoothed {
    /// By what the standard deviation of a pixel was multiplied; 1 outside the image.
    pub fn factor(&self, pixel: Pixel) -> f64 {
        let size = self.view.image().size();
        let inside = pixel.row < size.rows && pixel.col < size.cols;
        let at =
            inside.then(|| self.sigma_factors.get(pixel.row * size.cols + pixel.col)).flatten();
        at.map_or(1.0, |factor| f64::from(*factor))
    }
}

/// Which pixels are smoothed, and how.
#[derive(Debug, Clone, Copy, Default)]
pub struct Extent<'a> {
    /// Only pixels that can take part in a curve on one of the planes to which these axes belong, and
    /// those next to them: curves are the same as if all were smoothed. `None` for all.
    pub near: Option<&'a SectionAxes>,
    /// Instructions of the inner loops. Results are the same to the bit.
    pub instructions: Instructions,
    /// Whether all pixels are fitted with robust weights, also where those would change nothing.
    pub robust: bool,
}

/// Smooths the image of a view.
///
/// `rule` tells which neighbouring pixels belong to one surface; its slack should be that of the
/// same noise.
///
/// # Errors
/// [`ViewError`] if the smoothed image does not make a view, which the given one did.
pub fn smooth(view: &View, noise: &RangeNoise, rule: &BreakRule) -> Result<Smoothed, ViewError> {
    smooth_with(view, noise, rule, &Extent::default())
}

/// The same, for the pixels that are asked for.
///
/// # Errors
/// As [`smooth`].
pub fn smooth_with(
    view: &View,
    noise: &RangeNoise,
    rule: &BreakRule,
    extent: &Extent<'_>,
) -> Result<Smoothed, ViewError> {
    let size = view.image().size();
    let mut output = Output::new(view.image());
    let (mut linear, mut unchanged) = (0, 0);
    if noise.length() > 0.0 {
        let level = extent.instructions.level();
        let mut smoother = dispatch!(level, simd => Smoother::new(simd, view, noise, rule));
        let filled = if extent.robust { None } else { Some(smoother.fill()) };
        let reach = extent.near.and_then(|axes| Reach::new(&smoother, axes));
        let mut wanted = match &reach {
            Some(reach) => dispatch!(level, simd => reach.wanted(simd, &smoother)),
            None => vec![true; size.pixels()],
        };
        unchanged = count_valid(view.image(), &wanted);
        if let Some(filled) = &filled {
            let found = dispatch!(level, simd => Linear::new(simd, &smoother, filled, &wanted));
            let rest = dispatch!(level, simd => found.take(simd, &smoother, &wanted, &mut output));
            (linear, wanted) = (output.changed, rest);
        }
        dispatch!(level, simd => smoother.image(simd, &wanted, &mut output));
        unchanged -= output.changed;
    }
    Ok(Smoothed {
        median_factor: output.median_factor(unchanged),
        window: output.window(),
        changed: output.changed,
        linear,
        view: view.with_image(
            RangeImage::from_values(size, output.values).map_err(|_| ViewError::NoValidPixel)?,
        )?,
        sigma_factors: output.sigma_factors,
    })
}

/// How many of the wanted pixels there are.
fn count_valid(image: &RangeImage, wanted: &[bool]) -> usize {
    let cols = image.size().cols;
    let rows = wanted.chunks(cols).enumerate();
    let in_row = |(row, wanted): (usize, &[bool])| {
        let pixels = image.row(row).iter().zip(wanted);
        pixels.map(|(value, wanted)| u32::from(*wanted & !value.is_nan())).sum::<u32>() as usize
    };
    rows.map(in_row).sum()
}

/// What the image holds.
struct Samples<'a> {
    view: &'a View,
    noise: &'a RangeNoise,
    quantity: Quantity,
    grid: Grid<'a>,
}

struct Smoother<'a> {
    samples: Samples<'a>,
    scales: Scales,
}

impl<'a> Smoother<'a> {
    #[inline(always)]
    fn new<S: Simd>(simd: S, view: &'a View, noise: &'a RangeNoise, rule: &'a BreakRule) -> Self {
        let quantity = Quantity::of(view);
        // Closures take the loops into functions of their own, with all instructions.
        let grid = simd.vectorize(
            #[inline(always)]
            || Grid::new(simd, view, rule, quantity),
        );
        let samples = Samples { view, noise, quantity, grid };
        let scales = simd.vectorize(
            #[inline(always)]
            || Scales::new(&samples),
        );
        Self { scales, samples }
    }

    /// Fills gaps one pixel wide; see `linear/fill.rs`.
    fn fill(&mut self) -> Filled {
        Filled::new(&mut self.samples.grid, &self.scales)
    }

    #[inline(always)]
    fn image<S: Simd>(&self, simd: S, wanted: &[bool], output: &mut Output) {
        let mut weights = Weights::new();
        let cols = self.samples.view.image().size().cols;
        let mut paired = vec![0; self.samples.grid.links.words()];
        for (row, wanted) in wanted.chunks(cols).enumerate() {
            self.samples.grid.links.paired(row, &mut paired);
            let mut first = 0;
            // Blocks begin at pixels that are wanted; that changes nothing in any pixel's fit.
            while let Some(skip) = wanted[first..].iter().position(|wanted| *wanted) {
                first += skip;
                let end = (first + Native::<S>::LEN).min(cols);
                let counts =
                    |lane: usize| wanted[first + lane] && is_set(&paired, REACH + first + lane);
                simd.vectorize(
                    #[inline(always)]
                    || {
                        let block = self.block((row, first), end - first, counts);
                        if !block.is_empty() {
                            let fitted = block.fit(simd, &self.samples.grid, &mut weights);
                            let radii = block.radii(&fitted.shares);
                            let quantity = self.samples.quantity;
                            output.put(quantity, row * cols + first, &fitted, &radii);
                        }
                    },
                );
                first = end;
            }
        }
    }

    /// The windows of some pixels of a row; pixels without neighbours of their surface stay as they are.
    #[inline(always)]
    fn block(
        &self,
        (row, first): (usize, usize),
        count: usize,
        counts: impl Fn(usize) -> bool,
    ) -> Block {
        let mut block = Block::new(row, first);
        let values = &self.samples.view.image().row(row)[first..];
        let inverse_sigma = &self.scales.inverse_sigma[row * self.scales.width + first..];
        for lane in (0..count).filter(|lane| counts(*lane)) {
            let sizes = self.samples.sizes(Pixel::new(row, first + lane), values[lane]);
            block.set(lane, sizes, inverse_sigma[lane]);
        }
        block.find_windows();
        block
    }
}

impl Samples<'_> {
    /// Distances between the rays of a row and of a column at a pixel and the noise as a length, from which
    /// its window follows; NaN where they are not known.
    #[inline(always)]
    fn sizes(&self, pixel: Pixel, value: f32) -> [f32; 3] {
        let length = || match self.noise.stated_length() {
            Some(length) => Some(length),
            None => {
                let rate = f64::from(self.grid.length_per_value(pixel, value)?);
                Some(self.noise.value_sigma(rate) * rate)
            }
        };
        let sizes = self
            .grid
            .spacings(pixel)
            .and_then(|(across, down)| Some([across, down, length()? as f32]));
        sizes.unwrap_or([f32::NAN; 3])
    }
}
