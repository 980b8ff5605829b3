//! The lengths of a plane that all steps share.

use super::super::options::{ConsensusOptions, Steps};
use super::super::tuning::scale::*;
use super::observations::{Observations, median};
use super::spread::{Search, Spread};

/// Lengths of a plane, and the options that steps need beside them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    /// Median footprint.
    pub spacing: f64,
    /// Overlap threshold across the curve.
    pub threshold: f64,
    /// Cosine of the largest angle between observations of one surface.
    pub same_way: f64,
    /// Whether the views' curves were moved onto common courses.
    pub settled: bool,
    pub options: ConsensusOptions,
}

impl Scale {
    /// Measures the spread between views and the lengths that follow from it.
    pub fn new(observations: &Observations, options: &ConsensusOptions) -> (Self, Spread) {
        let spacing = observations.spacing();
        let sigma = median(observations.all.iter().map(|o| o.sigma));
        let same_way = options.direction_limit_rad.cos();
        // A single view does not show the spread between views; its own error has to do.
        let measured = Search::new(observations, options).spread_between_views();
        let measured = measured.unwrap_or(Spread { between_views: sigma, pairs: Vec::new() });
        let least = (LEAST_SIGMAS * sigma).max(LEAST_FOOTPRINTS * spacing);
        let threshold = (options.threshold_spreads * measured.between_views).max(least);
        (Self { spacing, threshold, same_way, settled: false, options: *options }, measured)
    }

    pub fn steps(&self) -> &Steps {
        &self.options.steps
    }

    /// Overlap threshold of a node: wider where its own error is larger.
    pub fn across(&self, sigma: f64) -> f64 {
        self.threshold.max(LEAST_SIGMAS * sigma)
    }
}
