//! Intensity images of a light-stripe sensor's camera, one image per laser angle (dissertation,
//! section 4.6; Figure 4.13 shows a row of one).
//!
//! A range image of such a sensor has rows of the camera and columns of laser angles, and its value
//! is the stripe's place in the camera's row. This module casts the same rays, but keeps the light
//! instead of the value:
//!
//! 1. Per (row, laser angle): the spot, if laser and camera both reach it, its camera column, and
//!    how much light it returns, that is reflectivity · cos(incidence of the laser).
//! 2. A row of an image is the background. Around the spot's column the stripe's profile is added
//!    to it, pixel by pixel times its speckle. The profile is a bell curve as high as the spot is
//!    bright.
//! 3. Read noise is added; the sum is rounded and cut off at the largest count.
//!
//! Left out: the stripe's broadening on surfaces that recede from the camera, light that is
//! scattered from one surface to another, and the exposure's own noise, which read noise
//! replaces. Profiles are sampled at the pixels' centres, which a width of two pixels and more
//! allows.

use crate::cast::{Caster, Echo};
use crate::noise::{normal, source};
use crate::{Noise, Scene};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Gamma};
use transect_device::{DeviceFrame, ImageError, ImageSize, Isometry3, Pixel};

/// Counts that a camera's pixels can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BitDepth {
    /// From 0 to 255.
    Eight,
    /// From 0 to 65 535.
    Sixteen,
}

/// A camera that sees a laser stripe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StripeCamera {
    /// Columns of its images; their rows are those of the device frame.
    pub columns: usize,
    /// Range of the counts.
    pub depth: BitDepth,
    /// Full width of the stripe's profile at half its height, in pixels.
    pub width: f64,
    /// Height of the profile, in counts, on a white surface that the laser meets head-on.
    pub peak: f64,
    /// Level of the light without the laser, in counts.
    pub background: f64,
    /// Contrast of the speckle: standard deviation over mean of the stripe's light in a pixel, 0 to
    /// 1. 1 is that of a laser on a rough surface and a pixel no larger than a grain.
    pub speckle: f64,
    /// Standard deviation of a normal error of every pixel, in counts.
    pub read_noise: f64,
    /// Key of the random numbers.
    pub seed: u64,
}

/// Why stripe images cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StripeError {
    /// Images of an impossible size, or too many of them.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A setting of the camera is impossible.
    #[error("{key} = {value}: {wanted} is wanted")]
    BadSetting {
        /// The field of [`StripeCamera`].
        key: &'static str,
        /// Its value.
        value: f64,
        /// The condition it fails.
        wanted: &'static str,
    },
}

/// Pixels of a stack of images, image after image, each row by row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Counts {
    /// Of a camera of 8 bits.
    Eight(Vec<u8>),
    /// Of a camera of up to 16 bits.
    Sixteen(Vec<u16>),
}

/// The images of all laser angles, and the true places of the stripe in them.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct StripeImages {
    /// Rows and columns of every image.
    pub size: ImageSize,
    /// Number of images: one per laser angle.
    pub steps: usize,
    /// Their pixels. Pixel (step, row, column) is at `(step · rows + row) · columns + column`.
    pub counts: Counts,
    /// Row by row, step by step; NaN inside where there is no stripe.
    truth: Vec<f64>,
}

impl StripeImages {
    /// The pixels of one image, row by row; `None` outside the stack.
    pub fn image(&self, step: usize) -> Option<Counts> {
        let pixels = self.size.pixels();
        let range = step.checked_mul(pixels)?..step.checked_add(1)?.checked_mul(pixels)?;
        Some(match &self.counts {
            Counts::Eight(all) => Counts::Eight(all.get(range)?.to_vec()),
            Counts::Sixteen(all) => Counts::Sixteen(all.get(range)?.to_vec()),
        })
    }

    /// The column, whole numbers being pixel centres, in which a row of an image has its stripe.
    /// `None` where the laser or the camera does not reach any surface, and outside the stack.
    pub fn true_column(&self, row: usize, step: usize) -> Option<f64> {
        let inside = row < self.size.rows && step < self.steps;
        let column = *self.truth.get(row * self.steps + step).filter(|_| inside)?;
        (!column.is_nan()).then_some(column)
    }
}

impl StripeCamera {
    fn check(&self) -> Result<(), StripeError> {
        let settings = [
            ("width", self.width, self.width > 0.0, "a positive number of pixels"),
            ("peak", self.peak, self.peak >= 0.0, "a number of counts of at least 0"),
            ("background", self.background, self.background >= 0.0, "a level of at least 0"),
            ("speckle", self.speckle, (0.0..=1.0).contains(&self.speckle), "a share from 0 to 1"),
            ("read_noise", self.read_noise, self.read_noise >= 0.0, "a spread of at least 0"),
        ];
        let wrong = settings.into_iter().find(|&(_, v, right, _)| !(v.is_finite() && right));
        match wrong {
            Some((key, value, _, wanted)) => Err(StripeError::BadSetting { key, value, wanted }),
            None => Ok(()),
        }
    }
}

impl Scene {
    /// The images in which a light-stripe sensor finds its stripe: `frame` has the camera's rows as
    /// rows and the laser's angles as columns.
    ///
    /// `column` gives the camera's column of a value `d3` at a pixel; whole numbers are pixel
    /// centres, and `None` means outside. `view` is the view's number: with the camera's seed it
    /// decides every random number.
    ///
    /// # Errors
    /// [`StripeError`] if a setting is impossible, or the images have more than
    /// [`transect_device::MAX_PIXELS`] pixels in all.
    pub fn stripe_images(
        &self,
        frame: &dyn DeviceFrame,
        world_from_sensor: &Isometry3,
        camera: &StripeCamera,
        column: &dyn Fn(Pixel, f64) -> Option<f64>,
        view: u64,
    ) -> Result<StripeImages, StripeError> {
        camera.check()?;
        frame.size().check()?;
        let ImageSize { rows, cols: steps } = frame.size();
        let size = ImageSize { rows, cols: camera.columns };
        let pixels = rows.checked_mul(steps).and_then(|n| n.checked_mul(camera.columns));
        if pixels.is_none_or(|n| n > transect_device::MAX_PIXELS) {
            return Err(ImageError::AbsurdSize { rows, cols: camera.columns }.into());
        }
        let caster = Caster::new(self, frame, world_from_sensor, (&Noise::NONE, view)).with_light();
        let mut spots = Vec::with_capacity(rows * steps);
        for row in 0..rows {
            let echoes = caster.row(row).into_iter().enumerate();
            spots.extend(echoes.map(|(step, echo)| {
                spot(&caster, Pixel::new(row, step), &echo?, column, camera.columns)
            }));
        }
        let stack = Stack { camera, size, steps, spots: &spots, view };
        let counts = match camera.depth {
            BitDepth::Eight => Counts::Eight(stack.render(|v| v as u8)),
            BitDepth::Sixteen => Counts::Sixteen(stack.render(|v| v as u16)),
        };
        let truth = spots.iter().map(|s| s.map_or(f64::NAN, |s| s.column)).collect();
        Ok(StripeImages { size, steps, counts, truth })
    }
}

/// The middle of a stripe in a row of an image.
#[derive(Debug, Clone, Copy)]
struct Spot {
    column: f64,
    /// Light relative to a white surface that the laser meets head-on.
    light: f64,
}

/// The stripe of an echo, if it is within the camera's columns.
fn spot(
    caster: &Caster,
    pixel: Pixel,
    echo: &Echo,
    column: &dyn Fn(Pixel, f64) -> Option<f64>,
    columns: usize,
) -> Option<Spot> {
    let d3 = caster.value(pixel, &echo.ray, echo.distance)?;
    let column = column(pixel, d3)?;
    let inside = column >= -0.5 && column < columns as f64 - 0.5;
    inside.then_some(Spot { column, light: echo.light })
}

/// Distance from the middle up to which a profile is drawn, in full widths at half height. Theory:
/// at 2 it has fallen to 2⁻¹⁶ of its height, less than a count. Doubling it changes no count.
const DRAWN_WIDTHS: f64 = 2.0;

/// Separates the random numbers of images from those of ranges with the same seed and view.
const IMAGE_STREAMS: u64 = 1 << 63;

/// Room for the random numbers of one row of one image, in 32-bit words.
const WORDS_PER_ROW_LOG2: u32 = 36;

/// Data that all rows of all images share.
struct Stack<'a> {
    camera: &'a StripeCamera,
    size: ImageSize,
    steps: usize,
    /// Row by row, step by step.
    spots: &'a [Option<Spot>],
    view: u64,
}

impl Stack<'_> {
    /// All images; `count` converts a number within the range of the counts.
    fn render<T>(&self, count: impl Fn(f64) -> T) -> Vec<T> {
        let ImageSize { rows, cols } = self.size;
        let most = match self.camera.depth {
            BitDepth::Eight => f64::from(u8::MAX),
            BitDepth::Sixteen => f64::from(u16::MAX),
        };
        let mut out = Vec::with_capacity(rows * cols * self.steps);
        let mut light = vec![0.0; cols];
        for step in 0..self.steps {
            for row in 0..rows {
                self.row(row, step, &mut light);
                out.extend(light.iter().map(|v| count(v.round().clamp(0.0, most))));
            }
        }
        out
    }

    /// The light in a row of an image, in counts.
    fn row(&self, row: usize, step: usize, light: &mut [f64]) {
        let StripeCamera { background, read_noise, seed, .. } = *self.camera;
        let word = ((step * self.size.rows + row) as u128) << WORDS_PER_ROW_LOG2;
        let mut random = source(seed, self.view | IMAGE_STREAMS, word);
        light.fill(background);
        if read_noise > 0.0 {
            // Before the stripe, so that it is the same wherever the stripe is.
            light.iter_mut().for_each(|v| *v += read_noise * normal(&mut random));
        }
        if let Some(spot) = self.spots.get(row * self.steps + step).copied().flatten() {
            self.draw(&spot, light, &mut random);
        }
    }

    /// Adds a stripe to a row.
    fn draw(&self, spot: &Spot, light: &mut [f64], random: &mut ChaCha8Rng) {
        let StripeCamera { width, peak, speckle, .. } = *self.camera;
        let reach = DRAWN_WIDTHS * width;
        let first = (spot.column - reach).ceil().max(0.0);
        let count = ((spot.column + reach).floor() - first + 1.0).max(0.0) as usize;
        // Sums of exponentials: mean 1, standard deviation `speckle`.
        let grains = Gamma::new(1.0 / (speckle * speckle), speckle * speckle).ok();
        let grains = grains.filter(|_| speckle > 0.0);
        for (k, value) in light.iter_mut().skip(first as usize).take(count).enumerate() {
            let off = (first + k as f64 - spot.column) / width;
            let profile = (-4.0 * off * off).exp2();
            let grain = grains.map_or(1.0, |g| g.sample(random));
            *value += peak * spot.light * profile * grain;
        }
    }
}

#[cfg(test)]
mod tests;
