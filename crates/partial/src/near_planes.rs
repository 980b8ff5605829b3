//! Which pixels are near enough to a plane to take part in a curve, and need to be smoothed.
//!
//! Smoothing keeps each value within bounds, so the level of a pixel stays between those of its two
//! bounds. A cell of four pixels whose levels cannot have a plane between them carries no curve.
//! The pixels of all other cells count.
//!
//! Smoothing these pixels alone gives the curves of a view that is smoothed everywhere.
//!
//! **Gain.** Measured once, on whole runs with two threads. Smoothing every pixel takes at least
//! 1.9 times as long on the red kitchen, 1.7 times on `kitchen_kin40_real`, and 1.1 to 1.3 times on
//! `room_sph12_n01`. It takes no longer on the bunny, whose planes are as dense as its pixels.

use crate::SectionAxes;
use fearless_simd::{Simd, dispatch};
use transect_device::{Vector3, View};
use transect_image::Instructions;
use transect_image::smooth::ValueBounds;

/// Rounding of a level in single precision, as a share of the largest level that the image can
/// have.
const LEVEL_ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// One entry per pixel, row-major: whether it can take part in a curve.
pub fn near_planes(
    view: &View,
    axes: &SectionAxes,
    bounds: &ValueBounds,
    with: Instructions,
) -> Vec<bool> {
    let size = view.image().size();
    let mut near = vec![false; size.pixels()];
    let mut cells = Cells::new(size.cols, view.frame().columns_wrap());
    let slack = slack(view, axes);
    for row in 0..size.rows {
        let [low, high] = &mut cells.ends;
        view.frame().form_row(&bounds.low, row, axes.level(), low);
        view.frame().form_row(&bounds.high, row, axes.level(), high);
        dispatch!(with.level(), simd => cells.find(simd, view.image().row(row), slack));
        cells.mark(row, &mut near);
    }
    near
}

/// The lowest and the highest plane at or over each pixel of a row. A missing pixel's are the wrong
/// way round.
#[derive(Debug, Clone)]
struct Span {
    low: Vec<f32>,
    high: Vec<f32>,
}

/// The cells between two rows, and which of them a plane may cross.
struct Cells {
    wraps: bool,
    /// Levels of both bounds of the row's pixels.
    ends: [Vec<f32>; 2],
    above: Span,
    here: Span,
    /// Both rows together by column, after those of the column before the first.
    both: Span,
    /// Cells by their right column, and the one to the right of the last column.
    crossed: Vec<bool>,
}

impl Cells {
    fn new(cols: usize, wraps: bool) -> Self {
        let missing =
            |cols| Span { low: vec![f32::INFINITY; cols], high: vec![f32::NEG_INFINITY; cols] };
        let ends = [vec![f32::NAN; cols], vec![f32::NAN; cols]];
        let (above, here, both) = (missing(cols), missing(cols), missing(cols + 1));
        Self { wraps, ends, above, here, both, crossed: vec![false; cols + 1] }
    }

    /// Finds the cells between the next row and the last one that may be crossed.
    fn find<S: Simd>(&mut self, simd: S, values: &[f32], slack: f32) {
        std::mem::swap(&mut self.above, &mut self.here);
        simd.vectorize(
            #[inline(always)]
            || {
                self.here.read(values, &self.ends, slack);
                self.compare();
            },
        );
    }

    #[inline(always)]
    fn compare(&mut self) {
        let cols = self.here.low.len();
        let lows = self.above.low.iter().zip(&self.here.low);
        for (low, (a, b)) in self.both.low[1..].iter_mut().zip(lows) {
            *low = a.min(*b);
        }
        let highs = self.above.high.iter().zip(&self.here.high);
        for (high, (a, b)) in self.both.high[1..].iter_mut().zip(highs) {
            *high = a.max(*b);
        }
        let Span { low, high } = &mut self.both;
        if self.wraps {
            (low[0], high[0]) = (low[cols], high[cols]);
        }
        let pairs = low.windows(2).zip(high.windows(2));
        for (crossed, (low, high)) in self.crossed[..cols].iter_mut().zip(pairs) {
            *crossed = low[0].min(low[1]) < high[0].max(high[1]);
        }
        if self.wraps {
            self.crossed[cols] = self.crossed[0];
        }
    }

    /// Marks the pixels of the crossed cells between a row and the one above.
    fn mark(&self, row: usize, near: &mut [bool]) {
        if !self.crossed.contains(&true) {
            return;
        }
        let cols = self.here.low.len();
        let first = row.saturating_sub(1);
        for near in near[first * cols..(row + 1) * cols].chunks_mut(cols) {
            for (near, cells) in near.iter_mut().zip(self.crossed.windows(2)) {
                *near |= cells[0] | cells[1];
            }
        }
    }
}

impl Span {
    /// Reads a row from its values and the levels of their bounds.
    #[inline(always)]
    fn read(&mut self, values: &[f32], [a, b]: &[Vec<f32>; 2], slack: f32) {
        let out = self.low.iter_mut().zip(&mut self.high);
        for ((value, (a, b)), (low, high)) in values.iter().zip(a.iter().zip(b)).zip(out) {
            // Without bounds, every level is possible.
            let unknown = a.is_nan() | b.is_nan();
            let lowest = if unknown { f32::NEG_INFINITY } else { (a.min(*b) - slack).ceil() };
            let highest = if unknown { f32::INFINITY } else { (a.max(*b) + slack).ceil() };
            let missing = value.is_nan();
            *low = if missing { f32::INFINITY } else { lowest };
            *high = if missing { f32::NEG_INFINITY } else { highest };
        }
    }
}

/// The largest change of a level by rounding.
fn slack(view: &View, axes: &SectionAxes) -> f32 {
    let level = axes.level();
    let Some((near, far)) = view.image().extremes() else { return 0.0 };
    let (near, far) = (f64::from(near), f64::from(far));
    let along = |k: usize| {
        // An extent takes the whole image, so it is not asked for along an axis without a part.
        if level.gradient[k] == 0.0 {
            return 0.0;
        }
        let mut axis = Vector3::zeros();
        axis[k] = level.gradient[k];
        let (low, high) = view.frame().extent(&axis, near, far);
        low.abs().max(high.abs())
    };
    let largest = level.constant.abs() + along(0) + along(1) + along(2);
    (largest * LEVEL_ROUNDING) as f32
}
