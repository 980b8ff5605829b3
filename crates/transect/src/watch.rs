//! Progress and cancelling, without knowing who watches.

/// A part of a run whose work is countable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Reading views and finding their curves; counted in views.
    Views,
    /// Fusing the views' curves; counted in planes.
    Planes,
}

/// Who wants to know how far a run is, or to stop it.
///
/// Called from several threads.
pub trait Watch: Sync {
    /// A stage begins, with this much to do.
    fn begin(&self, stage: Stage, total: usize);
    /// One more of it is done.
    fn step(&self, stage: Stage);
    /// Whether the run should stop; asked before each view and each plane.
    fn cancelled(&self) -> bool {
        false
    }
}

/// Watches nothing and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unwatched;

impl Watch for Unwatched {
    fn begin(&self, _stage: Stage, _total: usize) {}
    fn step(&self, _stage: Stage) {}
}
