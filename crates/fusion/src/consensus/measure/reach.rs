//! How far common courses and their windows reach, from the errors of views.

use super::super::tuning::settle::*;
use super::observations::Observation;
use super::scale::Scale;
use super::view_error::ViewError;

/// The sizes of a common course and its windows. Lengths are those of a typical view; they go with
/// the error of the view whose course is sought.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    /// Half-length of a course.
    pub along: f64,
    /// Largest distance of a bead from the bead whose course is sought.
    pub across: f64,
    /// Errors of views, and the standard deviation of that of a typical view.
    pub of_view: ViewError,
    pub typical: f64,
    /// Half-lengths of all windows, over that of the narrowest.
    pub windows: &'static [f64],
    /// Cosine of the largest angle between beads of one surface.
    pub same_way: f64,
}

impl Reach {
    /// The reach that views with these errors need.
    pub fn new(of_view: ViewError, typical: f64, scale: &Scale) -> Self {
        Self {
            along: ALONG_ERRORS * typical,
            across: ACROSS_ERRORS * typical,
            of_view,
            typical,
            windows: if scale.steps().wider_courses { &WINDOWS } else { &WINDOWS[..1] },
            same_way: scale.same_way,
        }
    }

    /// Windows this many times as long.
    pub fn times(&self, factor: f64) -> Self {
        Self { along: factor * self.along, ..*self }
    }

    /// The reach for a bead of this variance.
    pub fn at(&self, variance: f64) -> Self {
        let factor = variance.sqrt().clamp(LARGEST_REACH.recip(), LARGEST_REACH);
        Self { along: factor * self.along, across: factor * self.across, ..*self }
    }

    /// Variance of the error of an observation, its own included, over that of a typical view.
    pub fn variance(&self, of: &Observation) -> f64 {
        (of.view_variance(&self.of_view) + of.sigma * of.sigma) / (self.typical * self.typical)
    }
}

/// Length of the common course of a view whose error has this standard deviation.
pub(crate) fn course_length(error: f64) -> f64 {
    2.0 * ALONG_ERRORS * error
}
