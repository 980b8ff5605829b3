//! How far smoothing can move each value.

use super::Smoother;
use crate::RangeNoise;
use crate::tuning::LARGEST_CHANGE;
use fearless_simd::Simd;
use transect_device::RangeImage;

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
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, smoother: &Smoother<'_>) -> Option<Self> {
        let image = smoother.view.image();
        let size = image.size();
        let [mut low, mut high] = [(); 2].map(|()| vec![f32::NAN; size.pixels()]);
        let mut rates = vec![0.0; size.cols];
        let out = low.chunks_mut(size.cols).zip(high.chunks_mut(size.cols));
        simd.vectorize(
            #[inline(always)]
            || {
                for (row, (low, high)) in out.enumerate() {
                    smoother.grid.pairs.lengths_per_value(row, image.row(row), &mut rates);
                    let pixels = image.row(row).iter().zip(&rates);
                    for ((value, rate), (low, high)) in pixels.zip(low.iter_mut().zip(high)) {
                        let change = relative_change(smoother.noise, *rate, *value);
                        (*low, *high) = (value * (1.0 - change), value / (1.0 - change));
                    }
                }
            },
        );
        let [low, high] = [low, high].map(|values| RangeImage::from_values(size, values).ok());
        Some(Self { low: low?, high: high? })
    }
}

/// Largest change of a value by smoothing, as a share of it; NaN where it is not known.
#[inline(always)]
fn relative_change(noise: &RangeNoise, rate: f32, value: f32) -> f32 {
    let sigma = noise.value_sigma(f64::from(value), f64::from(rate)) as f32;
    let change = LARGEST_CHANGE * sigma / value + ROUNDING;
    if change < LARGEST_SHARE { change } else { f32::NAN }
}
