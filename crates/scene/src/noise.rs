//! What a real sensor does to a clean range, reproducibly.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::FRAC_PI_2;

/// Range noise and missing returns.
///
/// Random numbers come from ChaCha8 with the seed as key, the view's number as stream and the row
/// as position, two numbers for every pixel whether it is hit or not. A view's noise therefore
/// depends on nothing but (seed, view number, row, column): neither the order of the views nor
/// what stands in the scene changes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation of a normal error of the range **along the ray**, in the model's length
    /// unit, whatever the sensor's `d3` is.
    pub sigma: f64,
    /// Share of the pixels that return nothing for no reason, 0 to 1.
    pub dropout: f64,
    /// Largest angle between ray and surface normal that still returns, in radians; π/2 for all.
    pub max_incidence: f64,
    /// Key of the random numbers.
    pub seed: u64,
}

impl Noise {
    /// A perfect sensor.
    pub const NONE: Self = Self { sigma: 0.0, dropout: 0.0, max_incidence: FRAC_PI_2, seed: 0 };

    /// Whether every pixel is left as it is, so that no random number is needed.
    fn is_silent(&self) -> bool {
        self.sigma == 0.0 && self.dropout == 0.0
    }

    /// Smallest cosine of incidence that returns; `None` if all do.
    pub(crate) fn least_cosine(&self) -> Option<f64> {
        (self.max_incidence < FRAC_PI_2).then(|| self.max_incidence.cos())
    }

    /// The noise of one row of a view, column by column.
    pub(crate) fn row(&self, view: u64, row: usize) -> RowNoise {
        if self.is_silent() {
            return RowNoise { noise: *self, source: None };
        }
        let mut source = ChaCha8Rng::seed_from_u64(self.seed);
        source.set_stream(view);
        source.set_word_pos((row as u128) << WORDS_PER_ROW_LOG2);
        RowNoise { noise: *self, source: Some(source) }
    }
}

impl Default for Noise {
    fn default() -> Self {
        Self::NONE
    }
}

/// Room for the numbers of one row, in 32-bit words: more than the largest accepted image uses.
const WORDS_PER_ROW_LOG2: u32 = 36;

/// A row's random numbers; ask once for every column, from the first on.
pub(crate) struct RowNoise {
    noise: Noise,
    source: Option<ChaCha8Rng>,
}

impl RowNoise {
    /// The next pixel's error along its ray; `None` if it drops out.
    pub(crate) fn next_error(&mut self) -> Option<f64> {
        let Some(source) = &mut self.source else { return Some(0.0) };
        let uniform = (source.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let normal: f64 = StandardNormal.sample(source);
        (uniform >= self.noise.dropout).then_some(self.noise.sigma * normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE: Noise = Noise { sigma: 0.5, dropout: 0.1, seed: 7, ..Noise::NONE };

    fn draw(view: u64, row: usize, count: usize) -> Vec<Option<f64>> {
        let mut noise = NOISE.row(view, row);
        (0..count).map(|_| noise.next_error()).collect()
    }

    #[test]
    fn mean_spread_and_share_are_those_asked_for() {
        let all: Vec<_> = (0..100).flat_map(|row| draw(0, row, 1000)).collect();
        let kept: Vec<f64> = all.iter().flatten().copied().collect();
        let n = kept.len() as f64;
        let mean = kept.iter().sum::<f64>() / n;
        let sigma = (kept.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n).sqrt();
        // Four standard errors of 90 000 samples.
        assert!(mean.abs() < 4.0 * 0.5 / n.sqrt(), "{mean}");
        assert!((sigma - 0.5).abs() < 4.0 * 0.5 / (2.0 * n).sqrt(), "{sigma}");
        assert!((1.0 - n / 1e5 - 0.1).abs() < 4.0 * (0.09f64 / 1e5).sqrt());
    }

    #[test]
    fn rows_and_views_have_their_own_numbers() {
        assert_eq!(draw(3, 5, 50), draw(3, 5, 50));
        assert_ne!(draw(3, 5, 50), draw(3, 6, 50));
        assert_ne!(draw(3, 5, 50), draw(4, 5, 50));
    }

    #[test]
    fn a_perfect_sensor_errs_nowhere() {
        assert_eq!(Noise::NONE.row(1, 1).next_error(), Some(0.0));
        assert_eq!(Noise::NONE.least_cosine(), None);
    }
}
