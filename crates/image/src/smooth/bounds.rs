//! How far smoothing can move each value.

use super::Smoother;
use crate::tuning::LARGEST_CHANGE;
use transect_device::{Pixel, RangeImage};

/// Share of a value by which its bounds are widened, for rounding in single precision.
const ROUNDING: f32 = 3e-5;

/// Largest change, as a share of the value, for which bounds are given.
const LARGEST_SHARE: f32 = 0.5;

/// The smallest and the largest value that smoothing can give each pixel.
///
/// A smoothed pixel differs from its sample by at most four standard deviations, in the value or in
/// its inverse. A pixel is missing in both images where its sample is missing and where no bound is
/// known.
#[derive(Debug, Clone)]
pub struct ValueBounds {
    /// The smallest values.
    pub low: RangeImage,
    /// The largest values.
    pub high: RangeImage,
}

impl ValueBounds {
    pub(super) fn new(smoother: &Smoother<'_>) -> Option<Self> {
        let image = smoother.view.image();
        let size = image.size();
        let [mut low, mut high] = [(); 2].map(|()| Vec::with_capacity(size.pixels()));
        for row in 0..size.rows {
            for (col, value) in image.row(row).iter().enumerate() {
                let change = relative_change(smoother, Pixel { row, col }, *value);
                low.push(value * (1.0 - change));
                high.push(value / (1.0 - change));
            }
        }
        let [low, high] = [low, high].map(|values| RangeImage::from_values(size, values).ok());
        Some(Self { low: low?, high: high? })
    }
}

/// Largest change of a value by smoothing, as a share of it; NaN where it is not known.
fn relative_change(smoother: &Smoother<'_>, pixel: Pixel, value: f32) -> f32 {
    let Some(rate) = smoother.grid.length_per_value(pixel, value) else { return f32::NAN };
    let sigma = smoother.noise.value_sigma(f64::from(rate)) as f32;
    let change = LARGEST_CHANGE * sigma / value + ROUNDING;
    if change < LARGEST_SHARE { change } else { f32::NAN }
}
