//! The curves of one view, with counts of the work.

use crate::PlaneCurves;
use transect_device::Note;
use transect_image::PreparedView;

/// The curves of one view: its partial model.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PartialModel {
    /// The planes the view crosses, sorted, each with its curves in a fixed order.
    pub planes: Vec<PlaneCurves>,
    /// Counts of pixels and pairs, and the noise.
    pub counts: PartialCounts,
    /// Notes for the report, which name the view.
    pub notes: Vec<Note>,
}

/// Counts of one view's partial modelling.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PartialCounts {
    /// Planes crossing an unbroken pair of neighbouring pixels: vertices before tidying.
    pub crossings: usize,
    /// Valid pixels that were read: all of the view, or those of every other row and column. Counts
    /// of pixels and pairs are of these.
    pub read: usize,
    /// Pairs of neighbouring valid pixels that do not belong to one surface. Pixels far from every
    /// plane are not smoothed and count as they were read.
    pub jumps: usize,
    /// Range noise that was given or estimated, in the model's length unit.
    pub sigma: f64,
    /// Pixels that smoothing changed. Pixels far from every plane are not smoothed.
    pub smoothed: usize,
    /// Pixels between the two surfaces of a range jump, which smoothing left out.
    pub flying: usize,
    /// Missing pixels and outliers that were filled; counts of pairs include them.
    pub filled: usize,
    /// Pixels beyond an end of a curved guide; they count as missing.
    pub beyond_ends: usize,
    /// Pixels where planes along a curved guide may cross; they count as missing.
    pub beyond_reach: usize,
}

impl PartialModel {
    /// Takes over the noise of a view and what smoothing did.
    pub(crate) fn take_prepared(&mut self, prepared: &PreparedView<'_>) {
        let counts = &mut self.counts;
        counts.read = prepared.valid_pixels();
        counts.filled = prepared.filled_pixels();
        counts.sigma = prepared.sigma();
        if let Some(smoothed) = prepared.smoothed() {
            counts.smoothed = smoothed.changed;
            counts.flying = smoothed.flying;
        }
        let about = |text| Note::about(format_args!("view {}", prepared.view().name()), text);
        if let Some(estimate) = prepared.contradicting_sigma() {
            self.notes.push(about(format!(
                "sigma is stated as {}, in the scan's length unit, but the noise of its image is \
                 {}; check the unit of \"sigma\", or leave it out to use the estimate",
                two_digits(prepared.sigma()),
                two_digits(estimate)
            )));
        }
        if let Some(error) = prepared.failure() {
            self.notes.push(about(format!(
                "its image could not be smoothed ({error}); its curves come from the image as it \
                 was read and are noisier than those of other views"
            )));
        }
    }
}

/// A number in decimals, with at least two significant digits; 0 is `0`.
fn two_digits(number: f64) -> String {
    if number == 0.0 {
        return "0".to_owned();
    }
    let decimals = (1.0 - number.log10().floor()).max(0.0) as usize;
    format!("{number:.decimals$}")
}
