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
use settle::{settle, stands_out};

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
        let of_views = spread.view_error(false, &options.steps);
        let view_error = of_views.level.sqrt();
        let noise = median(observations.all.iter().map(|o| o.sigma));
        let moved = (options.steps.settle && stands_out(view_error, noise, &scale)).then(|| {
            let of_views = spread.view_error(options.steps.error_with_noise, &options.steps);
            settle(&mut observations, &scale, &of_views, noise);
            of_views
        });
        if moved.is_some() {
            // The views now lie close to each other, so surfaces that do so are told apart.
            scale = Scale { settled: true, ..Scale::new(&observations, options).0 };
        }
        if options.steps.view_error {
            observations.weigh(&moved.unwrap_or(of_views));
        }
        let grid = PointGrid::new(&observations.positions(), observations.spacing());
        let spread = spread.between_views;
        Some(Self { observations, scale, spread, view_error, noise, grid })
    }
}
