//! Device frames that take long to make and serve many views.

use crate::ReadError;
use std::sync::{Arc, Mutex, PoisonError};
use transect_device::ImageSize;

/// One device frame per size of image; a scan's images mostly have one size.
#[derive(Debug)]
pub(super) struct Shared<F> {
    made: Mutex<Vec<(ImageSize, Arc<F>)>>,
}

impl<F> Shared<F> {
    pub(super) fn new() -> Self {
        Self { made: Mutex::default() }
    }

    /// The frame for images of a size, made by whoever asks first; the others wait for it.
    pub(super) fn get_or_make(
        &self,
        size: ImageSize,
        make: impl FnOnce() -> Result<F, ReadError>,
    ) -> Result<Arc<F>, ReadError> {
        // Nothing is half-made when `make` fails or panics, so a poisoned lock holds sound frames.
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, frame)) = made.iter().find(|(s, _)| *s == size) {
            return Ok(Arc::clone(frame));
        }
        let frame = Arc::new(make()?);
        made.push((size, Arc::clone(&frame)));
        Ok(frame)
    }
}
