//! Noise at every pixel, and how large windows are there.

use super::Samples;
use super::lanes::LANES;
use super::linear::{Radius, index_of};
use super::quantity::Quantity;
use crate::length_per_value;
use transect_device::Pixel;

/// Values that differ by less than this share have the same window and the same noise of the value, to
/// within what either is known.
const ALIKE: f32 = 1.0 / 16.0;

/// Pixels of a row that may share a scale.
const BLOCK: usize = 8;

/// Row-major, each row filled up to whole blocks.
#[derive(Debug)]
pub(super) struct Scales {
    pub width: usize,
    /// Radii in rows and in columns for fits without robust weights; 0 where a pixel is not smoothed.
    pub radii: [Vec<Radius>; 2],
    /// 1 over the standard deviation of the fitted quantity; 0 where a pixel is not smoothed.
    pub inverse_sigma: Vec<f32>,
}

/// A pixel of a block whose scale others take.
#[derive(Debug, Clone, Copy)]
struct Reference {
    value: f32,
    radii: [Radius; 2],
    /// 1 over the standard deviation of the value in the block's first column, and its step to the next.
    inverse_sigma: [f32; 2],
}

impl Scales {
    /// A block's scales follow from its own pixels alone, so they do not depend on what is wanted.
    pub fn new(samples: &Samples<'_>) -> Self {
        let size = samples.view.image().size();
        let width = size.cols.next_multiple_of(LANES);
        let none = vec![0; width * size.rows];
        let inverse_sigma = vec![0.0; width * size.rows];
        let mut scales = Self { width, radii: [none.clone(), none], inverse_sigma };
        for row in 0..size.rows {
            let values = samples.view.image().row(row);
            for (block, values) in values.chunks(BLOCK).enumerate() {
                scales.read_block(samples, Pixel { row, col: block * BLOCK }, values);
            }
        }
        scales
    }

    fn read_block(&mut self, samples: &Samples<'_>, first: Pixel, values: &[f32]) {
        // Missing pixels, which may be filled, take the scale of the one before, or else after.
        let Some(lead) = values.iter().position(|v| !v.is_nan()) else { return };
        let of = |k: usize| Reference::of(samples, (first, values.len()), (k, values[k]));
        let start = first.row * self.width + first.col;
        let mut reference = of(lead);
        if let Some(all) = reference.filter(|r| values.iter().all(|v| r.is_alike(*v) | v.is_nan()))
        {
            self.set(samples.quantity, start, (0, values), &all);
            return;
        }
        for k in lead..values.len() {
            let value = values[k];
            if !value.is_nan() && !reference.is_some_and(|r| r.is_alike(value)) {
                reference = of(k);
            }
            if let Some(reference) = &reference {
                let from = if k == lead { 0 } else { k };
                self.set(samples.quantity, start, (from, &values[from..=k]), reference);
            }
        }
    }

    /// The scales of some pixels of a block, counted from its first, by that of one of them.
    fn set(
        &mut self,
        quantity: Quantity,
        start: usize,
        (from, values): (usize, &[f32]),
        reference: &Reference,
    ) {
        let pixels = start + from..start + from + values.len();
        self.radii[0][pixels.clone()].fill(reference.radii[0]);
        self.radii[1][pixels.clone()].fill(reference.radii[1]);
        let [first, step] = reference.inverse_sigma;
        for (k, (scale, value)) in self.inverse_sigma[pixels].iter_mut().zip(values).enumerate() {
            let value = if value.is_nan() { reference.value } else { *value };
            *scale = quantity.inverse_sigma(value, first + step * (from + k) as f32);
        }
    }
}

impl Reference {
    /// What a value says of its block; `None` where the pixel stays as it is.
    fn of(
        samples: &Samples<'_>,
        (first, count): (Pixel, usize),
        (k, value): (usize, f32),
    ) -> Option<Self> {
        let Pixel { row, col } = first;
        let radii = samples.radii(Pixel { row, col: col + k })?;
        // Rays of a block turn away from each other, so the noise of a value changes along it, too.
        let inverse = |k: usize| {
            let pixel = Pixel { row, col: col + k };
            let rate = length_per_value(samples.view.frame(), pixel, f64::from(value));
            rate.map(|rate| (1.0 / samples.noise.value_sigma(rate)) as f32)
        };
        let inverse_sigma = match (inverse(0), inverse(count - 1)) {
            (Some(a), Some(b)) if count > 1 => [a, (b - a) / (count - 1) as f32],
            _ => [inverse(k)?, 0.0],
        };
        Some(Self { value, radii: [radii.0, radii.1].map(index_of), inverse_sigma })
    }

    fn is_alike(&self, value: f32) -> bool {
        (value - self.value).abs() <= ALIKE * self.value
    }
}
