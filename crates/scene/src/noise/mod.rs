//! Reproducible errors of a real sensor.
//!
//! A pixel goes through the effects in this order:
//!
//! 1. *dropout*: the pixel is missing, at random, on a surface that is too oblique, or on one that
//!    returns too little light;
//! 2. *mixed pixel*: at a range jump the spot falls on both surfaces, and the range is one between;
//! 3. *range noise*: a normal error along the ray, `σ = sigma + sigma_growth · range + sigma_square
//!    · range²`, which neighbouring pixels may share;
//! 4. *quantisation*: the stored value `d3` is a whole number of steps.
//!
//! A depth camera has errors of its own ([`DepthCamera`]): rays turn before they meet a surface,
//! and depths change before they are quantised. The pose error concerns the whole view.

mod camera;
mod field;

pub use camera::DepthCamera;
pub(crate) use camera::Optics;
pub(crate) use field::Field;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use std::f64::consts::FRAC_PI_2;
use transect_geometry::{Isometry3, Vector3};

/// Errors of ranges and poses, and missing returns.
///
/// Random numbers come from ChaCha8 with the seed as key, the view's number as stream and the row
/// as position. Every pixel draws the same number of them, with or without a hit; mixed pixels and
/// poses have their own. A pixel's noise therefore depends only on seed, view number, row and
/// column. The order of the views and the solids of the scene do not change it, and one effect is
/// the same with and without the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation of a normal error of the range **along the ray**, in the model's length
    /// unit, for any meaning of `d3`. This part is the same at every range.
    pub sigma: f64,
    /// Growth of that standard deviation per range, where ranges count from the start of the ray:
    /// `sigma + sigma_growth · range`.
    pub sigma_growth: f64,
    /// Growth of that standard deviation with the square of the range, per length unit. A
    /// disparity error of σ pixels gives σ / (base line · focal length in pixels).
    pub sigma_square: f64,
    /// Distance in the image, in pixels, at which the correlation of two pixels' range errors has
    /// fallen to 1/e; at a distance d it is `exp(-(d / correlation)²)`. 0 for independent errors.
    pub correlation: f64,
    /// Step of the values: `d3` is rounded to a multiple of it, in the unit of `d3`; 0 for none.
    /// The error of rounding has the standard deviation step / √12.
    pub quantum: f64,
    /// Share of the pixels that are missing at random, 0 to 1.
    pub dropout: f64,
    /// Largest angle between ray and surface normal that still returns, in radians; π/2 for all.
    pub max_incidence: f64,
    /// Returned light above which a range is certain, as reflectivity · cos(incidence). Weaker
    /// light gives a range with probability light / `full_return`. 0 if any light gives a range.
    pub full_return: f64,
    /// Share of the pixels at range jumps whose range is one between the two surfaces, 0 to 1,
    /// evenly spread. Pixels are at a jump if only a surface seen at more than 85° could join them.
    pub mixed: f64,
    /// Errors that only depth cameras have.
    pub depth_camera: DepthCamera,
    /// Error of the pose that a view states.
    pub pose: PoseNoise,
    /// Key of the random numbers.
    pub seed: u64,
}

/// Errors of the pose that a view states.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PoseNoise {
    /// Standard deviation of the rotation about each of the sensor's axes, in degrees.
    pub degrees: f64,
    /// Standard deviation of the shift along each of the sensor's axes, in the model's length unit.
    pub shift: f64,
}

impl Noise {
    /// A perfect sensor.
    pub const NONE: Self = Self {
        sigma: 0.0,
        sigma_growth: 0.0,
        sigma_square: 0.0,
        correlation: 0.0,
        quantum: 0.0,
        dropout: 0.0,
        max_incidence: FRAC_PI_2,
        full_return: 0.0,
        mixed: 0.0,
        depth_camera: DepthCamera {
            base_line: 0.0,
            disparity_step: 0.0,
            shuffle: 0.0,
            distortion: 0.0,
        },
        pose: PoseNoise { degrees: 0.0, shift: 0.0 },
        seed: 0,
    };

    /// Standard deviation of a range.
    ///
    /// # Units
    /// The model's length unit.
    pub fn sigma_at(&self, range: f64) -> f64 {
        self.sigma + self.sigma_growth * range + self.sigma_square * range * range
    }

    /// Whether standard deviations describe all of the errors. Those that pixels or views share,
    /// and those of depth cameras, have more to them.
    pub(crate) fn is_white(&self) -> bool {
        self.correlation == 0.0 && self.depth_camera == DepthCamera::default()
    }

    /// The pose that a view states of a sensor's true pose: off by a rotation and a shift in the
    /// sensor's own frame. `view` is the view's number.
    pub fn stated_pose(&self, world_from_sensor: &Isometry3, view: u64) -> Isometry3 {
        let PoseNoise { degrees, shift } = self.pose;
        if degrees == 0.0 && shift == 0.0 {
            // A pose without error stays the same to the last bit.
            return *world_from_sensor;
        }
        let mut source = self.source(view, POSE_POSITION);
        let mut three =
            |sigma: f64| -> Vector3 { Vector3::from_fn(|_, _| sigma * normal(&mut source)) };
        let turn = three(degrees.to_radians());
        world_from_sensor * Isometry3::new(three(shift), turn)
    }

    /// Smallest cosine of incidence that returns; `None` if all do.
    pub(crate) fn least_cosine(&self) -> Option<f64> {
        (self.max_incidence < FRAC_PI_2).then(|| self.max_incidence.cos())
    }

    /// Whether the returned light is needed.
    pub(crate) fn needs_light(&self) -> bool {
        self.full_return > 0.0
    }

    /// Random numbers that turn the rays of one row of a view.
    pub(crate) fn shuffling(&self, view: u64, row: usize) -> ChaCha8Rng {
        self.source(view, ((row as u128) << WORDS_PER_ROW_LOG2) | SHUFFLE_POSITION)
    }

    /// The noise of one row of a view, column by column. Range errors that pixels share are given.
    pub(crate) fn row(&self, view: u64, row: usize, shared: Option<Vec<f64>>) -> RowNoise {
        let noisy = [self.sigma, self.sigma_growth, self.sigma_square] != [0.0; 3];
        let position = (row as u128) << WORDS_PER_ROW_LOG2;
        let returns = noisy || self.dropout != 0.0 || self.needs_light();
        RowNoise {
            returns: returns.then(|| self.source(view, position)),
            shared: shared.unwrap_or_default().into_iter(),
            mixing: (self.mixed != 0.0).then(|| self.source(view, position | MIXING_POSITION)),
        }
    }

    fn source(&self, view: u64, word: u128) -> ChaCha8Rng {
        source(self.seed, view, word)
    }
}

impl Default for Noise {
    fn default() -> Self {
        Self::NONE
    }
}

/// Room for the numbers of one row, in 32-bit words: more than the largest accepted image uses.
const WORDS_PER_ROW_LOG2: u32 = 36;
/// Where the numbers for mixed pixels begin in a row's room.
const MIXING_POSITION: u128 = 1 << (WORDS_PER_ROW_LOG2 - 1);
/// Where the numbers that pixels share, and those that turn rays, begin in a row's room.
const FIELD_POSITION: u128 = MIXING_POSITION >> 1;
const SHUFFLE_POSITION: u128 = MIXING_POSITION | FIELD_POSITION;
/// Beyond the last row: an image has at most 2^30 of them.
const POSE_POSITION: u128 = 1 << 67;
/// Beyond those of the pose, in the stream of view 0.
const LENS_POSITION: u128 = POSE_POSITION | (1 << 66);

/// Random numbers from a place in a stream of a key.
pub(crate) fn source(seed: u64, stream: u64, word: u128) -> ChaCha8Rng {
    let mut source = ChaCha8Rng::seed_from_u64(seed);
    source.set_stream(stream);
    source.set_word_pos(word);
    source
}

/// A number evenly from 0 up to, but not including, 1.
fn uniform(source: &mut ChaCha8Rng) -> f64 {
    StandardUniform.sample(source)
}

/// A number of mean 0 and standard deviation 1.
pub(crate) fn normal(source: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(source)
}

/// A row's random numbers, to be drawn once for every column, in order.
pub(crate) struct RowNoise {
    returns: Option<ChaCha8Rng>,
    /// The range errors in standard deviations, if pixels share them.
    shared: std::vec::IntoIter<f64>,
    mixing: Option<ChaCha8Rng>,
}

/// One pixel's random numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PixelNoise {
    /// Decides whether the pixel returns, 0 to 1.
    chance: f64,
    /// The range error in standard deviations.
    normal: f64,
    /// Decides whether the pixel is mixed, 0 to 1, and the share of the other surface.
    mixing: Option<(f64, f64)>,
}

impl RowNoise {
    /// The next pixel's numbers.
    pub fn next_pixel(&mut self) -> PixelNoise {
        let returns = self.returns.as_mut();
        let (chance, normal) = returns.map_or((1.0, 0.0), |s| (uniform(s), normal(s)));
        let normal = self.shared.next().unwrap_or(normal);
        let mixing = self.mixing.as_mut().map(|s| (uniform(s), uniform(s)));
        PixelNoise { chance, normal, mixing }
    }
}

impl PixelNoise {
    /// Whether a range comes back from a surface that returns some light.
    pub fn returns(&self, noise: &Noise, light: f64) -> bool {
        let lost = if light >= noise.full_return {
            noise.dropout
        } else {
            1.0 - (1.0 - noise.dropout) * light / noise.full_return
        };
        self.chance >= lost
    }

    /// Share of the other surface in a pixel at a range jump; `None` if the pixel is not mixed.
    pub fn mixture(&self, noise: &Noise) -> Option<f64> {
        self.mixing.and_then(|(chance, share)| (chance < noise.mixed).then_some(share))
    }

    /// A range with its error.
    pub fn range(&self, noise: &Noise, range: f64) -> f64 {
        range + noise.sigma_at(range) * self.normal
    }
}

impl Noise {
    /// A value as it is stored.
    pub(crate) fn quantised(&self, d3: f64) -> f64 {
        if self.quantum > 0.0 { (d3 / self.quantum).round() * self.quantum } else { d3 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE: Noise = Noise { sigma: 0.5, dropout: 0.1, seed: 7, ..Noise::NONE };

    fn draw(noise: &Noise, view: u64, row: usize, count: usize) -> Vec<PixelNoise> {
        let mut row = noise.row(view, row, None);
        (0..count).map(|_| row.next_pixel()).collect()
    }

    /// Mean and standard deviation.
    fn spread(values: &[f64]) -> (f64, f64) {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        (mean, (values.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n).sqrt())
    }

    #[test]
    fn mean_spread_and_share_are_those_asked_for() {
        let all: Vec<_> = (0..100).flat_map(|row| draw(&NOISE, 0, row, 1000)).collect();
        let kept = all.iter().filter(|p| p.returns(&NOISE, 1.0));
        let errors: Vec<f64> = kept.map(|p| p.range(&NOISE, 3.0) - 3.0).collect();
        let n = errors.len() as f64;
        let (mean, sigma) = spread(&errors);
        // Four standard errors of 90 000 samples.
        assert!(mean.abs() < 4.0 * 0.5 / n.sqrt(), "{mean}");
        assert!((sigma - 0.5).abs() < 4.0 * 0.5 / (2.0 * n).sqrt(), "{sigma}");
        assert!((1.0 - n / 1e5 - 0.1).abs() < 4.0 * (0.09f64 / 1e5).sqrt());
    }

    #[test]
    fn sigma_grows_with_range() {
        let noise = Noise { sigma: 0.1, sigma_growth: 0.02, seed: 5, ..Noise::NONE };
        for range in [0.0, 1.0, 20.0] {
            let all = draw(&noise, 0, 0, 20_000);
            let errors: Vec<f64> = all.iter().map(|p| p.range(&noise, range) - range).collect();
            let (mean, sigma) = spread(&errors);
            let expected = 0.1 + 0.02 * range;
            assert!(mean.abs() < 4.0 * expected / 20_000f64.sqrt(), "{mean}");
            assert!((sigma / expected - 1.0).abs() < 4.0 / 40_000f64.sqrt(), "{sigma}");
        }
    }

    #[test]
    fn dim_surfaces_return_in_proportion_to_their_light() {
        let noise = Noise { dropout: 0.1, full_return: 0.4, seed: 9, ..Noise::NONE };
        for (light, share) in [(1.0, 0.9), (0.4, 0.9), (0.2, 0.45), (0.04, 0.09), (0.0, 0.0)] {
            let all = draw(&noise, 0, 3, 20_000);
            let kept = all.iter().filter(|p| p.returns(&noise, light)).count() as f64;
            let bound = 4.0 * (share * (1.0 - share) / 20_000f64).sqrt();
            assert!((kept / 20_000.0 - share).abs() <= bound, "{light}: {kept}");
        }
    }

    #[test]
    fn rows_and_views_have_their_own_numbers() {
        assert_eq!(draw(&NOISE, 3, 5, 50), draw(&NOISE, 3, 5, 50));
        assert_ne!(draw(&NOISE, 3, 5, 50), draw(&NOISE, 3, 6, 50));
        assert_ne!(draw(&NOISE, 3, 5, 50), draw(&NOISE, 4, 5, 50));
    }

    #[test]
    fn an_effect_leaves_the_numbers_of_the_others_alone() {
        let all = Noise { mixed: 0.5, quantum: 0.1, full_return: 0.2, ..NOISE };
        let pairs = draw(&NOISE, 1, 2, 500).into_iter().zip(draw(&all, 1, 2, 500));
        for (alone, together) in pairs {
            assert_eq!((alone.chance, alone.normal), (together.chance, together.normal));
        }
        let only = Noise { mixed: 0.5, seed: NOISE.seed, ..Noise::NONE };
        let mixing = |noise| draw(noise, 1, 2, 500).iter().map(|p| p.mixing).collect::<Vec<_>>();
        assert_eq!(mixing(&all), mixing(&only));
    }

    #[test]
    fn a_perfect_sensor_errs_nowhere() {
        let pixel = Noise::NONE.row(1, 1, None).next_pixel();
        assert!(pixel.returns(&Noise::NONE, 0.0));
        assert_eq!(pixel.mixture(&Noise::NONE), None);
        assert_eq!(pixel.range(&Noise::NONE, 3.3), 3.3);
        assert_eq!(Noise::NONE.quantised(3.3), 3.3);
        assert_eq!(Noise::NONE.least_cosine(), None);
        let pose = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.1, 0.2, 0.3));
        assert_eq!(Noise::NONE.stated_pose(&pose, 3), pose);
    }

    #[test]
    fn quantisation_spreads_evenly_over_a_step() {
        let noise = Noise { quantum: 0.25, ..Noise::NONE };
        let values = (0..10_000).map(|k| 1.0 + 0.00137 * f64::from(k));
        let errors: Vec<f64> = values.map(|v| noise.quantised(v) - v).collect();
        let (mean, sigma) = spread(&errors);
        assert!(errors.iter().all(|e| e.abs() <= 0.125 + 1e-12));
        // 54.8 steps are covered: the last one, cut short, is all that unbalances the mean.
        assert!(mean.abs() < 0.125 / 54.0, "{mean}");
        assert!((sigma / (0.25 / 12f64.sqrt()) - 1.0).abs() < 0.01, "{sigma}");
        assert_eq!(noise.quantised(-0.6), -0.5);
    }

    #[test]
    fn poses_err_by_the_spread_asked_for_about_every_axis() {
        let pose = PoseNoise { degrees: 0.2, shift: 0.03 };
        let noise = Noise { pose, seed: 21, ..Noise::NONE };
        let truth = Isometry3::new(Vector3::new(5.0, -2.0, 1.0), Vector3::new(0.4, -1.0, 0.7));
        let views = 4000;
        let mut parts = vec![Vec::new(); 6];
        for view in 0..views {
            let error = truth.inverse() * noise.stated_pose(&truth, view);
            let turn = error.rotation.scaled_axis().map(f64::to_degrees);
            let shift = error.translation.vector;
            for (k, value) in turn.iter().chain(shift.iter()).enumerate() {
                parts[k].push(*value);
            }
        }
        for (k, part) in parts.iter().enumerate() {
            let (mean, sigma) = spread(part);
            let expected = if k < 3 { 0.2 } else { 0.03 };
            let n = views as f64;
            assert!(mean.abs() < 4.0 * expected / n.sqrt(), "axis {k}: {mean}");
            assert!((sigma / expected - 1.0).abs() < 4.0 / (2.0 * n).sqrt(), "axis {k}: {sigma}");
        }
        assert_eq!(noise.stated_pose(&truth, 8), noise.stated_pose(&truth, 8));
    }
}
