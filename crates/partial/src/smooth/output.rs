//! What becomes of an image: its values, by how much less noisy they are, and the medians of that.

use super::estimate::Fitted;
use super::quantity::Quantity;
use super::window;
use transect_device::RangeImage;

#[derive(Debug)]
pub(super) struct Output {
    pub values: Vec<f32>,
    pub sigma_factors: Vec<f32>,
    /// How many pixels changed.
    pub changed: usize,
    /// Radii of the windows of the pixels that changed.
    radii: Histogram,
    /// What their standard deviations were multiplied by.
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
            radii: Histogram::new(window::WIDEST),
            factors: Histogram::new(1.0),
        }
    }

    /// Puts into the image what was found for neighbouring pixels from one on, by windows of some radii.
    #[inline(always)]
    pub fn put<const N: usize>(
        &mut self,
        quantity: Quantity,
        first: usize,
        fitted: &Fitted<N>,
        radii: &[f32; N],
    ) {
        let values = &mut self.values[first..];
        let mut old = [1.0; N];
        match values.first_chunk::<N>() {
            Some(values) => old = *values,
            None => old[..values.len()].copy_from_slice(values),
        }
        let mut new = [0.0; N];
        for ((new, old), change) in new.iter_mut().zip(&old).zip(&fitted.changes) {
            let changed = quantity.of_value(f64::from(*old)) + f64::from(*change);
            *new = quantity.value(changed) as f32;
        }
        let out = values.iter_mut().zip(&mut self.sigma_factors[first..]);
        for (k, (value, factor)) in out.take(N).enumerate() {
            // Noise as large as the range itself could turn a sample into a missing one.
            if fitted.holds[k] && new[k] > 0.0 && new[k] < f32::INFINITY {
                (*value, *factor) = (new[k], fitted.factors[k]);
                self.radii.add(radii[k]);
                self.factors.add(fitted.factors[k]);
                self.changed += 1;
            }
        }
    }

    /// Diameter of the window at the median pixel that changed; 0 if none did.
    pub fn window(&self) -> f64 {
        2.0 * self.radii.median(0).unwrap_or(0.0)
    }

    /// The median factor of the pixels that changed and of some that did not.
    pub fn median_factor(&self, unchanged: usize) -> f64 {
        self.factors.median(unchanged).unwrap_or(1.0)
    }
}

/// How often numbers from 0 to a largest one came.
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
