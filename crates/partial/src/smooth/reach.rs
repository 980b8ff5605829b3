//! Which pixels can take part in a curve, whatever smoothing makes of them.
//!
//! A smoothed pixel differs from the given one by less than a cut (see `block.rs`), so its level stays
//! between those of the two ends of that stretch of its ray. A cell of four pixels none of whose
//! stretches has a plane between it and another carries no curve. The pixels of all other cells
//! count, and one more on every side, so that curves may be interpolated from four samples in line.

use super::block::CUT;
use super::quantity::Quantity;
use super::{Samples, Smoother};
use crate::SectionAxes;
use fearless_simd::Simd;
use transect_device::{RangeImage, SeparableForm, Vector3};

/// Rounding of a level in single precision, as a share of the largest that the image may have.
const LEVEL_ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// Rounding of a value and of its change in single precision, as shares of each.
const VALUE_ROUNDING: f32 = 8e-7;
const CUT_ROUNDING: f32 = 2e-5;
const LARGEST_CUT: f32 = CUT as f32 * (1.0 + CUT_ROUNDING);

/// An end of a stretch is known if it is at least this share of the sample, or this the share of it.
const LEAST_END: f32 = 0.5;

/// What the levels of a row's pixels may be: the lowest and the highest plane at or over each. A missing
/// pixel's are the wrong way round.
#[derive(Debug, Clone)]
struct Stretches {
    low: Vec<f32>,
    high: Vec<f32>,
}

impl Stretches {
    fn missing(cols: usize) -> Self {
        Self { low: vec![f32::INFINITY; cols], high: vec![f32::NEG_INFINITY; cols] }
    }
}

/// Where the planes are, as seen from the samples.
pub(super) struct Reach<'a> {
    levels: Levels<'a>,
    slack: f32,
}

impl<'a> Reach<'a> {
    /// `None` if nothing can be said.
    pub fn new(smoother: &Smoother<'_>, axes: &'a SectionAxes) -> Option<Self> {
        let levels = Levels::new(smoother, axes)?;
        Some(Self { levels, slack: slack(&smoother.samples, axes) })
    }

    /// One entry per pixel, row-major: whether it can take part in a curve.
    #[inline(always)]
    pub fn wanted<S: Simd>(&self, simd: S, smoother: &Smoother<'_>) -> Vec<bool> {
        let image = smoother.samples.view.image();
        let size = image.size();
        let mut wanted = vec![false; size.pixels()];
        let [mut above, mut here] = [Stretches::missing(size.cols), Stretches::missing(size.cols)];
        let mut ends = [vec![f32::NAN; size.cols], vec![f32::NAN; size.cols]];
        let mut cells = Cells::new(size.cols, smoother.samples.view.frame().columns_wrap());
        for row in 0..size.rows {
            self.levels.of_row(simd, smoother, row, &mut ends);
            simd.vectorize(
                #[inline(always)]
                || {
                    stretch(image.row(row), &ends, self.slack, &mut here);
                    cells.find(&above, &here);
                    cells.mark(row, &mut wanted);
                },
            );
            std::mem::swap(&mut above, &mut here);
        }
        wanted
    }
}

/// Finds the stretches of a row from the levels of their ends.
#[inline(always)]
fn stretch(values: &[f32], [a, b]: &[Vec<f32>; 2], slack: f32, stretches: &mut Stretches) {
    let out = stretches.low.iter_mut().zip(&mut stretches.high);
    for ((value, (a, b)), (low, high)) in values.iter().zip(a.iter().zip(b)).zip(out) {
        let beyond = a.is_nan() | b.is_nan();
        // The ray's end may be beyond what the sensor can say: then anything is possible.
        let lowest = if beyond { f32::NEG_INFINITY } else { (a.min(*b) - slack).ceil() };
        let highest = if beyond { f32::INFINITY } else { (a.max(*b) + slack).ceil() };
        let missing = value.is_nan();
        *low = if missing { f32::INFINITY } else { lowest };
        *high = if missing { f32::NEG_INFINITY } else { highest };
    }
}

/// The cells between two rows, and which of them a plane may cross.
struct Cells {
    wraps: bool,
    /// Lowest and highest of each column's two pixels, after those of the column before the first.
    low: Vec<f32>,
    high: Vec<f32>,
    /// Cells by their right column, after one that stands for what is left of them, and before two.
    crossed: Vec<bool>,
}

impl Cells {
    fn new(cols: usize, wraps: bool) -> Self {
        let (low, high) = (vec![f32::INFINITY; cols + 1], vec![f32::NEG_INFINITY; cols + 1]);
        Self { wraps, low, high, crossed: vec![false; cols + 3] }
    }

    /// Finds the cells that may be crossed.
    #[inline(always)]
    fn find(&mut self, above: &Stretches, here: &Stretches) {
        let cols = here.low.len();
        for (low, (a, b)) in self.low[1..].iter_mut().zip(above.low.iter().zip(&here.low)) {
            *low = a.min(*b);
        }
        for (high, (a, b)) in self.high[1..].iter_mut().zip(above.high.iter().zip(&here.high)) {
            *high = a.max(*b);
        }
        if self.wraps {
            (self.low[0], self.high[0]) = (self.low[cols], self.high[cols]);
        }
        let pairs = self.low.windows(2).zip(self.high.windows(2));
        for (crossed, (low, high)) in self.crossed[1..=cols].iter_mut().zip(pairs) {
            *crossed = low[0].min(low[1]) < high[0].max(high[1]);
        }
        if self.wraps {
            let at = |k: usize| 1 + k % cols;
            self.crossed[0] = self.crossed[cols];
            self.crossed[cols + 1] = self.crossed[at(0)];
            self.crossed[cols + 2] = self.crossed[at(1)];
        }
    }

    /// Marks the pixels of the cells between a row and the one above, and those around them.
    #[inline(always)]
    fn mark(&self, row: usize, wanted: &mut [bool]) {
        if !self.crossed.contains(&true) {
            return;
        }
        let cols = self.low.len() - 1;
        let first = row.saturating_sub(2);
        for wanted in wanted[first * cols..].chunks_mut(cols).take(row + 2 - first) {
            for (wanted, cells) in wanted.iter_mut().zip(self.crossed.windows(4)) {
                *wanted |= cells[0] | cells[1] | cells[2] | cells[3];
            }
        }
    }
}

/// Where levels come from.
enum Levels<'a> {
    /// Of sensors that have tables.
    Form(SeparableForm),
    /// The image with every value moved by a cut either way, NaN where it cannot be.
    Images([RangeImage; 2], &'a SectionAxes),
}

impl<'a> Levels<'a> {
    fn new(smoother: &Smoother<'_>, axes: &'a SectionAxes) -> Option<Self> {
        let image = smoother.samples.view.image();
        if let Some(form) = smoother.samples.view.frame().separable_form(axes.level()) {
            return Some(Self::Form(form));
        }
        let size = image.size();
        let mut images = [vec![f32::NAN; size.pixels()], vec![f32::NAN; size.pixels()]];
        let [low, high] = &mut images;
        let rows = low.chunks_mut(size.cols).zip(high.chunks_mut(size.cols));
        for (row, ends) in rows.enumerate() {
            find_ends(smoother, row, ends);
        }
        let [low, high] = images.map(|values| RangeImage::from_values(size, values));
        Some(Self::Images([low.ok()?, high.ok()?], axes))
    }

    /// The levels of a row's ends.
    #[inline(always)]
    fn of_row<S: Simd>(
        &self,
        simd: S,
        smoother: &Smoother<'_>,
        row: usize,
        [low, high]: &mut [Vec<f32>; 2],
    ) {
        match self {
            Self::Form(form) => simd.vectorize(
                #[inline(always)]
                || {
                    find_ends(smoother, row, (&mut *low, &mut *high));
                    let [factor, addend] = form.rows.get(row).copied().unwrap_or_default();
                    for levels in [low, high] {
                        for (level, column) in levels.iter_mut().zip(&form.columns) {
                            *level = *level * (column * factor + addend) + form.constant;
                        }
                    }
                },
            ),
            Self::Images(images, axes) => {
                for (image, levels) in images.iter().zip([low, high]) {
                    smoother.samples.view.frame().form_row(image, row, axes.level(), levels);
                }
            }
        }
    }
}

/// A row's values moved by a cut either way; NaN where they cannot be.
#[inline(always)]
fn find_ends(smoother: &Smoother<'_>, row: usize, ends: (&mut [f32], &mut [f32])) {
    let values = smoother.samples.view.image().row(row);
    let inverse_sigma = &smoother.scales.inverse_sigma[row * smoother.scales.width..];
    match smoother.samples.quantity {
        Quantity::Value => {
            let moved = |value: f32, cut: f32| (value - cut, value + cut);
            find_moved(values, inverse_sigma, ends, moved);
        }
        Quantity::Inverse => {
            // Those of 1 / value ± cut.
            let moved =
                |value: f32, cut: f32| (value / (1.0 + cut * value), value / (1.0 - cut * value));
            find_moved(values, inverse_sigma, ends, moved);
        }
    }
}

#[inline(always)]
fn find_moved(
    values: &[f32],
    inverse_sigma: &[f32],
    (low, high): (&mut [f32], &mut [f32]),
    of: impl Fn(f32, f32) -> (f32, f32),
) {
    let samples = values.iter().zip(inverse_sigma);
    for ((value, inverse_sigma), (low, high)) in samples.zip(low.iter_mut().zip(high)) {
        // Pixels without a scale stay as they are.
        let cut = if *inverse_sigma > 0.0 { LARGEST_CUT / inverse_sigma } else { 0.0 };
        let (nearest, farthest) = of(*value, cut);
        // Where little is left of one end, rounding would count, too; and there may be none.
        let known =
            (nearest > value * LEAST_END) & (farthest * LEAST_END < *value) & (farthest > 0.0);
        *low = if known { nearest * (1.0 - VALUE_ROUNDING) } else { f32::NAN };
        *high = if known { farthest * (1.0 + VALUE_ROUNDING) } else { f32::NAN };
    }
}

/// What rounding can move a level by.
fn slack(samples: &Samples<'_>, axes: &SectionAxes) -> f32 {
    let level = axes.level();
    let Some((near, far)) = samples.view.image().extremes() else { return 0.0 };
    let (near, far) = (f64::from(near), f64::from(far));
    let along = |k: usize| {
        // A form along one axis leaves two extents, which take the whole image, unasked.
        if level.gradient[k] == 0.0 {
            return 0.0;
        }
        let mut axis = Vector3::zeros();
        axis[k] = level.gradient[k];
        let (low, high) = samples.view.frame().extent(&axis, near, far);
        low.abs().max(high.abs())
    };
    let largest = level.constant.abs() + along(0) + along(1) + along(2);
    (largest * LEVEL_ROUNDING) as f32
}
