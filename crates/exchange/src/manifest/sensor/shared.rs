//! Device frames that are costly to make and serve many views.

use crate::ReadError;
use std::sync::{Arc, Mutex, PoisonError};
use transect_device::ImageSize;

/// One device frame per image size. The images of a scan mostly have one size.
#[derive(Debug)]
pub(super) struct Shared<F> {
    made: Mutex<Vec<(ImageSize, Arc<F>)>>,
}

impl<F> Default for Shared<F> {
    fn default() -> Self {
        Self { made: Mutex::default() }
    }
}

impl<F> Shared<F> {
    /// The frame for images of a size. The first caller makes it; the others wait.
    pub(super) fn get_or_make(
        &self,
        size: ImageSize,
        make: impl FnOnce() -> Result<F, ReadError>,
    ) -> Result<Arc<F>, ReadError> {
        // A frame is added after it is complete, so a poisoned lock still holds sound frames.
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, frame)) = made.iter().find(|(s, _)| *s == size) {
            return Ok(Arc::clone(frame));
        }
        let frame = Arc::new(make()?);
        made.push((size, Arc::clone(&frame)));
        Ok(frame)
    }
}
