//! Noise at every pixel, and how large windows are there.

use super::Samples;
use super::lanes::LANES;
use super::linear::{Radius, index_of};
use super::quantity::Quantity;
use super::window;
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

/// Of the first sample of every block of a row, what the windows follow from, and those.
#[derive(Debug)]
struct Leads {
    sizes: [Vec<f32>; 3],
    radii: [Vec<Radius>; 2],
}

impl Leads {
    fn new(blocks: usize) -> Self {
        let (sizes, radii) = (vec![f32::NAN; blocks], vec![0; blocks]);
        Self { sizes: [sizes.clone(), sizes.clone(), sizes], radii: [radii.clone(), radii] }
    }

    /// Reads a row.
    #[inline(always)]
    fn read(&mut self, samples: &Samples<'_>, row: usize) {
        let values = samples.view.image().row(row);
        for (block, values) in values.chunks(BLOCK).enumerate() {
            let lead = values.iter().position(|v| !v.is_nan());
            let sizes = lead.map_or([f32::NAN; 3], |k| {
                samples.sizes(Pixel { row, col: block * BLOCK + k }, values[k])
            });
            for (all, size) in self.sizes.iter_mut().zip(sizes) {
                all[block] = size;
            }
        }
        let [across, down, length] = &self.sizes;
        let [rows, cols] = &mut self.radii;
        let sizes = across.iter().zip(down).zip(length);
        for (((across, down), length), (rows, cols)) in sizes.zip(rows.iter_mut().zip(cols)) {
            [*rows, *cols] = radii_of([*across, *down, *length]);
        }
    }
}

/// Radii of a window in rows and in columns; 0 where a pixel stays as it is.
#[inline(always)]
fn radii_of(sizes: [f32; 3]) -> [Radius; 2] {
    window::radii(sizes).map(index_of)
}

impl Scales {
    /// A block's scales follow from its own pixels alone, so they do not depend on what is wanted.
    #[inline(always)]
    pub fn new(samples: &Samples<'_>) -> Self {
        let size = samples.view.image().size();
        let width = size.cols.next_multiple_of(LANES);
        // Memory that is asked for empty costs less than a copy of such.
        let none = || vec![0; width * size.rows];
        let inverse_sigma = vec![0.0; width * size.rows];
        let mut scales = Self { width, radii: [none(), none()], inverse_sigma };
        let mut leads = Leads::new(size.cols.div_ceil(BLOCK));
        for row in 0..size.rows {
            let values = samples.view.image().row(row);
            leads.read(samples, row);
            for (block, values) in values.chunks(BLOCK).enumerate() {
                let radii = [leads.radii[0][block], leads.radii[1][block]];
                let first = Pixel { row, col: block * BLOCK };
                scales.read_block(samples, (first, radii), values);
            }
        }
        scales
    }

    #[inline(always)]
    fn read_block(
        &mut self,
        samples: &Samples<'_>,
        (first, radii): (Pixel, [Radius; 2]),
        values: &[f32],
    ) {
        // Missing pixels, which may be filled, take the scale of the one before, or else after.
        let Some(lead) = values.iter().position(|v| !v.is_nan()) else { return };
        let of =
            |k: usize, radii| Reference::of(samples, (first, values.len()), (values[k], radii));
        let reference = of(lead, radii);
        let alike = |r: &Reference| {
            values.iter().fold(true, |all, value| all & (r.is_alike(*value) | value.is_nan()))
        };
        let start = first.row * self.width + first.col;
        match reference {
            Some(reference) if alike(&reference) => {
                self.set(samples.quantity, start, (0, values), &reference);
            }
            mut reference => {
                for k in lead..values.len() {
                    let value = values[k];
                    if !value.is_nan() && !reference.is_some_and(|r| r.is_alike(value)) {
                        let pixel = Pixel { row: first.row, col: first.col + k };
                        reference = of(k, radii_of(samples.sizes(pixel, value)));
                    }
                    if let Some(reference) = &reference {
                        let from = if k == lead { 0 } else { k };
                        self.set(samples.quantity, start, (from, &values[from..=k]), reference);
                    }
                }
            }
        }
    }

    /// The scales of some pixels of a block, counted from its first, by that of one of them.
    #[inline(always)]
    fn set(
        &mut self,
        quantity: Quantity,
        start: usize,
        (from, values): (usize, &[f32]),
        reference: &Reference,
    ) {
        let pixels = start + from..start + from + values.len();
        for (radii, radius) in self.radii.iter_mut().zip(reference.radii) {
            // Mostly a whole block, for which no call is needed.
            match radii[pixels.clone()].first_chunk_mut::<BLOCK>() {
                Some(radii) => *radii = [radius; BLOCK],
                None => radii[pixels.clone()].fill(radius),
            }
        }
        let [first, step] = reference.inverse_sigma;
        for (k, (scale, value)) in self.inverse_sigma[pixels].iter_mut().zip(values).enumerate() {
            let value = if value.is_nan() { reference.value } else { *value };
            *scale = quantity.inverse_sigma(value, first + step * (from + k) as f32);
        }
    }
}

impl Reference {
    /// What a value says of its block, from the radii of its window; `None` where the pixel stays as it is.
    #[inline(always)]
    fn of(
        samples: &Samples<'_>,
        (first, count): (Pixel, usize),
        (value, radii): (f32, [Radius; 2]),
    ) -> Option<Self> {
        // Rays of a block turn away from each other, so the noise of a value changes along it, too.
        let inverse = |k: usize| {
            let pixel = Pixel { row: first.row, col: first.col + k };
            let rate = samples.grid.length_per_value(pixel, value)?;
            Some((1.0 / samples.noise.value_sigma(f64::from(rate))) as f32)
        };
        if radii[0] == 0 {
            return None;
        }
        let (at_first, at_last) = (inverse(0), inverse(count - 1));
        let inverse_sigma = match (at_first, at_last) {
            (Some(a), Some(b)) if count > 1 => [a, (b - a) / (count - 1) as f32],
            (one, other) => [one.or(other)?, 0.0],
        };
        Some(Self { value, radii, inverse_sigma })
    }

    #[inline(always)]
    fn is_alike(&self, value: f32) -> bool {
        (value - self.value).abs() <= ALIKE * self.value
    }
}
