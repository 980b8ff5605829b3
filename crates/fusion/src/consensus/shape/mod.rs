//! Room 4: from chains to curves.
//!
//! Small rings become circles, corners become sharp, and chains become [`Curve`]s with the reasons
//! why they end.

mod corners;
mod output;
mod rings;

use super::connect::Chain;
use super::estimate::Estimate;
use super::measure::Measurements;
use crate::ground::Ground;
use transect_geometry::Curve;

/// The curves of the chains, longest first, and the number of nodes of chains that are no curve.
pub(super) fn shape(
    estimate: Estimate,
    mut chains: Vec<Chain>,
    measured: &Measurements,
    ground: &Ground<'_>,
) -> (Vec<Curve>, usize) {
    let Measurements { observations, scale, .. } = measured;
    let Estimate { mut nodes, absorbed_by, .. } = estimate;
    if scale.steps().rings {
        rings::round(&mut nodes, &mut chains);
    }
    if scale.steps().corners {
        corners::sharpen(&mut nodes, &mut chains, observations.pixel_noise(), scale.steps());
    }
    let ends = output::Ends::new(observations, &absorbed_by, &nodes);
    output::curves(&nodes, chains, (ground, scale), &ends)
}
