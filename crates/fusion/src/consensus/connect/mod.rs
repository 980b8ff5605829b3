//! Room 3: from placed nodes to chains, in the order of the curves.
//!
//! Hands on [`Chain`]s. What lay beside a longer one in the same direction was cut away before they
//! were joined.

mod chain;
mod cover;
mod ends;
mod hooks;
mod link;
mod spurs;

pub(super) use chain::{Chain, by_length};

use super::estimate::{Estimate, PlacedNode};
use super::measure::{Measurements, Scale, course_length};
use super::tuning::chain::LONE_COURSES;
use crate::ground::Ground;
use ends::JoinRule;

/// The chains of a plane.
pub(super) struct Chains {
    pub chains: Vec<Chain>,
    /// Nodes that were left out.
    pub dropped: usize,
}

/// Links nodes, and covers, joins and cuts the chains until they are curves.
pub(super) fn connect(
    estimate: &mut Estimate,
    measured: &Measurements,
    ground: &Ground<'_>,
) -> Chains {
    let Measurements { observations, scale, .. } = measured;
    if scale.steps().coarse_spacing {
        link::spread_spacing(&mut estimate.nodes, scale);
    }
    let Estimate { nodes, absorbed_by, .. } = &*estimate;
    let next = link::link(nodes, absorbed_by, observations, ground, scale);
    let chains = cover::cover(nodes, chain::trace(&next), scale);
    let mut chains = joined(nodes, chains, ground, scale);
    chains.retain(|c| c.is_curve(nodes, scale.options.shortest_footprints));
    if scale.steps().spurs {
        chains = spurs::without_spurs(nodes, chains, scale);
    }
    if scale.steps().backward {
        chains.iter_mut().for_each(|c| hooks::remove_hooks(nodes, c));
    }
    if scale.settled && scale.steps().lone_chains {
        let least = |c: &Chain| LONE_COURSES * course_length(c.mean_view_error(nodes));
        chains.retain(|c| c.is_shared(nodes) || c.length(nodes) >= least(c));
    }
    let left: usize = chains.iter().map(|c| c.nodes.len()).sum();
    Chains { chains, dropped: nodes.len() - left }
}

/// Joins the ends of chains: first those that meet, then those that continue each other, those
/// round a tip, and those that cross.
fn joined(
    nodes: &[PlacedNode],
    chains: Vec<Chain>,
    ground: &Ground<'_>,
    scale: &Scale,
) -> Vec<Chain> {
    let steps = scale.steps();
    let rules: [(bool, JoinRule); 4] = [
        (steps.join_meeting, JoinRule::MEETING),
        (steps.join_smooth, JoinRule::SMOOTH),
        (steps.join_hairpin, JoinRule::HAIRPIN),
        (steps.join_crossing, JoinRule::CROSSING),
    ];
    let chosen = rules.iter().filter(|(on, _)| *on).map(|(_, rule)| rule);
    chosen.fold(chains, |chains, rule| ends::join(nodes, chains, ground, scale, rule))
}
