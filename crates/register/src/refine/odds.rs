//! The odds that a number is wrong rather than right: the probability of zero before anything is
//! seen over that after it (Dickey, 1971).

use crate::tuning::{CAMERA_ODDS, SCALE_ODDS};

/// The odds that parts of a camera are wrong; those of parts that are not free mean nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Odds {
    pub level: f64,
    pub scale: f64,
    /// The larger one of `fx` and `fy`.
    pub focal: f64,
}

impl Odds {
    /// Whether the level of the offsets is wrong by these odds.
    pub fn level_is_wrong(&self) -> bool {
        self.level > CAMERA_ODDS
    }

    /// Whether the scale is wrong by these odds.
    pub fn scale_is_wrong(&self) -> bool {
        self.scale > SCALE_ODDS
    }

    /// Whether a focal length is.
    pub fn focal_is_wrong(&self) -> bool {
        self.focal > CAMERA_ODDS
    }
}

/// The odds of a free number against zero, from its estimate, the variance of that, and the
/// precision before the images are seen. The standard deviation that the images alone give is taken
/// `sigmas` times as large.
pub fn odds(estimate: f64, variance: f64, precision: f64, sigmas: f64) -> f64 {
    let by_images = (1.0 - precision * variance).max(f64::EPSILON);
    let (seen, before) = (estimate / by_images, precision.recip());
    let variance = sigmas.powi(2) * variance / by_images;
    let wrong = variance + before;
    (variance / wrong).sqrt() * (0.5 * seen * seen * (variance.recip() - wrong.recip())).exp()
}
