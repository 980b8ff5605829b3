//! A view as curves are found in it: its noise known and, where that asks for it, smoothed.

use crate::smooth::{Smoothed, Smoothing, smooth_with};
use crate::{BreakRule, NoisyView, RangeNoise};
use transect_device::{Pixel, View, ViewError};

/// A view with its noise known, smoothed if that was asked for. It never changes.
#[derive(Debug, Clone)]
pub struct PreparedView<'a> {
    given: &'a NoisyView<'a>,
    noise: RangeNoise,
    contradicting: Option<f64>,
    smoothed: Option<Smoothed>,
    failure: Option<ViewError>,
}

impl<'a> PreparedView<'a> {
    /// Prepares a view; `rule` makes the rule for range jumps from the noise.
    ///
    /// Without `smoothing` the image stays as it is, and so does an image that cannot be smoothed;
    /// [`PreparedView::failure`] tells why.
    pub fn new(
        given: &'a NoisyView<'a>,
        smoothing: Option<&Smoothing<'_>>,
        rule: impl FnOnce(&RangeNoise) -> BreakRule,
    ) -> Self {
        let shares = smoothing.is_none_or(|smoothing| smoothing.steps.shared_noise);
        let (view, noise) = (given.view(), *given.noise());
        let noise = if shares { noise } else { noise.own() };
        let contradicting = RangeNoise::contradicting(view);
        let mut prepared = Self { given, noise, contradicting, smoothed: None, failure: None };
        if let Some(smoothing) = smoothing {
            match smooth_with(view, &noise, &rule(&noise), smoothing) {
                Ok(smoothed) => prepared.smoothed = Some(smoothed),
                Err(error) => prepared.failure = Some(error),
            }
        }
        prepared
    }

    /// The view in which curves are found.
    pub fn view(&self) -> &View {
        self.smoothed.as_ref().map_or(self.given.view(), |s| &s.view)
    }

    /// The view before smoothing.
    pub fn given(&self) -> &View {
        self.given.view()
    }

    /// Pixels that have a sample in the image that was read.
    pub fn valid_pixels(&self) -> usize {
        self.given.valid_pixels()
    }

    /// Pixels that were filled before smoothing; see [`NoisyView::filled`].
    pub fn filled_pixels(&self) -> usize {
        self.given.filled_pixels()
    }

    /// Distance between neighbouring pixels in the image that was given; see [`NoisyView::step`].
    pub fn step(&self) -> usize {
        self.given.step()
    }

    /// The pixel of the image that was given.
    pub fn in_image(&self, Pixel { row, col }: Pixel) -> Pixel {
        Pixel { row: row * self.step(), col: col * self.step() }
    }

    /// The result of smoothing; `None` if it was not asked for or failed.
    pub fn smoothed(&self) -> Option<&Smoothed> {
        self.smoothed.as_ref()
    }

    /// Why the image could not be smoothed.
    pub fn failure(&self) -> Option<&ViewError> {
        self.failure.as_ref()
    }

    /// The noise of the image where it contradicts the one that the view states; see
    /// [`RangeNoise::contradicting`].
    pub fn contradicting_sigma(&self) -> Option<f64> {
        self.contradicting
    }

    /// Range noise before smoothing.
    pub fn noise(&self) -> &RangeNoise {
        &self.noise
    }

    /// Range noise before smoothing, as a length along the ray.
    ///
    /// Pixels that smoothing leaves alone still have it, so rules for all pixels use it.
    pub fn sigma(&self) -> f64 {
        self.noise.length()
    }

    /// Range noise of a pixel after smoothing, along its ray, as a length.
    pub fn sigma_at(&self, pixel: Pixel) -> f64 {
        self.noise.length_at(self.given(), pixel) * self.factor(pixel)
    }

    /// Standard deviation of the range of a group of neighbouring pixels, along the ray, as a
    /// length: a pixel's own noise after smoothing, and the noise that the group shares.
    pub fn sigma_of_group(&self, pixel: Pixel) -> f64 {
        self.of_group(pixel, self.factor(pixel))
    }

    /// The same before smoothing.
    pub fn given_sigma_of_group(&self, pixel: Pixel) -> f64 {
        self.of_group(pixel, 1.0)
    }

    fn of_group(&self, pixel: Pixel, factor: f64) -> f64 {
        self.noise.length_at(self.given(), pixel) * factor.hypot(self.noise.shared())
    }

    /// How many pixels across share their noise with a pixel; 0 if each has its own.
    ///
    /// A mean of n samples has 1/√n of their noise, and n samples fill a square √n wide.
    pub fn shared_pixels(&self, pixel: Pixel) -> f64 {
        let factor = self.factor(pixel);
        if factor < 1.0 { 1.0 / factor } else { 0.0 }
    }

    /// Correlation of the noise of a pixel with that of its neighbours, from 0 to 1.
    ///
    /// Where every second row of a window is left out, two neighbours in a column have no sample
    /// in common. The noise that neighbours share, most of the noise there, correlates them.
    ///
    /// A smooth weighting with a standard deviation of w pixels leaves a share f = 1 / (2 w √π) of
    /// the noise. Results a pixel apart have the correlation exp(−1 / (4 w²)) = exp(−π f²).
    pub fn correlation_of_neighbours(&self, pixel: Pixel) -> f64 {
        let factor = self.factor(pixel);
        if factor < 1.0 { (-std::f64::consts::PI * factor * factor).exp() } else { 0.0 }
    }

    fn factor(&self, pixel: Pixel) -> f64 {
        self.smoothed.as_ref().map_or(1.0, |s| s.factor(pixel))
    }
}
