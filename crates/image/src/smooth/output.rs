//! The smoothed image, how much less noisy each pixel is, and the medians of factors and windows.

use super::Smoothed;
use super::estimate::Fitted;
use super::lanes::MOST;
use super::quantity::Quantity;
use crate::tuning::WIDEST_RADIUS;
use transect_device::{RangeImage, View, ViewError};

#[derive(Debug)]
pub(super) struct Output {
    values: Vec<f32>,
    sigma_factors: Vec<f32>,
    /// How many pixels changed.
    changed: usize,
    /// How many pixels were left out.
    left_out: usize,
    /// Radii of the windows of the pixels that changed.
    radii: Histogram,
    /// Factors of their standard deviations.
    factors: Histogram,
}

impl Output {
    pub fn new(image: &RangeImage) -> Self {
        let size = image.size();
        let mut values = Vec::with_capacity(size.pixels());
        (0..size.rows).for_each(|row| values.extend_from_slice(image.row(row)));
        Self {
            values,
            sigma_factors: vec![1.0; size.pixels()],
            changed: 0,
            left_out: 0,
            radii: Histogram::new(WIDEST_RADIUS),
            factors: Histogram::new(1.0),
        }
    }

    /// Makes some pixels missing.
    pub fn leave_out(&mut self, pixels: &[usize]) {
        pixels.iter().for_each(|at| self.values[*at] = f32::NAN);
        self.left_out += pixels.len();
    }

    /// Puts the results of neighbouring pixels, from one on, into the image.
    #[inline(always)]
    pub fn put(&mut self, quantity: Quantity, first: usize, fitted: &Fitted, radii: &[f32; MOST]) {
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
                self.radii.add(radii[k]);
                self.factors.add(fitted.factors[k]);
                self.changed += 1;
            }
        }
    }

    /// The view with its new image; `wanted` is the number of valid pixels that were to be
    /// smoothed.
    pub fn finish(self, view: &View, wanted: usize) -> Result<Smoothed, ViewError> {
        let image = RangeImage::from_values(view.image().size(), self.values);
        let unchanged = wanted - self.changed;
        Ok(Smoothed {
            view: view.with_image(image.map_err(|_| ViewError::NoValidPixel)?)?,
            sigma_factors: self.sigma_factors,
            median_factor: self.factors.median(unchanged).unwrap_or(1.0),
            window: 2.0 * self.radii.median(0).unwrap_or(0.0),
            changed: self.changed,
            flying: self.left_out,
        })
    }
}

/// Counts of numbers from 0 to a largest one.
#[derive(Debug)]
struct Histogram {
    largest: f32,
    counts: Vec<u32>,
}

impl Histogram {
    /// Steps from 0 to the largest number; medians are known to half of one.
    const STEPS: usize = 1 << 12;

    fn new(largest: f32) -> Self {
        Self { largest, counts: vec![0; Self::STEPS + 1] }
    }

    fn add(&mut self, number: f32) {
        let step = (number / self.largest * Self::STEPS as f32) as usize;
        self.counts[step.min(Self::STEPS)] += 1;
    }

    /// The median of these and of some that are the largest; `None` if there are none.
    fn median(&self, largest: usize) -> Option<f64> {
        let count = |count: &u32| *count as usize;
        let all = self.counts.iter().map(count).sum::<usize>() + largest;
        let mut before = 0;
        let step = self.counts.iter().map(count).position(|count| {
            before += count;
            before > all / 2
        });
        let at = match step {
            None if all == 0 => return None,
            None | Some(Self::STEPS) => 1.0,
            Some(step) => (step as f64 + 0.5) / Self::STEPS as f64,
        };
        Some(at * f64::from(self.largest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_are_those_of_the_sorted_numbers() {
        assert_eq!(Histogram::new(2.0).median(0), None);
        assert_eq!(Histogram::new(2.0).median(3), Some(2.0));
        let mut histogram = Histogram::new(2.0);
        for (k, median) in [(0, 0.2), (1, 0.5), (2, 0.5), (3, 0.7), (4, 0.7)] {
            histogram.add([0.2, 0.5, 0.7, 1.9, 0.4][k]);
            let found = histogram.median(0).unwrap();
            let median = if k == 4 { 0.5 } else { median };
            assert!((found - median).abs() < 3e-4, "{k}: {found}");
        }
        assert!((histogram.median(2).unwrap() - 0.7).abs() < 3e-4);
        assert_eq!(histogram.median(6), Some(2.0));
    }
}
