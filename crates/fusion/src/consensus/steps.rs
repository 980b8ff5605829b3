//! The results of each room of the consensus, for pictures that explain the method.

use super::connect::Chain;
use super::estimate::Estimate;
use super::measure::{Measurements, NONE};
use transect_geometry::{Point2, Vector2};

/// The results of the first three rooms.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ConsensusSteps {
    /// The observations of `measure`, in canonical order.
    pub observations: Vec<ObservationStep>,
    /// The placed nodes of `estimate`.
    pub nodes: Vec<NodeStep>,
    /// The chains of `connect`.
    pub chains: Vec<ChainStep>,
}

/// One node of one view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservationStep {
    /// Its place, after views were moved onto their common course.
    pub position: Point2,
    /// Unit direction of the view's curve.
    pub direction: Vector2,
    /// Place of the view among the views as given.
    pub view: usize,
    /// Distance to the neighbouring samples of its view, in the length unit.
    pub footprint: f64,
    /// Number of its group.
    pub group: u32,
    /// Number of the node that it became part of.
    pub node: Option<u32>,
}

/// A placed node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeStep {
    /// Its place.
    pub position: Point2,
    /// Unit direction of the curve.
    pub direction: Vector2,
    /// Standard deviation across the curve, in the length unit.
    pub sigma: f64,
    /// Number of views that measured it.
    pub views: u32,
}

/// The numbers of nodes in the order of a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainStep {
    /// Numbers of nodes.
    pub nodes: Vec<u32>,
    /// Whether the last node leads to the first.
    pub closed: bool,
}

impl ConsensusSteps {
    pub(super) fn new(measured: &Measurements, estimate: &Estimate, chains: &[Chain]) -> Self {
        let seen = &measured.observations;
        let numbers = estimate.group_of.iter().zip(&estimate.absorbed_by);
        let observation =
            |(o, (group, node)): (&super::measure::Observation, (&u32, &u32))| ObservationStep {
                position: o.position,
                direction: o.tangent,
                view: seen.sources.get(o.view as usize).copied().unwrap_or_default(),
                footprint: o.footprint,
                group: *group,
                node: (*node != NONE).then_some(*node),
            };
        let node = |n: &super::estimate::PlacedNode| NodeStep {
            position: n.position,
            direction: n.tangent,
            sigma: n.sigma,
            views: n.evidence.views,
        };
        let chain = |c: &Chain| ChainStep { nodes: c.nodes.clone(), closed: c.closed };
        Self {
            observations: seen.all.iter().zip(numbers).map(observation).collect(),
            nodes: estimate.nodes.iter().map(node).collect(),
            chains: chains.iter().map(chain).collect(),
        }
    }
}
