//! From intensity images to a range image: where the laser stripe lies in every camera row
//! (dissertation, section 4.6.1).
//!
//! ```text
//!  intensity                                       window of the template, at its best place:
//!     |            . '|' .                         first value taken off, least Σ |difference|
//!     |          .'   |   '.   height h
//!     |_ . - ._.'     |     '. _ . _               brightest local maximum inside: the stripe
//!     |        |<- w ----->|                       whole cell, or sub-cell by zero crossing
//!     +---------------|------------- x_frame
//! ```
//!
//! **Input**: one image per laser angle, camera rows × camera columns, 8 or 16 bits. **Output**:
//! per row the place of the stripe in cells from the array's left edge, which is `d3` of the
//! [`LightStripe`] frame; rows without a stripe are missing.
//!
//! **Steps**, for every row by itself:
//! 1. The window of the template (Eq. 4.20, an isosceles triangle of width `w` and height `h`)
//!    moves from left to right. The window's first value is taken off all its values, and the first
//!    of the template off the template's, so that a constant background drops out.
//! 2. The place with the least sum of absolute differences is the stripe's region. A sum close to
//!    that of an even background means that there is no stripe. A stripe of height `a < h` brings
//!    the sum down by the share `a / h`, and [`StripeFinder::least_height`] is the least such `a`.
//! 3. In that window the brightest local maximum is the stripe. A level top, as of a saturated
//!    stripe, counts as its middle.
//! 4. Optionally ([`Peak::SubCell`]) the place is refined: see there.
//!
//! Then, along the stripe, a median filter over [`StripeFinder::median_rows`] rows. It moves
//! outliers and never fills a row in. Rows take part in pairs, one above and one below, so that a
//! leaning stripe is not pulled along at its ends and at gaps.
//!
//! **Limits**: a stripe more than `2h` high matches worse than no stripe at all, so `h` belongs to
//! the brighter surfaces of the scene. A stripe nearer than half a window to the image's edge is
//! not found. Both come with the method.
//!
//! **Departures**: the template's own first value is taken off as well (it is 0 only for an even
//! width). Local maxima go before a brighter slope at the window's rim, which belongs to something
//! else. The least height and the sub-cell peak are added.
//!
//! Cost: cells × window per image, most of it cut short as soon as a sum exceeds the best one.

mod image;
mod profile;
mod row;
#[cfg(test)]
mod tests;

pub use image::IntensityImage;
pub use profile::{StripeProfile, StripeShape};

use super::LightStripe;
use crate::error::{SensorError, require};
use row::Template;
use serde::{Deserialize, Serialize};
use transect_device::{DeviceFrame, Pixel, RangeImage, median};

/// How exactly the stripe's place in a row is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Peak {
    /// The centre of the brightest cell, as in the dissertation: at best ±0.5 cells.
    WholeCell,
    /// Where the right half of a window outweighs the left half as much as the left the right:
    /// `D(c) = Σ_k I(c+k) - I(c-k)`, k = 1 … w/2, falls through zero; linear between cells.
    ///
    /// This is where a shifted triangle fits best. With `n = w/2` in whole cells:
    /// * a triangle of that width is found exactly; counts rounded to whole numbers move it by at
    ///   most `n / (2 - 1/n) h`, which is 0.02 cells for `w` = 8 and `h` = 120;
    /// * other symmetric shapes are found to about a hundredth of a cell, because `D` is not quite
    ///   straight. A Gaussian is found to 0.02, 0.01 and 0.003 cells for `w` = 5, 8 and 12;
    /// * noise σ of the counts makes a deviation of `σ √(2n) / (2 - 1/n) h` cells, 14 % more than
    ///   the least possible at `w` = 8;
    /// * a constant background drops out, one that rises by `s` per cell moves the place by
    ///   `s n (n + 1) / (2 - 1/n) h` cells towards the light.
    ///
    /// Falls back to the whole cell where `D` has no zero, or its window leaves the image.
    SubCell,
}

/// Settings of the extraction; see the module's page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StripeFinder {
    /// Template: width in cells, height in counts of the images' intensity.
    pub profile: StripeProfile,
    /// Least height over the background, in counts, that still makes a stripe; at most the
    /// profile's height. Twice as much halves the range of reflectivities that are found.
    pub least_height: f64,
    /// Rows of the median filter along the stripe, an odd number; 1 for none.
    pub median_rows: usize,
    /// Whole cells or parts of them.
    pub peak: Peak,
}

impl StripeFinder {
    /// A finder of such stripes, down to a quarter of their height, with a median over 5 rows and
    /// sub-cell peaks.
    pub fn new(profile: StripeProfile) -> Self {
        let least_height = 0.25 * profile.height;
        Self { profile, least_height, median_rows: 5, peak: Peak::SubCell }
    }

    /// Where the stripe lies in every row of one image: `x_frame` in cells from the left edge of
    /// the image, so that the centre of column `c` is `c + 0.5`. `None` for rows without a stripe.
    ///
    /// # Errors
    /// [`SensorError::BadParameter`] for settings that describe no stripe, or one wider than the
    /// image.
    pub fn curve(&self, image: &IntensityImage) -> Result<Vec<Option<f64>>, SensorError> {
        let template = self.template(image.size().cols)?;
        let mut values = Vec::with_capacity(image.size().cols);
        let rows = (0..image.size().rows).map(|row| {
            image.copy_row(row, &mut values);
            template.locate(&values)
        });
        Ok(median_along(&rows.collect::<Vec<_>>(), self.median_rows))
    }

    fn template(&self, cols: usize) -> Result<Template, SensorError> {
        self.profile.check()?;
        let (least, height) = (self.least_height, self.profile.height);
        let wanted = "more than 0 counts and at most the stripe's height";
        require("least_height", least, least > 0.0 && least <= height, wanted)?;
        let rows = self.median_rows as f64;
        require("median_rows", rows, self.median_rows % 2 == 1, "an odd number of rows")?;
        // Checked before memory is taken for it.
        let width = self.profile.width;
        require("stripe_width", width, width <= cols as f64, "a stripe narrower than the image")?;
        let template = Template::new(self.profile, least, self.peak);
        let fits = template.window() <= cols;
        require("stripe_width", width, fits, "a stripe narrower than the image")?;
        Ok(template)
    }
}

/// A median along the stripe; missing rows stay missing and take no part.
fn median_along(places: &[Option<f64>], window: usize) -> Vec<Option<f64>> {
    let at = |row: usize| places.get(row).copied().flatten();
    // No row has more neighbours than there are rows.
    let window = window.min(2 * places.len() + 1);
    let mut around = Vec::new();
    let filtered = places.iter().enumerate().map(|(row, place)| {
        around.clear();
        around.push((*place)?);
        for k in 1..=window / 2 {
            let above = row.checked_sub(k).and_then(at);
            around.extend(above.zip(at(row + k)).into_iter().flat_map(|(a, b)| [a, b]));
        }
        median(around.iter().copied())
    });
    filtered.collect()
}

/// A range image that grows by one column per intensity image, so that a scan need not be in
/// memory at once.
#[derive(Debug)]
pub struct StripeStack<'a> {
    frame: &'a LightStripe,
    finder: StripeFinder,
    /// Row-major; NaN where no stripe has been found yet.
    values: Vec<f32>,
    columns: usize,
}

impl<'a> StripeStack<'a> {
    /// An empty stack for a range finder.
    ///
    /// # Errors
    /// [`SensorError::BadParameter`] for settings that do not fit the range finder's camera.
    pub fn new(frame: &'a LightStripe, finder: StripeFinder) -> Result<Self, SensorError> {
        finder.template(frame.parameters().camera_cols)?;
        let values = vec![f32::NAN; frame.size().pixels()];
        Ok(Self { frame, finder, values, columns: 0 })
    }

    /// Takes the image of the next laser angle.
    ///
    /// # Errors
    /// [`SensorError::BadParameter`] if the image is not of the camera's size, or there are more
    /// images than angles.
    pub fn push(&mut self, image: &IntensityImage) -> Result<(), SensorError> {
        let (size, camera) = (image.size(), self.frame.parameters().camera());
        let (rows, cols) = (size.rows as f64, size.cols as f64);
        let same = (size.rows == camera.rows, size.cols == camera.cols);
        require("image_rows", rows, same.0, "as many rows as the camera")?;
        require("image_cols", cols, same.1, "as many columns as the camera")?;
        let (count, angles) = (self.columns + 1, self.frame.size().cols);
        require("images", count as f64, count <= angles, "one image per laser angle")?;
        for (row, place) in self.finder.curve(image)?.into_iter().enumerate() {
            let pixel = Pixel::new(row, self.columns);
            // A stripe where laser and line of sight do not converge is a reflection.
            let valid = place.filter(|d3| self.frame.point(pixel, *d3).is_some());
            if let Some((d3, value)) = valid.zip(self.values.get_mut(row * angles + pixel.col)) {
                *value = d3 as f32;
            }
        }
        self.columns = count;
        Ok(())
    }

    /// The range image of all angles.
    ///
    /// # Errors
    /// [`SensorError::BadParameter`] if images are missing.
    pub fn finish(self) -> Result<RangeImage, SensorError> {
        let complete = self.columns == self.frame.size().cols;
        require("images", self.columns as f64, complete, "one image per laser angle")?;
        Ok(RangeImage::from_values(self.frame.size(), self.values)?)
    }
}

/// The range image of a whole stack of intensity images, one per laser angle in the angles' order.
///
/// # Errors
/// As [`StripeStack`].
pub fn extract(
    frame: &LightStripe,
    images: &[IntensityImage],
    finder: StripeFinder,
) -> Result<RangeImage, SensorError> {
    let mut stack = StripeStack::new(frame, finder)?;
    images.iter().try_for_each(|image| stack.push(image))?;
    stack.finish()
}
