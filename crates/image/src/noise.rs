//! Range noise of a view: as stated, or estimated from the image itself.

use transect_device::{DeviceFrame, Pixel, RangeImage, View};

/// Largest number of rows or columns in the estimate. Measured: more change it by less than 1 %.
/// Doubled, it takes twice the time.
const LINES: usize = 128;

/// Share of the differences that count, smallest first. Chosen by hand: the others may be at jumps
/// and creases. A larger share counts jumps as noise.
const KEPT: f64 = 0.7;

/// Variance of a normal variable of variance 1 whose size is among the smallest [`KEPT`]. Theory;
/// it changes with [`KEPT`].
const VARIANCE_OF_KEPT: f64 = 0.309_561;

/// Variance of a third difference of independent values of variance 1. Theory: 1 + 9 + 9 + 1.
const VARIANCE_OF_DIFFERENCE: f64 = 20.0;

/// Pixels along each side of the lattice on which lengths per value are found. Chosen by hand; the
/// median of 2 304 of them is known to about 3 %.
const LATTICE: usize = 48;

/// Step of a value in [`length_per_value`], as a share of the value. Chosen by hand: far above
/// rounding, and far below the change of the rate.
const VALUE_STEP: f64 = 1.0 / 1024.0;

/// How noisy the ranges of a view are.
///
/// A stated noise is a length along the ray, the same at every pixel. An estimated one is in the
/// unit of the image's values: a triangulation sensor errs by a distance on its detector, which
/// stands for more length far away than nearby.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeNoise {
    known: Known,
    length: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Known {
    Length(f64),
    Value(f64),
}

impl RangeNoise {
    /// The noise that a view states; estimated if it states none.
    pub fn of(view: &View) -> Self {
        if let Some(sigma) = view.sigma() {
            return Self { known: Known::Length(sigma), length: sigma };
        }
        let value = estimate_value_sigma(view.image());
        Self { known: Known::Value(value), length: value * median_length_per_value(view) }
    }

    /// Standard deviation along the ray at the view's median pixel, in the model's length unit.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The noise as a length along the ray, where that is the same at every pixel.
    pub fn stated_length(&self) -> Option<f64> {
        match self.known {
            Known::Length(sigma) => Some(sigma),
            Known::Value(_) => None,
        }
    }

    /// Standard deviation of the image's value at a pixel with this [`length_per_value`].
    pub fn value_sigma(&self, length_per_value: f64) -> f64 {
        match self.known {
            Known::Length(sigma) => sigma / length_per_value,
            Known::Value(sigma) => sigma,
        }
    }

    /// Standard deviation along the ray at a pixel of a view, in the model's length unit.
    pub fn length_at(&self, view: &View, pixel: Pixel) -> f64 {
        match self.known {
            Known::Length(sigma) => sigma,
            Known::Value(sigma) => {
                let d3 = view.image().get(pixel).map(f64::from);
                let rate = d3.and_then(|d3| length_per_value(view.frame(), pixel, d3));
                rate.map_or(self.length, |rate| sigma * rate)
            }
        }
    }
}

/// Standard deviation of the ranges of a view along their rays, estimated from its image, at the
/// view's median pixel; see [`estimate_value_sigma`].
///
/// # Units
/// The model's length unit, whatever the image's values are.
pub fn estimate_sigma(view: &View) -> f64 {
    let value = estimate_value_sigma(view.image());
    if value == 0.0 { 0.0 } else { value * median_length_per_value(view) }
}

/// Standard deviation of the values of an image, estimated from the image itself.
///
/// The third difference `d[k+3] − 3 d[k+2] + 3 d[k+1] − d[k]` of a smooth surface is noise alone,
/// with variance 20 σ²; the second one would still see its curvature. The smallest 70 % are taken,
/// since the others may be at jumps, and their mean square is set against what it is for normal
/// noise: unlike a quantile it sees coarsely quantised values, most of whose differences are 0.
/// Rows and columns are looked at separately and the smaller result is taken, so that texture or
/// steps in one direction do not count. 0 if no four neighbours are valid. Texture finer than four
/// pixels in both directions counts as noise; noise that neighbours share is not seen.
///
/// # Units
/// That of the image's values.
pub fn estimate_value_sigma(image: &RangeImage) -> f64 {
    let (mut along, mut down) = (along_rows(image), down_columns(image));
    let fewest = along.len().max(down.len()) / 10;
    let estimates =
        [&mut along, &mut down].map(|d| if d.len() < fewest { None } else { spread(d) });
    let [along, down] = estimates;
    match (along, down) {
        (Some(a), Some(b)) => a.min(b),
        (a, b) => a.or(b).unwrap_or(0.0),
    }
}

/// Third differences within rows.
fn along_rows(image: &RangeImage) -> Vec<f64> {
    let rows = image.size().rows;
    let mut differences = Vec::new();
    for row in (0..rows).step_by(rows.div_ceil(LINES).max(1)) {
        for four in image.row(row).windows(4) {
            keep(&mut differences, [four[0], four[1], four[2], four[3]]);
        }
    }
    differences
}

/// Third differences within columns, from groups of four rows.
fn down_columns(image: &RangeImage) -> Vec<f64> {
    let rows = image.size().rows;
    let mut differences = Vec::new();
    for top in (0..rows.saturating_sub(3)).step_by(rows.div_ceil(LINES).max(1)) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| image.row(top + k));
        for (((a, b), c), d) in a.iter().zip(b).zip(c).zip(d) {
            keep(&mut differences, [*a, *b, *c, *d]);
        }
    }
    differences
}

fn keep(differences: &mut Vec<f64>, four: [f32; 4]) {
    let [a, b, c, d] = four.map(f64::from);
    let third = ((d - a) - 3.0 * (c - b)).abs();
    if !third.is_nan() {
        differences.push(third);
    }
}

/// Standard deviation of the values of which these are third differences, without the largest.
fn spread(differences: &mut [f64]) -> Option<f64> {
    if differences.is_empty() {
        return None;
    }
    let kept = ((differences.len() as f64 * KEPT) as usize).clamp(1, differences.len());
    differences.select_nth_unstable_by(kept - 1, f64::total_cmp);
    // Sorted, because selection leaves an unspecified order, and sums depend on the order.
    let smallest = &mut differences[..kept];
    smallest.sort_unstable_by(f64::total_cmp);
    let mean_square = smallest.iter().map(|d| d * d).sum::<f64>() / kept as f64;
    Some((mean_square / VARIANCE_OF_KEPT / VARIANCE_OF_DIFFERENCE).sqrt())
}

/// Length along a pixel's ray per unit of its value; `None` where the value means no point.
///
/// By a difference of [`DeviceFrame::point`], so it holds for every sensor.
pub fn length_per_value(frame: &dyn DeviceFrame, pixel: Pixel, d3: f64) -> Option<f64> {
    let step = VALUE_STEP * d3;
    let here = || frame.point(pixel, d3);
    let (below, above) = (frame.point(pixel, d3 - step), frame.point(pixel, d3 + step));
    let (from, to, width) = match (below, above) {
        (Some(below), Some(above)) => (below, above, 2.0 * step),
        (Some(below), None) => (below, here()?, step),
        (None, Some(above)) => (here()?, above, step),
        (None, None) => return None,
    };
    let rate = (to - from).norm() / width;
    (rate.is_finite() && rate > 0.0).then_some(rate)
}

/// The median over a lattice of the view's pixels; 1 if no pixel has a rate.
fn median_length_per_value(view: &View) -> f64 {
    let rates_of = |count: usize| -> Vec<f64> {
        let pixels = lattice(view.image(), count);
        pixels.filter_map(|(p, d3)| length_per_value(view.frame(), p, d3)).collect()
    };
    let mut rates = rates_of(LATTICE);
    if rates.is_empty() {
        // So few valid pixels that the lattice missed them all.
        rates = rates_of(usize::MAX);
    }
    if rates.is_empty() {
        return 1.0;
    }
    let middle = rates.len() / 2;
    *rates.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Valid pixels and their values, about `count` by `count` evenly over the image.
pub(crate) fn lattice(image: &RangeImage, count: usize) -> impl Iterator<Item = (Pixel, f64)> {
    let size = image.size();
    let steps = (size.rows.div_ceil(count).max(1), size.cols.div_ceil(count).max(1));
    let rows = (0..size.rows).step_by(steps.0);
    let pixels = rows
        .flat_map(move |row| (0..size.cols).step_by(steps.1).map(move |col| Pixel { row, col }));
    pixels.filter_map(|p| image.get(p).map(|d3| (p, f64::from(d3))))
}
