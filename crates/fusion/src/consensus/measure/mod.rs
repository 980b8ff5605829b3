//! Room 1: the observations of all views, their errors, and the lengths that follow from both.
//!
//! Hands on the [`Observation`]s with their weights, and the plane's [`Scale`].

mod align;
mod arc;
mod bead;
mod common_course;
mod course_fit;
mod observations;
mod reach;
mod scale;
mod settle;
mod spread;
mod view_error;

pub(crate) use observations::{NONE, Observation, Observations, ViewEnd, canonical};
pub(crate) use reach::course_length;
pub(crate) use scale::Scale;

use super::options::ConsensusOptions;
use crate::grid::PointGrid;
use observations::median;
use settle::settle;

/// The observations of a plane with all that is known of their errors.
pub(crate) struct Measurements {
    pub observations: Observations,
    pub scale: Scale,
    /// Standard deviation of one view's curve against the common one.
    pub spread: f64,
    /// Standard deviation of the views' systematic errors, head-on, before the views were moved.
    pub view_error: f64,
    /// Median standard deviation of the observations by their own noise.
    pub noise: f64,
    /// The places of the observations.
    pub grid: PointGrid,
}

impl Measurements {
    /// Measures spread and view errors, and weighs the observations; `None` without any.
    pub fn new(mut observations: Observations, options: &ConsensusOptions) -> Option<Self> {
        if observations.all.is_empty() {
            return None;
        }
        let (mut scale, spread) = Scale::new(&observations, options);
        let view_error = spread.view_error.level.sqrt();
        let noise = median(observations.all.iter().map(|o| o.sigma));
        let moved =
            if options.steps.settle { settle(&mut observations, &scale, &spread) } else { None };
        if moved.is_some() {
            // The views now lie close to each other, so surfaces that do so are told apart.
            scale = Scale { settled: true, ..Scale::new(&observations, options).0 };
        }
        if options.steps.view_error {
            observations.weigh(&moved.unwrap_or(spread.view_error));
        }
        let grid = PointGrid::new(&observations.positions(), observations.spacing());
        let spread = spread.between_views;
        Some(Self { observations, scale, spread, view_error, noise, grid })
    }
}
