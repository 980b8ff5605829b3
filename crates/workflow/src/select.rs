//! The part of a scan that a run uses, taken from the scan on disk.

use crate::selection::{Limits, Selection};
use crate::{OpenScan, WorkflowError};
use rayon::prelude::*;
use transect_exchange::ScanView;

impl OpenScan {
    /// The part of the scan that a selection names. Notes tell how many views are left out.
    ///
    /// # Errors
    /// [`WorkflowError`] if the selection names no view, or no view has a point within its limits.
    pub fn select(mut self, selection: &Selection) -> Result<Self, WorkflowError> {
        let numbers = selection.numbers(self.scan())?;
        self.limits = selection.limits(self.scan().unit)?;
        self.selection = selection.clone();
        let all = self.scan.views.len();
        self.scan.views = numbers.iter().map(|&k| self.scan.views[k].clone()).collect();
        if numbers.len() < all {
            let note = format!("{} of {all} views are used, as asked for", numbers.len());
            self.scan.notes.push(note);
        }
        if self.limits != Limits::default() {
            self.leave_out_empty_views()?;
        }
        Ok(self)
    }

    /// Leaves out the views without a point within the limits. A view that cannot be read stays:
    /// the run reports it.
    fn leave_out_empty_views(&mut self) -> Result<(), WorkflowError> {
        let limits = self.limits;
        let has_points = |view: &ScanView| match view.load() {
            Ok((view, _)) => limits.apply(view).is_ok(),
            Err(_) => true,
        };
        let kept: Vec<bool> = self.scan.views.par_iter().map(has_points).collect();
        let named = self.scan.views.iter().zip(&kept).filter(|(_, kept)| !**kept);
        let empty: Vec<&str> = named.map(|(view, _)| view.name()).collect();
        if empty.is_empty() {
            return Ok(());
        }
        let (count, names) = (empty.len(), empty.join(", "));
        let note = format!("{count} views left out, without a point within the limits: {names}");
        if count == kept.len() {
            let problem = "no view has a point within the limits; inspect shows the scan's extent \
                           and ranges";
            return Err(WorkflowError::file(&self.path, problem));
        }
        self.scan.notes.push(note);
        let mut kept = kept.into_iter();
        self.scan.views.retain(|_| kept.next().unwrap_or(true));
        Ok(())
    }
}
