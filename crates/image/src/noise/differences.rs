//! Third differences of an image's values, and the noise that they tell.

use std::borrow::Cow;
use transect_device::ImageSize;

/// Share of the differences that count, smallest first. Chosen by hand: the others may be at jumps
/// and creases. A larger share counts jumps as noise.
const KEPT: f64 = 0.7;

/// Variance of a normal variable of variance 1 whose size is among the smallest [`KEPT`]. Theory;
/// it changes with [`KEPT`].
const VARIANCE_OF_KEPT: f64 = 0.309_561;

/// Variance of a third difference of independent values of variance 1. Theory: 1 + 9 + 9 + 1.
const VARIANCE_OF_DIFFERENCE: f64 = 20.0;

/// The values of an image, row-major, NaN where missing.
#[derive(Debug)]
pub(super) struct Values<'a> {
    pub size: ImageSize,
    pub values: Cow<'a, [f32]>,
}

impl Values<'_> {
    fn row(&self, row: usize) -> &[f32] {
        let start = row * self.size.cols;
        self.values.get(start..start + self.size.cols).unwrap_or_default()
    }
}

/// The differences of the direction that has more of them.
pub(super) fn count(differences: &[Vec<f32>; 2]) -> usize {
    differences.iter().map(Vec::len).max().unwrap_or(0)
}

/// The smaller of the estimates from both directions; 0 without differences. A direction with less
/// than a tenth of the other's differences has no say.
pub(super) fn smaller_spread(mut differences: [Vec<f32>; 2]) -> f64 {
    let fewest = differences.iter().map(Vec::len).max().unwrap_or(0) / 10;
    let lists = differences.iter_mut().filter(|d| d.len() >= fewest);
    lists.filter_map(|d| spread(d)).reduce(f64::min).unwrap_or(0.0)
}

/// Third differences of values `stride` pixels apart, within some rows and within columns.
pub(super) fn differences(image: &Values<'_>, lines: usize, stride: usize) -> [Vec<f32>; 2] {
    let size = image.size;
    let step = size.rows.div_ceil(lines).max(1);
    let [mut along, mut down] = [Vec::new(), Vec::new()];
    for row in (0..size.rows).step_by(step) {
        let of = |k: usize| image.row(row).get(k * stride..).unwrap_or_default();
        keep(&mut along, [of(0), of(1), of(2), of(3)]);
    }
    for top in (0..size.rows.saturating_sub(3 * stride)).step_by(step) {
        keep(&mut down, [0, 1, 2, 3].map(|k| image.row(top + k * stride)));
    }
    [along, down]
}

/// Keeps the third differences of values at the same places of four lists.
fn keep(differences: &mut Vec<f32>, [a, b, c, d]: [&[f32]; 4]) {
    let values = a.iter().zip(b).zip(c).zip(d);
    let mut count = differences.len();
    differences.resize(count + values.len(), 0.0);
    for (((a, b), c), d) in values {
        // Missing pixels cannot be guessed, so nothing branches on them.
        let third = third_difference([*a, *b, *c, *d]);
        differences[count] = third;
        count += usize::from(third.is_finite());
    }
    differences.truncate(count);
}

/// Size of the third difference of four values; NaN if one is missing.
#[inline]
pub(super) fn third_difference([a, b, c, d]: [f32; 4]) -> f32 {
    let (a, b, c, d) = (f64::from(a), f64::from(b), f64::from(c), f64::from(d));
    ((d - a) - 3.0 * (c - b)).abs() as f32
}

/// Standard deviation of the values of which these are third differences, without the largest.
pub(super) fn spread(differences: &mut [f32]) -> Option<f64> {
    let last = differences.len().checked_sub(1)?;
    let largest = ((differences.len() as f64 * KEPT) as usize).clamp(1, last + 1) - 1;
    // Sizes are in the order of their bits, which sort faster.
    let by_size = |d: &f32| d.to_bits();
    let (smaller, largest, _) = differences.select_nth_unstable_by_key(largest, by_size);
    let squares = smaller.iter().chain([&*largest]).map(|d| f64::from(*d).powi(2));
    let mean_square = squares.sum::<f64>() / (smaller.len() + 1) as f64;
    Some((mean_square / VARIANCE_OF_KEPT / VARIANCE_OF_DIFFERENCE).sqrt())
}
