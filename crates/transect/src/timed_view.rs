//! A view as its source loads it.

use crate::{LoadedView, ReconstructError, ViewSource};
use std::time::{Duration, Instant};

/// A view and the time that its source took to load it.
pub(crate) struct TimedView {
    pub loaded: LoadedView,
    pub reading: Duration,
}

impl TimedView {
    pub fn load<S: ViewSource>(source: &S) -> Result<Self, ReconstructError> {
        let started = Instant::now();
        let failed = |e| ReconstructError::Load { view: source.name().to_owned(), source: e };
        let loaded = source.load().map_err(failed)?;
        Ok(Self { loaded, reading: started.elapsed() })
    }
}
