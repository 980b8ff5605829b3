//! Light-stripe range finders: from images of `x_frame`, or from stacks of intensity images in
//! which the stripe is found on loading, one image in memory at a time.

use super::Loaded;
use super::shared::Shared;
use crate::image_stack::ImageStack;
use crate::manifest::{AnglesEntry, LightStripeEntry, StripeEntry};
use crate::{Place, ReadError, ScanView};
use std::sync::Arc;
use transect_device::{ImageSize, RangeImage};
use transect_sensors::light_stripe::stripe::{StripeFinder, StripeStack};
use transect_sensors::{LightStripe, SensorError};

#[derive(Debug)]
pub(crate) struct LightStripeSource {
    entry: LightStripeEntry,
    frames: Shared<LightStripe>,
}

impl LightStripeSource {
    pub(super) fn new(entry: &LightStripeEntry) -> Self {
        Self { entry: entry.clone(), frames: Shared::new() }
    }

    pub(super) fn load(
        &self,
        view: &ScanView,
        notes: &mut Vec<String>,
    ) -> Result<Loaded, ReadError> {
        let camera = ImageSize { rows: self.entry.camera_rows, cols: self.entry.camera_cols };
        match ImageStack::open(view.path(), camera, notes)? {
            Some(stack) => self.load_stack(view, &stack, notes),
            None => self.load_places(view, notes),
        }
    }

    /// Finds the stripe in a stack of the camera's images.
    fn load_stack(
        &self,
        view: &ScanView,
        stack: &ImageStack,
        notes: &mut Vec<String>,
    ) -> Result<Loaded, ReadError> {
        let (rows, steps) = (self.entry.camera_rows, stack.steps());
        self.check_columns(view, "the stack", "images", steps)?;
        view.check_stated("rows", view.stated_rows, rows, "camera rows")?;
        view.check_stated("cols", view.stated_cols, steps, "images")?;
        let frame = self.frame(view, steps)?;
        let image = self.extract(view, stack, &frame, notes)?;
        Ok((frame, image))
    }

    /// Reads an image in which the stripe's places already stand.
    fn load_places(&self, view: &ScanView, notes: &mut Vec<String>) -> Result<Loaded, ReadError> {
        let image = view.load_image(notes)?;
        let (ImageSize { rows, cols }, wanted) = (image.size(), self.entry.camera_rows);
        self.check_columns(view, "the image", "columns", cols)?;
        if rows != wanted {
            let problem = format!("the image has {rows} rows, but \"camera_rows\" is {wanted}");
            return Err(ReadError::damaged(view.path(), Place::Whole, problem));
        }
        if self.entry.stripe.is_some() {
            notes.push("\"stripe\" is not used: the image is no stack".to_owned());
        }
        Ok((self.frame(view, cols)?, image))
    }

    /// Refuses a number of columns that is not the number of angles, where these are listed.
    fn check_columns(
        &self,
        view: &ScanView,
        what: &str,
        parts: &str,
        found: usize,
    ) -> Result<(), ReadError> {
        match &self.entry.angles {
            AnglesEntry::Listed { theta_laser } if theta_laser.len() != found => {
                let angles = theta_laser.len();
                let problem =
                    format!("{what} has {found} {parts}, but \"theta_laser\" has {angles} angles");
                Err(ReadError::damaged(view.path(), Place::Whole, problem))
            }
            _ => Ok(()),
        }
    }

    fn frame(&self, view: &ScanView, columns: usize) -> Result<Arc<LightStripe>, ReadError> {
        let size = ImageSize { rows: self.entry.camera_rows, cols: columns };
        self.frames.get_or_make(size, || {
            let parameters = self.entry.parameters(columns);
            LightStripe::new(parameters).map_err(|e| view.bad_sensor(e))
        })
    }

    fn extract(
        &self,
        view: &ScanView,
        stack: &ImageStack,
        frame: &LightStripe,
        notes: &mut Vec<String>,
    ) -> Result<RangeImage, ReadError> {
        let bad = |e| view.unusable("\"stripe\"", e);
        let stripe = bounded(self.entry.stripe.unwrap_or_default(), &self.entry).map_err(bad)?;
        let finder = finder(&stripe, stack, notes)?;
        let mut found = StripeStack::new(frame, finder).map_err(bad)?;
        stack.for_each(|at, image| {
            found.push(&image).map_err(|e| ReadError::unusable(at.path, at.place, "the image", e))
        })?;
        found.finish().map_err(bad)
    }
}

/// Settings that the finder takes memory for, held against the camera first.
fn bounded(stripe: StripeEntry, camera: &LightStripeEntry) -> Result<StripeEntry, SensorError> {
    let (key, value) = ("stripe_width", stripe.width);
    if value > camera.camera_cols as f64 {
        let wanted = "a stripe narrower than the image";
        return Err(SensorError::BadParameter { key, value, wanted });
    }
    // The median takes rows in pairs, one above and one below: more than this finds no more of
    // them. Even numbers stay even, for the finder to refuse.
    let most = camera.camera_rows.saturating_mul(2) | 1;
    let median_rows = stripe.median_rows.min(most - 1 + stripe.median_rows % 2);
    Ok(StripeEntry { median_rows, ..stripe })
}

/// The finder a manifest asks for; a height that nobody states is measured, which takes another
/// pass through the stack.
fn finder(
    stripe: &StripeEntry,
    stack: &ImageStack,
    notes: &mut Vec<String>,
) -> Result<StripeFinder, ReadError> {
    if let Some(height) = stripe.height {
        return Ok(stripe.finder(height));
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
    // A stack without any light has no stripe either, whatever the height.
    let height = 0.5 * f64::max(largest, 1.0);
    notes.push(format!(
        "\"stripe.height\" taken as {height} counts, half the largest count of the stack"
    ));
    Ok(stripe.finder(height))
}
