//! Which pixels can take part in a curve, whatever smoothing makes of them.
//!
//! A smoothed pixel differs from the given one by less than a cut (see `block.rs`), so its level stays
//! between those of the two ends of that stretch of its ray. A cell of four pixels none of whose
//! stretches has a plane between it and another carries no curve. The pixels of all other cells
//! count, and one more on every side, so that curves may be interpolated from four samples in line.

use super::Smoother;
use super::block::CUT;
use crate::{SectionAxes, length_per_value};
use transect_device::{Pixel, RangeImage, Vector3};

/// Rounding of a level in single precision, as a share of the largest that the image may have.
const LEVEL_ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// Rounding of a value and of its change in single precision, as shares of each.
const VALUE_ROUNDING: f64 = 3e-7;
const CUT_ROUNDING: f64 = 1e-5;

/// What the level of a pixel may be: the lowest and the highest plane at or over it. A missing pixel's
/// are the wrong way round.
type Stretch = (f32, f32);

const MISSING: Stretch = (f32::INFINITY, f32::NEG_INFINITY);
const ANYTHING: Stretch = (f32::NEG_INFINITY, f32::INFINITY);

/// One entry per pixel, row-major: whether it can take part in a curve.
pub(super) fn wanted(smoother: &Smoother<'_>, axes: &SectionAxes) -> Vec<bool> {
    let image = smoother.view.image();
    let size = image.size();
    let Some(ends) = nearest_and_farthest(smoother) else { return vec![true; size.pixels()] };
    let slack = slack(smoother, axes);
    let wraps = smoother.view.frame().columns_wrap();
    let mut wanted = vec![false; size.pixels()];
    let [mut above, mut here] = [vec![MISSING; size.cols], vec![MISSING; size.cols]];
    let mut levels = [vec![f32::NAN; size.cols], vec![f32::NAN; size.cols]];
    for row in 0..size.rows {
        for (levels, image) in levels.iter_mut().zip(&ends) {
            smoother.view.frame().form_row(image, row, axes.level(), levels);
        }
        let ends = levels[0].iter().zip(&levels[1]);
        for ((stretch, value), (a, b)) in here.iter_mut().zip(image.row(row)).zip(ends) {
            *stretch = match (value.is_nan(), a.is_nan() || b.is_nan()) {
                (true, _) => MISSING,
                // The ray's end is beyond what the sensor can say.
                (false, true) => ANYTHING,
                (false, false) => ((a.min(*b) - slack).ceil(), (a.max(*b) + slack).ceil()),
            };
        }
        mark(&above, &here, wraps, row, &mut wanted);
        std::mem::swap(&mut above, &mut here);
    }
    wanted
}

/// Marks the pixels of the cells between two rows, and those around them; `row` is the lower one.
fn mark(above: &[Stretch], here: &[Stretch], wraps: bool, row: usize, wanted: &mut [bool]) {
    let cols = here.len();
    let column = |col: usize| join(above[col], here[col]);
    let mut before = if wraps { column(cols - 1) } else { MISSING };
    for col in 0..cols {
        let this = column(col);
        let (low, high) = join(before, this);
        before = this;
        if low >= high {
            continue;
        }
        // Counted from the left neighbour's left neighbour.
        for place in col..col + 4 {
            let inside = (2..cols + 2).contains(&place);
            if !inside && !wraps {
                continue;
            }
            let col = (place + 2 * cols - 2) % cols;
            for row in row.saturating_sub(2)..=row + 1 {
                if let Some(wanted) = wanted.get_mut(row * cols + col) {
                    *wanted = true;
                }
            }
        }
    }
}

fn join(a: Stretch, b: Stretch) -> Stretch {
    (a.0.min(b.0), a.1.max(b.1))
}

/// The image with every value moved by a cut either way; NaN where it cannot be.
fn nearest_and_farthest(smoother: &Smoother<'_>) -> Option<[RangeImage; 2]> {
    let image = smoother.view.image();
    let size = image.size();
    // Noise of the values themselves asks for no length per value.
    let same_everywhere = smoother.noise.value_sigma(f64::NAN);
    let [mut low, mut high] = [vec![f32::NAN; size.pixels()], vec![f32::NAN; size.pixels()]];
    let samples = (0..size.rows).flat_map(|row| {
        image.row(row).iter().enumerate().map(move |(col, d3)| (Pixel { row, col }, f64::from(*d3)))
    });
    for ((pixel, d3), (low, high)) in samples.zip(low.iter_mut().zip(&mut high)) {
        let value_sigma = if same_everywhere.is_nan() {
            let rate = length_per_value(smoother.view.frame(), pixel, d3);
            rate.map_or(f64::NAN, |rate| smoother.noise.value_sigma(rate))
        } else {
            same_everywhere
        };
        let cut = CUT * smoother.quantity.sigma(d3, value_sigma);
        let (middle, cut) = (smoother.quantity.of_value(d3), cut * (1.0 + CUT_ROUNDING));
        // In the quantity's order; which of them is nearer does not matter.
        let ends = [middle - cut, middle + cut].map(|q| smoother.quantity.value(q));
        if ends.iter().all(|value| *value > 0.0) {
            *low = (ends[0].min(ends[1]) * (1.0 - VALUE_ROUNDING)) as f32;
            *high = (ends[0].max(ends[1]) * (1.0 + VALUE_ROUNDING)) as f32;
        }
    }
    Some([RangeImage::from_values(size, low).ok()?, RangeImage::from_values(size, high).ok()?])
}

/// What rounding can move a level by.
fn slack(smoother: &Smoother<'_>, axes: &SectionAxes) -> f32 {
    let level = axes.level();
    let Some((near, far)) = smoother.view.image().extremes() else { return 0.0 };
    let (near, far) = (f64::from(near), f64::from(far));
    let along = |k: usize| {
        let mut axis = Vector3::zeros();
        axis[k] = level.gradient[k];
        let (low, high) = smoother.view.frame().extent(&axis, near, far);
        low.abs().max(high.abs())
    };
    let largest = level.constant.abs() + along(0) + along(1) + along(2);
    (largest * LEVEL_ROUNDING) as f32
}
