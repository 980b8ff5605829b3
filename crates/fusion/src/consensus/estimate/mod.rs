//! Room 2: from many observations to few nodes, each at its best place.
//!
//! Groups → thinned [`Cluster`](cluster::Cluster)s → [`PlacedNode`]s, which are handed on.

mod cluster;
mod fit;
mod groups;
mod node;
mod parabola;
mod place;
mod thin;

pub(super) use node::{Evidence, PlacedNode};

use super::measure::Measurements;

/// The nodes of a plane.
pub(super) struct Estimate {
    pub nodes: Vec<PlacedNode>,
    /// For every observation the node that absorbed it.
    pub absorbed_by: Vec<u32>,
    /// For every observation the number of its group.
    pub group_of: Vec<u32>,
}

impl Estimate {
    pub fn new(measured: &Measurements) -> Self {
        let Measurements { observations, scale, grid, .. } = measured;
        let groups = groups::group(observations, grid, scale);
        let thinned = thin::thin(&groups, scale);
        let absorbed_by: Vec<u32> =
            groups.of.iter().map(|&g| thinned.absorbed_by[g as usize]).collect();
        let clusters = cluster::clusters(observations, &absorbed_by, &thinned.stands, scale);
        Self { nodes: place::place(&clusters, scale), absorbed_by, group_of: groups.of }
    }
}
