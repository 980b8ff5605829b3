//! Progress on stderr: stage, counter, bar, time left.

use indicatif::{ProgressBar, ProgressStyle};
use std::sync::Mutex;
use transect::{Stage, Watch};

/// A bar for each stage. Nothing is shown if stderr is no terminal, or if the user asked for quiet.
#[derive(Debug)]
pub struct Progress {
    quiet: bool,
    bar: Mutex<Option<ProgressBar>>,
}

impl Progress {
    /// Progress on stderr, or none.
    pub fn new(quiet: bool) -> Self {
        Self { quiet, bar: Mutex::new(None) }
    }

    /// Removes the bar, so that results can be printed.
    pub fn finish(&self) {
        if let Ok(mut bar) = self.bar.lock()
            && let Some(bar) = bar.take()
        {
            bar.finish_and_clear();
        }
    }
}

impl Watch for Progress {
    fn begin(&self, stage: Stage, total: usize) {
        if self.quiet {
            return;
        }
        let name = match stage {
            Stage::Poses => "poses",
            Stage::Views => "views",
            Stage::Planes => "planes",
        };
        let template = "{prefix:>7} {pos}/{len} [{bar:32}] {elapsed} elapsed, {eta} left";
        let style =
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        let new = ProgressBar::new(total as u64).with_style(style).with_prefix(name);
        if let Ok(mut bar) = self.bar.lock()
            && let Some(old) = bar.replace(new)
        {
            old.finish_and_clear();
        }
    }

    fn step(&self, _stage: Stage) {
        if let Ok(bar) = self.bar.lock()
            && let Some(bar) = bar.as_ref()
        {
            bar.inc(1);
        }
    }
}
