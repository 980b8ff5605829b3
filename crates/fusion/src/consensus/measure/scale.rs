//! The lengths of a plane that all steps share.

use super::super::options::{ConsensusOptions, Steps};
use super::super::tuning::scale::{LEAST_FOOTPRINTS, LEAST_HALF_GAP_SPREADS, LEAST_SIGMAS};
use super::layers;
use super::observations::{Observations, median};
use super::spread::{Search, Spread};
use super::view_error::ViewError;
use crate::grid::PointGrid;

/// Lengths of a plane, and the options that steps need beside them.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Scale {
    /// Median footprint.
    pub spacing: f64,
    /// Overlap threshold across the curve.
    pub threshold: f64,
    /// Cosine of the largest angle between observations of one surface.
    pub same_way: f64,
    pub options: ConsensusOptions,
}

impl Scale {
    /// Measures layers and spread: the spread is measured within the layers, and layers that are
    /// small against the spread are taken back.
    pub fn new(
        observations: &mut Observations,
        grid: &PointGrid,
        options: &ConsensusOptions,
    ) -> (Self, Spread) {
        let spacing = observations.spacing();
        let sigma = median(observations.all.iter().map(|o| o.sigma));
        let same_way = options.direction_limit_rad.cos();
        // A single view does not show the spread between views; its own error has to do.
        let spread = |o: &Observations| {
            let measured = Search { observations: o, grid, options }.spread_between_views();
            let own = Spread { between_views: sigma, view_error: ViewError::default() };
            measured.unwrap_or(own)
        };
        if options.steps.layers {
            observations.half_gaps = layers::half_gaps(observations, same_way);
        }
        let mut measured = spread(observations);
        let least_half_gap = LEAST_HALF_GAP_SPREADS * measured.between_views;
        if layers::take_back_small(&mut observations.half_gaps, least_half_gap) {
            measured = spread(observations);
        }
        let least = (LEAST_SIGMAS * sigma).max(LEAST_FOOTPRINTS * spacing);
        let threshold = (options.threshold_spreads * measured.between_views).max(least);
        (Self { spacing, threshold, same_way, options: *options }, measured)
    }

    pub fn steps(&self) -> &Steps {
        &self.options.steps
    }

    /// Overlap threshold of a node: wider where its own error is larger, and at most half the gap
    /// to the next layer.
    pub fn across(&self, sigma: f64, half_gap: f64) -> f64 {
        self.threshold.max(LEAST_SIGMAS * sigma).min(half_gap)
    }
}
