//! How noise grows with the value.

use super::differences::{Values, spread, third_difference};
use std::borrow::Cow;
use transect_device::RangeImage;

/// Most rows that are read. No unit. Chosen by hand: they hold some thousand differences of each
/// quarter. Doubled, it takes twice the time.
const READ_ROWS: usize = 32;

/// Least number of differences. Chosen by hand: the noise of a quarter of them is known to 10 %.
/// Doubled, small images count as having the same noise everywhere.
const LEAST_COUNT: usize = 400;

/// Least factor between the median values of the last quarter and of the first. No unit. Theory:
/// noise that grows with the square of the value then differs by 1.21, and the boundary between
/// both answers is at 1.1; the estimate errs by 2 to 3 %. Doubled, most rooms have no such depths.
const LEAST_FACTOR: f64 = 1.1;

/// How the standard deviation of a value grows with the value.
///
/// A depth camera errs by a disparity, the same near and far. Its depths are the inverses of
/// disparities, so they err by the square of the depth. A laser scanner errs by a length.
///
/// Measured, against one noise for all depths, median / 95 % distance: the sections of `room_kin40`
/// err by 0.25 / 0.99 instead of 0.27 / 1.25 mm, and those of `room_kin40_drift` at refined poses
/// by 1.44 / 7.7 instead of 1.93 / 8.3 mm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Growth {
    /// Every value has the same noise.
    Same,
    /// Noise grows with the square of the value: the inverse values have the same noise.
    Square,
}

impl Growth {
    /// The growth in an image, from the noise of the smallest quarter of some values and of the
    /// largest.
    ///
    /// Noise that grows with a power p of the value has the ratio `(largest / smallest)ᵖ` between
    /// both quarters. A power above 1 is nearer to 2 than to 0.
    pub fn of(image: &RangeImage) -> Self {
        let step = image.size().rows.div_ceil(READ_ROWS).max(1);
        let rows = (0..image.size().rows).step_by(step).map(|row| image.row(row));
        let groups = rows.flat_map(|row| row.windows(4)).filter_map(<[f32]>::first_chunk);
        let samples = groups.map(|group| (group[1], third_difference(*group)));
        let mut samples: Vec<_> = samples.filter(|(_, third)| !third.is_nan()).collect();
        let (count, quarter) = (samples.len(), samples.len() / 4);
        if count < LEAST_COUNT {
            return Self::Same;
        }
        samples.select_nth_unstable_by_key(quarter, by_value);
        let smallest = Quarter::of(&mut samples[..quarter]);
        samples.select_nth_unstable_by_key(count - quarter, by_value);
        let largest = Quarter::of(&mut samples[count - quarter..]);
        let (Some(smallest), Some(largest)) = (smallest, largest) else { return Self::Same };
        let factor = largest.value / smallest.value;
        if factor > LEAST_FACTOR && largest.noise > factor * smallest.noise {
            Self::Square
        } else {
            Self::Same
        }
    }

    /// The values with the same noise everywhere: those of an image, or their inverses.
    pub fn with_even_noise(self, image: &RangeImage) -> Values<'_> {
        let values = image.values();
        let values = match self {
            Self::Same => Cow::Borrowed(values),
            Self::Square => values.iter().map(|value| 1.0 / value).collect(),
        };
        Values { size: image.size(), values }
    }

    /// Standard deviation of a value over that of its value with even noise.
    pub fn factor(self, value: f64) -> f64 {
        match self {
            Self::Same => 1.0,
            Self::Square => value * value,
        }
    }
}

/// A quarter of the values.
struct Quarter {
    /// Their median.
    value: f64,
    noise: f64,
}

impl Quarter {
    /// The quarter of these values, each with the third difference beside it.
    fn of(samples: &mut [(f32, f32)]) -> Option<Self> {
        let (_, &mut (value, _), _) =
            samples.select_nth_unstable_by_key(samples.len() / 2, by_value);
        let mut thirds: Vec<f32> = samples.iter().map(|(_, third)| *third).collect();
        Some(Self { value: f64::from(value), noise: spread(&mut thirds)? })
    }
}

/// The order of samples by their values, which are positive: that of their bits.
fn by_value((value, _): &(f32, f32)) -> u32 {
    value.to_bits()
}
