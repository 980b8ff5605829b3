//! A view with its noise, at the resolution that the noise leaves.
//!
//! **Problem.** A depth camera matches windows, and counts disparities in steps. Neighbouring
//! pixels then share most of their noise, and move in groups of several pixels. An additional pixel
//! adds no information and costs time. Where a group moves by a step, two neighbours look like the
//! two sides of a range jump, and surfaces break there.
//!
//! **Idea.** Every other row and column holds nearly all that the image tells about its surfaces.
//! Samples twice as far apart differ by as much from noise, and by twice as much from the surface.
//! So fewer pairs seem to be range jumps.
//!
//! **Steps.** The noise is measured. Where neighbours share most of it and the sensor's frame can
//! be [halved](transect_device::DeviceFrame::halved), the view is halved once and its noise is
//! measured again. It stays whole where the neighbours of the half share less.
//!
//! **Worth.** `cargo xtask experiments ablation` has the row `smoothing: half_resolution`. Measured
//! on ten simulated scans by depth cameras: the time of a run halves. Medians change by −15 to 5 %
//! and 95 % distances by −16 to 4 %, with fewer false pieces. Up to 5 % more of the truth is found
//! within 0.2 % of the size. Halved again, a kitchen loses 1 % of it.

use crate::half::filled;
use crate::{BreakRule, RangeNoise};
use std::borrow::Cow;
use transect_device::View;

/// A view with its noise. It never changes.
#[derive(Debug, Clone)]
pub struct NoisyView<'a> {
    view: Cow<'a, View>,
    noise: RangeNoise,
    step: usize,
}

impl<'a> NoisyView<'a> {
    /// All pixels of a view.
    pub fn whole(view: &'a View) -> Self {
        Self { noise: RangeNoise::of(view), view: Cow::Borrowed(view), step: 1 }
    }

    /// The view at the resolution that its noise leaves: every other row and column where
    /// neighbours share most of their noise, else all of them.
    ///
    /// `rule` makes the rule for range jumps from the noise. Missing pixels of a half are filled
    /// from neighbours that belong to one surface by it; see `half.rs`.
    pub fn resolved(view: &'a View, rule: impl FnOnce(&RangeNoise) -> BreakRule) -> Self {
        let shared = RangeNoise::of_fewer_rows(view).is_mostly_shared();
        let halved = shared.then(|| Self::halved(view, rule)).flatten();
        halved.unwrap_or_else(|| Self::whole(view))
    }

    /// Every other row and column, where these, too, share most of their noise.
    fn halved(view: &View, rule: impl FnOnce(&RangeNoise) -> BreakRule) -> Option<Self> {
        let half = view.halved()?;
        let noise = RangeNoise::of(&half);
        let view = noise.is_mostly_shared().then(|| filled(half, view, &rule(&noise)))?;
        Some(Self { view: Cow::Owned(view), noise, step: 2 })
    }

    /// The view.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// Its noise.
    pub fn noise(&self) -> &RangeNoise {
        &self.noise
    }

    /// Distance between its neighbouring pixels in the image that was given, in pixels: 1 or 2.
    pub fn step(&self) -> usize {
        self.step
    }
}
