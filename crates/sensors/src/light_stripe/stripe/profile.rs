//! The profile of a stripe across its direction, for drawing stripes and for finding them.

use crate::error::{SensorError, require};
use serde::{Deserialize, Serialize};

/// Standard deviations in the full width at half height of a Gaussian: 2 √(2 ln 2).
const SIGMAS_PER_HALF_HEIGHT_WIDTH: f64 = 2.354_820_045_030_949_3;

/// The shape of a stripe across.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StripeShape {
    /// An isosceles triangle (Eq. 4.20).
    Triangle,
    /// A Gaussian with the triangle's width at half height: the profile of a real laser beam.
    Gaussian,
}

/// A stripe's cross section, over the background.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StripeProfile {
    /// Triangle or Gaussian.
    pub shape: StripeShape,
    /// `w`: the triangle's base, in cells; twice the width at half height for every shape.
    pub width: f64,
    /// `h`: height of the middle over the background, in counts.
    pub height: f64,
}

impl StripeProfile {
    /// The dissertation's triangle (Eq. 4.20): base in cells, height in counts.
    pub fn triangle(width: f64, height: f64) -> Self {
        Self { shape: StripeShape::Triangle, width, height }
    }

    /// A Gaussian with the half-height width of that triangle.
    pub fn gaussian(width: f64, height: f64) -> Self {
        Self { shape: StripeShape::Gaussian, width, height }
    }

    /// Intensity over the background, in counts, this many cells from the stripe's middle.
    pub fn at(&self, cells: f64) -> f64 {
        match self.shape {
            StripeShape::Triangle => self.height * (1.0 - 2.0 * cells.abs() / self.width).max(0.0),
            StripeShape::Gaussian => {
                let sigma = 0.5 * self.width / SIGMAS_PER_HALF_HEIGHT_WIDTH;
                self.height * (-0.5 * (cells / sigma).powi(2)).exp()
            }
        }
    }

    pub(super) fn check(&self) -> Result<(), SensorError> {
        require("stripe_width", self.width, self.width >= 2.0, "at least 2 cells")?;
        require("stripe_height", self.height, self.height > 0.0, "a positive number of counts")?;
        Ok(())
    }
}
