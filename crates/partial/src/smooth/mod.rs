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
//! 2. The pixels in it that unbroken pairs connect to the centre; see `links.rs`. Nothing is
//!    smoothed across a range jump.
//! 3. Three fits of the quantity in which planes are flat, see `quantity.rs`: the first one with
//!    the weights of 1, then with those of the residuals.
//! 4. The pixel takes the polynomial's value, with a standard deviation that follows from the
//!    weights, unless that is no smaller, or the pixel itself is none of the fit's surface.
//!
//! Missing pixels stay missing, and where noise is negligible against the spacing of the rays no
//! bit changes. Noise of a result is shared with its neighbours over the window.
//!
//! **Cost.** Three passes over the window's pixels, several pixels side by side; see `lanes.rs`.

mod block;
mod grid;
mod lanes;
mod links;
mod normal_equations;
mod quantity;
mod window;

use crate::{BreakRule, RangeNoise, length_per_value};
use block::{Block, Weights};
use grid::Grid;
use lanes::{LANES, Lanes};
use quantity::Quantity;
use transect_device::{Pixel, RangeImage, View, ViewError};

/// Pixels from a window's centre to its border at most.
const REACH: usize = 7;

/// A view after smoothing.
#[derive(Debug, Clone)]
pub struct Smoothed {
    /// The view with its new image.
    pub view: View,
    /// Row-major: by what each pixel's standard deviation was multiplied; 1 where it stayed.
    pub sigma_factors: Vec<f32>,
    /// The median of these over the valid pixels.
    pub median_factor: f64,
    /// Diameter of the window at the median smoothed pixel, in pixels; 0 if none was smoothed.
    pub window: f64,
    /// How many pixels changed.
    pub changed: usize,
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

/// Smooths the image of a view.
///
/// `rule` tells which neighbouring pixels belong to one surface; its slack should be that of the
/// same noise.
///
/// # Errors
/// [`ViewError`] if the smoothed image does not make a view, which the given one did.
pub fn smooth(view: &View, noise: &RangeNoise, rule: &BreakRule) -> Result<Smoothed, ViewError> {
    let size = view.image().size();
    let mut values: Vec<f32> =
        (0..size.rows).flat_map(|row| view.image().row(row)).copied().collect();
    let mut sigma_factors = vec![1.0; values.len()];
    let mut radii = Vec::new();
    if noise.length() > 0.0 {
        let smoother = Smoother::new(view, noise, rule);
        let mut weights = Weights::new();
        for row in 0..size.rows {
            let pixels = row * size.cols..(row + 1) * size.cols;
            let out = (&mut values[pixels.clone()], &mut sigma_factors[pixels]);
            smoother.row(row, out, &mut radii, &mut weights);
        }
    }
    Ok(Smoothed {
        median_factor: median_of_valid(&values, &sigma_factors),
        window: 2.0 * median(&mut radii),
        changed: radii.len(),
        view: view.with_image(
            RangeImage::from_values(size, values).map_err(|_| ViewError::NoValidPixel)?,
        )?,
        sigma_factors,
    })
}

fn median_of_valid(values: &[f32], factors: &[f32]) -> f64 {
    let valid = values.iter().zip(factors).filter(|(v, _)| !v.is_nan());
    median(&mut valid.map(|(_, f)| *f).collect::<Vec<f32>>())
}

fn median(values: &mut [f32]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    f64::from(*values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

struct Smoother<'a> {
    view: &'a View,
    noise: &'a RangeNoise,
    quantity: Quantity,
    grid: Grid,
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
    fn new(view: &'a View, noise: &'a RangeNoise, rule: &BreakRule) -> Self {
        let quantity = Quantity::of(view);
        Self { view, noise, quantity, grid: Grid::new(view, rule, quantity) }
    }

    fn row(
        &self,
        row: usize,
        (values, factors): (&mut [f32], &mut [f32]),
        radii: &mut Vec<f32>,
        weights: &mut Weights,
    ) {
        for first in (0..values.len()).step_by(LANES) {
            let columns = first..(first + LANES).min(values.len());
            let mut block = Block::new(row, first);
            for col in columns.clone() {
                if let Some(window) = self.window(Pixel::new(row, col)) {
                    block.set(col - first, &window, self.grid.links.connected(row, col));
                }
            }
            if block.is_empty() {
                continue;
            }
            let fit = block.fit(&self.grid, weights);
            for col in columns {
                let Some((change, factor)) = fit.at(col - first) else { continue };
                let old = self.quantity.of_value(f64::from(values[col]));
                let value = self.quantity.value(old + f64::from(change)) as f32;
                // Noise as large as the range itself could turn a sample into a missing one.
                if !(value > 0.0 && value.is_finite()) {
                    continue;
                }
                values[col] = value;
                factors[col] = factor;
                radii.push(block.radius(col - first));
            }
        }
    }

    /// `None` where the pixel is missing or stays as it is.
    fn window(&self, pixel: Pixel) -> Option<Window> {
        let d3 = f64::from(self.view.image().get(pixel)?);
        let spacings =
            self.grid.spacings.get(pixel.row * self.view.image().size().cols + pixel.col)?;
        let (across, down) = (f64::from(spacings[0]), f64::from(spacings[1]));
        let spacing = (across * down).sqrt();
        if spacing.is_nan() || spacing <= 0.0 {
            return None;
        }
        let rate = length_per_value(self.view.frame(), pixel, d3)?;
        let sigma = self.noise.value_sigma(rate);
        let radius = window::radius(sigma * rate, spacing);
        let limit = |radius: f64| radius.clamp(1.0, window::LARGEST);
        (radius > 0.0).then(|| Window {
            radii: (limit(radius * spacing / down), limit(radius * spacing / across)),
            sigma: self.quantity.sigma(d3, sigma),
        })
    }
}
