//! `stripe` inside a `light_stripe`: how to find the stripe in a stack of intensity images.
//!
//! | key in `stripe` | meaning |
//! |---|---|
//! | `shape` | `triangle` (the default) or `gaussian` |
//! | `width` | base of the triangle, in cells, twice the width at half height; default 8 |
//! | `height` | height over the background, in counts; default half the largest count of the stack, with a note |
//! | `least_height` | least height of a stripe, in counts; default a quarter of `height` |
//! | `median_rows` | rows of the median filter along the stripe, odd; default 5, none: 1 |
//! | `peak` | `sub_cell` (the default) or `whole_cell` |
//!
//! Stripes of a quarter to twice `height` are found, so half the largest count serves all surfaces
//! but the darkest, unless a reflection is brighter than the stripe.

use crate::ReadError;
use crate::image_stack::ImageStack;
use serde::{Deserialize, Serialize};
use transect_device::ImageSize;
use transect_sensors::SensorError;
use transect_sensors::light_stripe::stripe::{Peak, StripeFinder, StripeProfile, StripeShape};

/// How to find the stripe in intensity images.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct StripeEntry {
    /// Shape of the template.
    pub shape: StripeShape,
    /// Base of the triangle, in cells; twice the width at half height for every shape.
    pub width: f64,
    /// Height over the background, in counts; `None` for half the largest count of the stack.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// Least height of a stripe, in counts; `None` for the finder's default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_height: Option<f64>,
    /// Rows of the median filter along the stripe, odd; 1 for none.
    pub median_rows: usize,
    /// Accuracy of the place: whole cells or parts of them.
    pub peak: Peak,
}

/// Default width of a stripe, in cells. Chosen by hand: wide enough for sub-cell peaks under noise.
/// Stripes of 5 to 12 cells are still found to a hundredth of a cell. Doubled, narrow stripes are
/// lost in the background.
const USUAL_WIDTH: f64 = 8.0;

impl Default for StripeEntry {
    /// A triangle 8 cells wide, with a measured height and the defaults of [`StripeFinder::new`].
    fn default() -> Self {
        let usual = StripeFinder::new(StripeProfile::triangle(USUAL_WIDTH, 1.0));
        Self { height: None, least_height: None, ..usual.into() }
    }
}

impl From<StripeFinder> for StripeEntry {
    /// All settings stated.
    fn from(finder: StripeFinder) -> Self {
        let StripeFinder { profile, least_height, median_rows, peak } = finder;
        let StripeProfile { shape, width, height } = profile;
        let (height, least_height) = (Some(height), Some(least_height));
        Self { shape, width, height, least_height, median_rows, peak }
    }
}

impl StripeEntry {
    /// The finder for a height.
    pub(super) fn finder(&self, height: f64) -> StripeFinder {
        let profile = StripeProfile { shape: self.shape, width: self.width, height };
        let usual = StripeFinder::new(profile);
        StripeFinder {
            least_height: self.least_height.unwrap_or(usual.least_height),
            median_rows: self.median_rows,
            peak: self.peak,
            ..usual
        }
    }

    /// The same settings within the camera's size, because the finder takes memory for them.
    pub(super) fn bounded(self, camera: ImageSize) -> Result<Self, SensorError> {
        let (key, value) = ("stripe_width", self.width);
        if value > camera.cols as f64 {
            let wanted = "a stripe narrower than the image";
            return Err(SensorError::BadParameter { key, value, wanted });
        }
        // The median takes rows in pairs, one above and one below. A larger window finds no more
        // rows. Even numbers stay even, so that the finder refuses them.
        let most = camera.rows.saturating_mul(2) | 1;
        let median_rows = self.median_rows.min(most - 1 + self.median_rows % 2);
        Ok(Self { median_rows, ..self })
    }

    /// The finder. If the height is not stated, it is measured in a first pass through the stack.
    pub(super) fn measured(
        &self,
        stack: &ImageStack,
        notes: &mut Vec<String>,
    ) -> Result<StripeFinder, ReadError> {
        if let Some(height) = self.height {
            return Ok(self.finder(height));
        }
        let mut largest = 0.0;
        let mut counts = Vec::new();
        stack.for_each(|_, image| {
            for row in 0..image.size().rows {
                image.copy_row(row, &mut counts);
                largest = counts.iter().copied().fold(largest, f64::max);
            }
            Ok(())
        })?;
        // A stack without any light has no stripe, whatever the height.
        let height = 0.5 * f64::max(largest, 1.0);
        notes.push(format!(
            "\"stripe.height\" taken as {height} counts, half the largest count of the stack"
        ));
        Ok(self.finder(height))
    }
}
