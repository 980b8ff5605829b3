//! Values for gaps one pixel wide, for what windows around them ask of them alone.

use crate::smooth::REACH;
use crate::smooth::grid::Grid;
use crate::smooth::pairs::ones;
use crate::smooth::scales::Scales;

/// Standard deviations by which continuations from both sides may differ.
const AGREEMENT: f32 = 4.0;

/// Which missing pixels were filled: one bit per place, as in [`Grid::links`].
#[derive(Debug)]
pub(in crate::smooth) struct Filled(pub Vec<u64>);

impl Filled {
    /// Gives gaps one pixel wide quantities, which count for windows that ask for filled places alone.
    pub fn new(grid: &mut Grid<'_>, scales: &Scales) -> Self {
        let (words, rows) = (grid.links.words(), scales.inverse_sigma.len() / scales.width);
        let mut filled = Self(vec![0; words * (rows + 2 * REACH)]);
        let mut between = vec![0; words];
        for row in 0..rows {
            grid.links.missing_between(row, &mut between);
            let (first, end) = grid.columns();
            for place in ones(&between).filter(|place| (first..end).contains(place)) {
                filled.fill(grid, (row + REACH, place), scales);
            }
        }
        filled
    }

    /// Fills a missing pixel if its neighbours tell its value.
    fn fill(&mut self, grid: &mut Grid<'_>, (row, place): (usize, usize), scales: &Scales) {
        let links = &grid.links;
        let sample = |known: bool, row, place| known.then(|| grid.at(row, place));
        // Those next to it need to be there, those beyond must be joined to them.
        let along = [
            sample(links.left(row, place - 1), row, place - 2),
            sample(links.valid(row, place - 1), row, place - 1),
            sample(links.valid(row, place + 1), row, place + 1),
            sample(links.left(row, place + 2), row, place + 2),
        ];
        let down = [
            sample(links.up(row - 1, place), row - 2, place),
            sample(links.valid(row - 1, place), row - 1, place),
            sample(links.valid(row + 1, place), row + 1, place),
            sample(links.up(row + 2, place), row + 2, place),
        ];
        let scale = |beside: [(usize, usize); 2]| scale(grid, scales, (row, place), beside);
        let along = between(along, scale([(row, place - 1), (row, place + 1)]));
        let down = between(down, scale([(row - 1, place), (row + 1, place)]));
        let value = match (along, down) {
            (Some(along), Some(down)) => 0.5 * (along + down),
            (Some(value), None) | (None, Some(value)) => value,
            (None, None) => return,
        };
        let words = links.words();
        for place in grid.copies(place) {
            grid.fill(row, place, value);
            self.0[row * words + place / 64] |= 1 << (place % 64);
        }
    }
}

/// 1 over the standard deviation of the quantity at a missing pixel; 0 if that is not known.
///
/// A block of pixels that are all missing has none of its own, as in a missing row: then it is that of the
/// samples beside the gap, and the noisier one's, since that one explains more.
fn scale(
    grid: &Grid<'_>,
    scales: &Scales,
    (row, place): (usize, usize),
    beside: [(usize, usize); 2],
) -> f32 {
    let at = |(row, place): (usize, usize)| {
        let (row, col) = (row.checked_sub(REACH)?, grid.column(place)?);
        scales.inverse_sigma.get(row * scales.width + col).copied().filter(|scale| *scale > 0.0)
    };
    let noisier = beside.into_iter().filter_map(at).reduce(f32::min);
    at((row, place)).or(noisier).unwrap_or(0.0)
}

/// The value in the middle of a line of five, from those that are known of two on either side.
///
/// The cubic through four samples or the parabola through three; `None` if the two sides do not
/// continue each other, or `inverse_sigma` is 0.
fn between(
    [far_before, before, after, far_after]: [Option<f32>; 4],
    inverse_sigma: f32,
) -> Option<f32> {
    // Where nothing is known of the noise, there is no telling, and no window either.
    if inverse_sigma <= 0.0 {
        return None;
    }
    let (before, after) = (before?, after?);
    // How far the sides are apart, and its variance in variances of a sample.
    let (value, apart, variance) = match (far_before, far_after) {
        (Some(b), Some(a)) => {
            let apart = (2.0 * before - b) - (2.0 * after - a);
            ((4.0 * (before + after) - (a + b)) / 6.0, apart, 10.0_f32)
        }
        (Some(b), None) => (before + (after - b) / 3.0, 3.0 * before - 2.0 * b - after, 14.0),
        (None, Some(a)) => (after + (before - a) / 3.0, 3.0 * after - 2.0 * a - before, 14.0),
        (None, None) => return None,
    };
    (apart.abs() * inverse_sigma <= AGREEMENT * variance.sqrt()).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::one_pass::Instructions;
    use crate::smooth::Smoother;
    use crate::{BreakRule, RangeNoise};
    use fearless_simd::dispatch;
    use std::sync::Arc;
    use transect_device::{ImageSize, Isometry3, RangeImage, View};
    use transect_sensors::{Intrinsics, Pinhole};

    const SIZE: ImageSize = ImageSize { rows: 24, cols: 40 };

    /// How many pixels are filled of a row that is missing between a wall and another one behind it.
    fn filled_of_a_row(step: f32) -> u32 {
        let values = (0..SIZE.pixels()).map(|pixel| match pixel / SIZE.cols {
            12 => f32::NAN,
            row if row < 12 => 3.0,
            _ => 3.0 + step,
        });
        let image = RangeImage::from_values(SIZE, values.collect()).unwrap();
        let intrinsics = Intrinsics { fx: 120.0, fy: 120.0, cx: 19.5, cy: 11.5 };
        let frame = Arc::new(Pinhole::new(SIZE, intrinsics).unwrap());
        let view = View::new("step", image, frame, Isometry3::identity(), Some(0.02)).unwrap();
        let (noise, rule) = (RangeNoise::of(&view), BreakRule::new(1.36, 0.08));
        let level = Instructions::Best.level();
        let mut smoother = dispatch!(level, simd => Smoother::new(simd, &view, &noise, &rule));
        smoother.fill().0.iter().map(|word| word.count_ones()).sum()
    }

    #[test]
    fn a_missing_row_is_filled_on_a_wall_and_not_across_a_step() {
        assert_eq!(filled_of_a_row(0.0), SIZE.cols as u32);
        assert_eq!(filled_of_a_row(0.1), SIZE.cols as u32);
        assert_eq!(filled_of_a_row(0.4), 0);
    }

    #[test]
    fn without_a_scale_nothing_is_filled() {
        assert_eq!(between([Some(1.0); 4], 0.0), None);
    }

    #[test]
    fn parabolas_are_continued_exactly_and_steps_are_not() {
        let parabola = |x: f32| 3.0 - 0.5 * x + 0.25 * x * x;
        let samples = [-2.0, -1.0, 1.0, 2.0].map(|x| Some(parabola(x)));
        for missing in [None, Some(0), Some(3)] {
            let mut samples = samples;
            if let Some(k) = missing {
                samples[k] = None;
            }
            let found = between(samples, 0.1).unwrap();
            assert!((found - 3.0).abs() < 1e-6, "{missing:?}: {found}");
        }
        let step = [Some(1.0), Some(1.0), Some(2.0), Some(2.0)];
        assert_eq!(between(step, 13.0), None);
        assert_eq!(between(step, 12.0), Some(1.5));
        assert_eq!(between([None, Some(1.0), Some(1.0), None], 1.0), None);
        assert_eq!(between([Some(1.0), None, Some(1.0), Some(1.0)], 1.0), None);
    }
}
