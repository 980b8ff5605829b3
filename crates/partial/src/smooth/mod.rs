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
mod pairs;
mod quantity;
mod reach;
mod scales;
mod window;

use crate::one_pass::Instructions;
use crate::{BreakRule, RangeNoise, SectionAxes, length_per_value};
use block::{Block, BlockFit, Weights};
use estimate::Fitted;
use fearless_simd::{Simd, dispatch};
use grid::Grid;
use lanes::LANES;
use linear::{Linear, LinearFit};
use quantity::Quantity;
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
    let mut values = Vec::with_capacity(size.pixels());
    (0..size.rows).for_each(|row| values.extend_from_slice(view.image().row(row)));
    let sigma_factors = vec![1.0; size.pixels()];
    let mut output = Output { values, sigma_factors, radii: Vec::new(), linear: 0 };
    let mut wanted = vec![true; size.pixels()];
    if noise.length() > 0.0 {
        let level = extent.instructions.level();
        let smoother = dispatch!(level, simd => Smoother::new(simd, view, noise, rule));
        if let Some(axes) = extent.near {
            wanted = dispatch!(level, simd => reach::wanted(simd, &smoother, axes));
        }
        let rest = if extent.robust {
            wanted.clone()
        } else {
            let linear = dispatch!(level, simd => Linear::new(simd, &smoother, &wanted));
            smoother.take_linear(&linear, &wanted, &mut output)
        };
        dispatch!(level, simd => smoother.image(simd, &rest, &mut output));
    }
    let Output { values, sigma_factors, mut radii, linear } = output;
    let counted = values.iter().zip(&wanted).map(|(value, wanted)| *wanted && !value.is_nan());
    Ok(Smoothed {
        median_factor: median_where(counted, &sigma_factors),
        window: 2.0 * median(&mut radii),
        changed: radii.len(),
        linear,
        view: view.with_image(
            RangeImage::from_values(size, values).map_err(|_| ViewError::NoValidPixel)?,
        )?,
        sigma_factors,
    })
}

fn median_where(counted: impl Iterator<Item = bool>, factors: &[f32]) -> f64 {
    let counted = counted.zip(factors).filter(|(counted, _)| *counted);
    let mut factors: Vec<f32> = counted.map(|(_, factor)| *factor).collect();
    if factors.is_empty() { 1.0 } else { median(&mut factors) }
}

fn median(values: &mut [f32]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    f64::from(*values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// What becomes of the image.
struct Output {
    values: Vec<f32>,
    sigma_factors: Vec<f32>,
    /// Radii of the windows of the pixels that changed.
    radii: Vec<f32>,
    linear: usize,
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

/// The window of one pixel.
#[derive(Debug, Clone, Copy)]
struct Window {
    /// Radius in rows and in columns.
    radii: (f64, f64),
    /// Standard deviation of the fitted quantity.
    sigma: f64,
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
        Self { scales: Scales::new(&samples), samples }
    }

    #[inline(always)]
    fn image<S: Simd>(&self, simd: S, wanted: &[bool], output: &mut Output) {
        let mut weights = Weights::new();
        let cols = self.samples.view.image().size().cols;
        for (row, wanted) in wanted.chunks(cols).enumerate() {
            let mut first = 0;
            // Blocks begin at pixels that are wanted; that changes nothing in any pixel's fit.
            while let Some(skip) = wanted.iter().skip(first).position(|wanted| *wanted) {
                first += skip;
                let end = (first + LANES).min(cols);
                let block = self.block(row, first, &wanted[first..end]);
                if !block.is_empty() {
                    let fit = simd.vectorize(
                        #[inline(always)]
                        || block.fit(simd, &self.samples.grid, &mut weights),
                    );
                    for lane in 0..end - first {
                        self.take(&block, &fit, (lane, row * cols + first + lane), output);
                    }
                }
                first = end;
            }
        }
    }

    /// Takes over what the fit without robust weights says of the pixels that are wanted; those of which it
    /// says nothing.
    fn take_linear(&self, linear: &Linear, wanted: &[bool], output: &mut Output) -> Vec<bool> {
        let cols = self.samples.view.image().size().cols;
        let mut rest = vec![false; wanted.len()];
        for (row, (wanted, rest)) in wanted.chunks(cols).zip(rest.chunks_mut(cols)).enumerate() {
            for (col, (wanted, rest)) in wanted.iter().zip(rest).enumerate() {
                let pixel = row * cols + col;
                if !wanted || output.values[pixel].is_nan() {
                    continue;
                }
                match linear.at(row, col) {
                    Some(LinearFit { fitted, radius }) => {
                        if self.change(pixel, fitted, radius, output) {
                            output.linear += 1;
                        }
                    }
                    None => *rest = true,
                }
            }
        }
        rest
    }

    /// The windows of some pixels of a row.
    fn block(&self, row: usize, first: usize, wanted: &[bool]) -> Block {
        let mut block = Block::new(row, first);
        for (lane, wanted) in wanted.iter().enumerate() {
            let window = wanted.then(|| self.window(Pixel::new(row, first + lane))).flatten();
            if let Some(window) = window {
                block.set(lane, &window);
            }
        }
        block
    }

    /// Takes over what was found for a lane, which is a pixel.
    fn take(
        &self,
        block: &Block,
        fit: &BlockFit,
        (lane, pixel): (usize, usize),
        output: &mut Output,
    ) {
        if let Some(fitted) = fit.at(lane) {
            self.change(pixel, fitted, block.radius(lane, fitted.share), output);
        }
    }

    /// Puts into the image what was found for a pixel by a window of some radius; whether it could be.
    fn change(&self, pixel: usize, fitted: Fitted, radius: f32, output: &mut Output) -> bool {
        let old = self.samples.quantity.of_value(f64::from(output.values[pixel]));
        let value = self.samples.quantity.value(old + f64::from(fitted.change)) as f32;
        // Noise as large as the range itself could turn a sample into a missing one.
        if !(value > 0.0 && value.is_finite()) {
            return false;
        }
        output.values[pixel] = value;
        output.sigma_factors[pixel] = fitted.factor;
        output.radii.push(radius);
        true
    }

    /// `None` where the pixel is missing or stays as it is.
    fn window(&self, pixel: Pixel) -> Option<Window> {
        let radii = self.samples.radii(pixel)?;
        let inverse_sigma = self.scales.inverse_sigma[pixel.row * self.scales.width + pixel.col];
        (inverse_sigma > 0.0).then(|| Window { radii, sigma: 1.0 / f64::from(inverse_sigma) })
    }
}

impl Samples<'_> {
    /// Radii of a pixel's window in rows and in columns; `None` where it stays as it is.
    fn radii(&self, pixel: Pixel) -> Option<(f64, f64)> {
        let d3 = f64::from(self.view.image().get(pixel)?);
        let (across, down) = self.grid.spacings(pixel)?;
        let spacing = (across * down).sqrt();
        if spacing.is_nan() || spacing <= 0.0 {
            return None;
        }
        let length = match self.noise.stated_length() {
            Some(length) => length,
            None => {
                let rate = length_per_value(self.view.frame(), pixel, d3)?;
                self.noise.value_sigma(rate) * rate
            }
        };
        let radius = window::radius(length, spacing);
        let limit = |radius: f64| radius.clamp(1.0, window::LARGEST);
        (radius > 0.0).then(|| (limit(radius * spacing / down), limit(radius * spacing / across)))
    }
}
