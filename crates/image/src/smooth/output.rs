//! The smoothed image, and how much less noisy each pixel is.

use super::Smoothed;
use super::estimate::Fitted;
use super::lanes::MOST;
use super::quantity::Quantity;
use transect_device::{RangeImage, View, ViewError};

#[derive(Debug)]
pub(super) struct Output {
    values: Vec<f32>,
    sigma_factors: Vec<f32>,
    /// How many pixels changed.
    changed: usize,
    /// How many pixels were left out.
    left_out: usize,
}

impl Output {
    pub fn new(image: &RangeImage) -> Self {
        let size = image.size();
        let mut values = Vec::with_capacity(size.pixels());
        (0..size.rows).for_each(|row| values.extend_from_slice(image.row(row)));
        Self { values, sigma_factors: vec![1.0; size.pixels()], changed: 0, left_out: 0 }
    }

    /// Makes some pixels missing.
    pub fn leave_out(&mut self, pixels: &[usize]) {
        pixels.iter().for_each(|at| self.values[*at] = f32::NAN);
        self.left_out += pixels.len();
    }

    /// Puts the results of neighbouring pixels, from one on, into the image.
    #[inline(always)]
    pub fn put(&mut self, quantity: Quantity, first: usize, fitted: &Fitted) {
        let out = self.values[first..].iter_mut().zip(&mut self.sigma_factors[first..]);
        for (k, (value, factor)) in out.take(MOST).enumerate() {
            if fitted.holds >> k & 1 == 0 {
                continue;
            }
            let changed = quantity.of_value(f64::from(*value)) + f64::from(fitted.changes[k]);
            let new = quantity.value(changed) as f32;
            // Noise as large as the range itself could turn a sample into a missing one.
            if new > 0.0 && new < f32::INFINITY {
                (*value, *factor) = (new, fitted.factors[k]);
                self.changed += 1;
            }
        }
    }

    /// The view with its new image.
    pub fn finish(self, view: &View) -> Result<Smoothed, ViewError> {
        let image = RangeImage::from_values(view.image().size(), self.values);
        Ok(Smoothed {
            view: view.with_image(image.map_err(|_| ViewError::NoValidPixel)?)?,
            sigma_factors: self.sigma_factors,
            changed: self.changed,
            flying: self.left_out,
        })
    }
}
