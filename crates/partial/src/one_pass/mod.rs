//! Contours of a whole plane family from one sweep over a range image.
//!
//! **Problem.** Every plane of the family cuts the surface that the image samples; all those curves
//! are wanted, linked, in order, with the solid on their left.
//!
//! **Idea.** The dissertation makes a plane range image and a label image per plane (chapter 3).
//! Measured in intervals, the height of each pixel's surface point over plane 0 is one scalar
//! image, the *level*, and the label of plane k is "level > k". The curves of *all* planes are the
//! level lines of that one image, so one pass over the pixels finds them, and the cost no longer
//! grows with planes × pixels.
//!
//! **Steps**, after the image has been smoothed if it is noisy ([`mod@crate::smooth`]).
//! 1. Per row: levels (the device frame's fast path), `L = ceil(level)`: plane k lies between two
//!    pixels exactly if k is in `[min L, max L)`; a pixel on the plane counts as low (3.4).
//! 2. Pairs with a missing pixel or a range jump are broken **before** anything is emitted: few
//!    pairs are jumps, but they hold a large share of all level differences (3.4.2).
//! 3. Each unbroken pair emits its crossings with consecutive numbers, solved for the point where
//!    the line between the two samples meets the plane (3.6, Cartesian curve–plane, linear).
//! 4. Each cell of four pixels links its entering crossings to its leaving ones, seen with the high
//!    side on the left; see `cell.rs`. This replaces the search windows of 3.5.
//! 5. Chains are followed from their heads, then closed loops; see `trace.rs`.
//! 6. Handedness turns "high on the left" into "solid on the left" (3.7): seen from the sensor, the
//!    curve direction `n × N` (plane normal, outward surface normal) has the high side on its left
//!    whatever side of the plane the sensor is on, so a mirrored grid reverses all curves and a
//!    plain one none. No range comparison per curve is needed.
//!
//! **Departures from the source.** No gap bridging and no thinning: curves of a scalar image are one
//! crossing wide and end only where the surface does. A curve is never closed over missing data.
//!
//! **Cost.** One visit per pixel, one per crossing; memory for a few rows and the crossings. Not for
//! curved guides, whose levels are not an affine function of the point.

mod cell;
mod crossing;
mod nodes;
mod sweep;
mod trace;

use crate::{BreakRule, PartialError, PartialModel, RangeNoise, SectionAxes, smooth};
use transect_device::{Pixel, View};
use transect_geometry::PlaneFamily;

/// What can be set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnePassOptions {
    /// Largest angle between a ray and the surface normal at which two pixels still count as one
    /// surface, in radians. Larger keeps more of the rims, where real scanners overshoot.
    pub max_incidence_rad: f64,
    /// How many standard deviations of the range a pair may differ by from noise alone.
    pub jump_sigmas: f64,
    /// Whether noisy images are smoothed before their contours are found; see [`mod@crate::smooth`].
    pub smooth: bool,
}

impl Default for OnePassOptions {
    fn default() -> Self {
        Self { max_incidence_rad: 78_f64.to_radians(), jump_sigmas: 4.0, smooth: true }
    }
}

/// The partial model of a view.
///
/// # Errors
/// [`PartialError`] if the planes are too dense for the view.
pub fn partial_model(
    view: &View,
    planes: &PlaneFamily,
    options: &OnePassOptions,
) -> Result<PartialModel, PartialError> {
    let noise = RangeNoise::of(view);
    // Also after smoothing: pixels that it left alone are as noisy as before.
    let slack = options.jump_sigmas * noise.length();
    let rule = BreakRule::new(options.max_incidence_rad, slack);
    // An image that could not be smoothed is used as it is.
    let smoothed = options.smooth.then(|| smooth::smooth(view, &noise, &rule).ok()).flatten();
    let sigmas = NodeSigmas { view, noise, smoothed: smoothed.as_ref() };
    let view = smoothed.as_ref().map_or(view, |s| &s.view);
    let axes = SectionAxes::new(view, planes)?;
    let linked = sweep::sweep(view, &axes, &rule)?;
    let chains = trace::trace(&linked, view.frame().handedness());
    let mut model = nodes::model(view, &axes, &linked, &chains, &sigmas);
    model.counts.crossings = linked.crossings.len();
    model.counts.jumps = linked.jumps;
    model.counts.sigma = noise.length();
    if let Some(smoothed) = &smoothed {
        model.counts.smoothed = smoothed.changed;
        model.counts.window = smoothed.window;
    }
    model.counts.sigma_after = sigmas.after();
    Ok(model)
}

/// What a node's range noise is.
struct NodeSigmas<'a> {
    view: &'a View,
    noise: RangeNoise,
    smoothed: Option<&'a smooth::Smoothed>,
}

impl NodeSigmas<'_> {
    /// Standard deviation along the ray at a pixel, in the model's length unit.
    fn at(&self, pixel: Pixel) -> f64 {
        let factor = self.smoothed.map_or(1.0, |s| s.factor(pixel));
        self.noise.length_at(self.view, pixel) * factor
    }

    /// At the median pixel.
    fn after(&self) -> f64 {
        self.noise.length() * self.smoothed.map_or(1.0, |s| s.median_factor)
    }
}
