//! What is done to a view before its curves are found, whatever finds them.

use crate::smooth::{Extent, Smoothed, smooth_with};
use crate::{BreakRule, PartialCounts, RangeNoise};
use transect_device::{Pixel, View};

/// A view with its noise known and, where that asks for it, smoothed.
pub(crate) struct Prepared<'a> {
    given: &'a View,
    noise: RangeNoise,
    smoothed: Option<Smoothed>,
    /// The view in other coordinates, if curves are to be found in those.
    turned: Option<View>,
}

impl<'a> Prepared<'a> {
    /// Prepares a view; `rule` makes the rule for range jumps from the noise, as a length.
    ///
    /// What is smoothed of it is stated by `smoothing`, if anything. Section axes for that are those of
    /// the given view; smoothing moves its nearest and farthest point, so the smoothed view's own may
    /// count levels from another plane.
    pub fn new(
        view: &'a View,
        smoothing: Option<&Extent<'_>>,
        rule: impl FnOnce(f64) -> BreakRule,
    ) -> Self {
        let noise = RangeNoise::of(view);
        // An image that cannot be smoothed is used as it is.
        let smoothed = smoothing
            .and_then(|extent| smooth_with(view, &noise, &rule(noise.length()), extent).ok());
        Self { given: view, noise, smoothed, turned: None }
    }

    /// The view in which curves are found.
    pub fn view(&self) -> &View {
        let prepared = self.smoothed.as_ref().map_or(self.given, |s| &s.view);
        self.turned.as_ref().unwrap_or(prepared)
    }

    /// Puts the prepared view in other coordinates: the same samples, some of which may be missing now.
    pub fn turn(&mut self, view: View) {
        self.turned = Some(view);
    }

    /// Range noise before smoothing, as a length. Pixels that smoothing leaves alone still have it,
    /// so rules that must hold everywhere go by it.
    pub fn sigma(&self) -> f64 {
        self.noise.length()
    }

    /// Range noise of a pixel as it now is, along its ray, as a length.
    pub fn sigma_at(&self, pixel: Pixel) -> f64 {
        self.noise.length_at(self.given, pixel) * self.factor(pixel)
    }

    /// How many pixels across share their noise with a pixel; 0 if each has its own.
    ///
    /// A mean of n samples has 1/√n of their noise, and n samples fill a square √n wide.
    pub fn shared_pixels(&self, pixel: Pixel) -> f64 {
        let factor = self.factor(pixel);
        if factor < 1.0 { 1.0 / factor } else { 0.0 }
    }

    /// How much the noise of neighbouring pixels is one and the same, from 0 to 1, at a pixel.
    ///
    /// A smooth weighting with a standard deviation of w pixels leaves a share f = 1 / (2 w √π) of
    /// the noise, and results a pixel apart have the correlation exp(−1 / (4 w²)) = exp(−π f²).
    pub fn correlation_of_neighbours(&self, pixel: Pixel) -> f64 {
        let factor = self.factor(pixel);
        if factor < 1.0 { (-std::f64::consts::PI * factor * factor).exp() } else { 0.0 }
    }

    /// Puts on record what was done.
    pub fn count(&self, counts: &mut PartialCounts) {
        counts.sigma = self.noise.length();
        counts.sigma_after =
            self.noise.length() * self.smoothed.as_ref().map_or(1.0, |s| s.median_factor);
        if let Some(smoothed) = &self.smoothed {
            counts.smoothed = smoothed.changed;
            counts.window = smoothed.window;
        }
    }

    fn factor(&self, pixel: Pixel) -> f64 {
        self.smoothed.as_ref().map_or(1.0, |s| s.factor(pixel))
    }
}
