//! Progress and cancelling of a run.

/// A part of a run whose steps are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Reading views and comparing their poses; counted in views.
    Poses,
    /// Reading views and finding their curves; counted in views.
    Views,
    /// Fusing the views' curves; counted in planes. Planes that lost their last curve take no step.
    Planes,
}

/// Receives the progress of a run, and can stop it.
///
/// Called from several threads.
pub trait Watch: Sync {
    /// A stage begins, with a number of steps.
    fn begin(&self, stage: Stage, total: usize);
    /// One more step of a stage that has begun is done.
    fn step(&self, stage: Stage);
    /// Whether the run should stop. Called before each view, and before each plane. A run into a
    /// model store asks before each group of as many views as there are threads, and before no
    /// plane, since the store's transactions run to their end.
    fn cancelled(&self) -> bool {
        false
    }
}

/// Ignores the progress and never stops a run.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unwatched;

impl Watch for Unwatched {
    fn begin(&self, _stage: Stage, _total: usize) {}
    fn step(&self, _stage: Stage) {}
}
