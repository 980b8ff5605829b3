//! A node of the result, and the evidence of its observations.

use super::super::measure::Scale;
use super::super::tuning::node::*;
use super::super::tuning::place::SHARED_WINDOW;
use crate::ground::Ground;
use nalgebra::Vector3;
use transect_geometry::{CurveUnit, Node, Point2, Vector2};

/// The evidence of a node's observations together. It does not change when the node moves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Evidence {
    pub footprint: f64,
    /// Standard deviation of the observations' mean, without the views' systematic errors.
    pub random_sigma: f64,
    /// Variance of the mean by the views' systematic errors.
    pub view_variance: f64,
    /// Sum of the observations' weights.
    pub weight: f64,
    /// How many observations the node counts as: the sum of their support.
    pub support: f64,
    pub views: u32,
    /// Highest number of a view that measured the node.
    pub last_view: Option<u32>,
    /// Outward unit normal of the surface; `None` where not known.
    pub normal: Option<Vector3<f32>>,
    /// Mean tangent of the incidence; `None` where not known.
    pub tan_incidence: Option<f32>,
}

/// A node at its final place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlacedNode {
    pub position: Point2,
    /// Unit direction of the curve.
    pub tangent: Vector2,
    /// Standard deviation across the curve, with the views' systematic errors.
    pub sigma: f64,
    /// Length along the curve over which the node shares its error with its neighbours.
    pub correlation: f64,
    /// Footprint of the coarsest node whose sample this one lies within: gaps are counted in it.
    pub spacing: f64,
    pub evidence: Evidence,
}

impl PlacedNode {
    /// The node as it stands in a curve of the result.
    pub fn node(&self) -> Node {
        let Evidence { footprint, support, views, normal, tan_incidence, .. } = self.evidence;
        Node::at(self.position)
            .with_sigma(self.sigma as f32)
            .with_footprint(footprint as f32)
            .with_weight(support as f32)
            .with_views(views)
            .with_correlation(self.correlation as f32)
            .with_tan_incidence(tan_incidence)
            .with_normal(normal)
    }

    /// Whether the ground up to a neighbour was measured: the step is no longer than three
    /// footprints.
    pub fn is_beside(&self, next: &Self) -> bool {
        let (unit, footprint) = self.unit_to(next);
        unit.vector().norm() <= LONGEST_STEP * footprint
    }

    /// The unit to the next node, and the larger of both footprints.
    pub fn unit_to(&self, next: &Self) -> (CurveUnit, f64) {
        let unit = CurveUnit { start: self.position, end: next.position };
        (unit, self.evidence.footprint.max(next.evidence.footprint))
    }

    /// Whether the step to the next node is no continuation and lies in the shadow of a view.
    pub fn turns_in_shadow(&self, next: &Self, ground: &Ground<'_>) -> bool {
        let (unit, _) = self.unit_to(next);
        let along = unit.vector().try_normalize(0.0).unwrap_or_default();
        let finer = self.evidence.footprint.min(next.evidence.footprint);
        let turns = along.dot(&self.tangent).min(along.dot(&next.tangent)) < STRAIGHT;
        turns && unit.vector().norm() > SHADOW_FOOTPRINTS * finer && ground.is_in_shadow(&unit)
    }

    /// Whether the step to the next node turns in a shadow, or is a long one between range jumps of
    /// any views, over ground that no view measured. A view that sees a wall at a grazing angle
    /// leaves fine nodes far apart, and that is no gap.
    pub fn is_across_shadow(&self, next: &Self, ground: &Ground<'_>, scale: &Scale) -> bool {
        let (unit, _) = self.unit_to(next);
        let finer = self.evidence.footprint.min(next.evidence.footprint);
        let across = scale.across(self.sigma.max(next.sigma));
        self.turns_in_shadow(next, ground)
            || unit.vector().norm() > BETWEEN_JUMPS_FOOTPRINTS * finer
                && ground.is_between_jumps(&unit)
                && !ground.is_measured(&unit, finer, across.min(finer))
    }

    /// Standard deviation across the curve without the views' systematic errors.
    pub fn random_sigma(&self) -> f64 {
        (self.sigma * self.sigma - self.evidence.view_variance).max(0.0).sqrt()
    }

    /// Standard deviation of the direction, as a slope; infinite for a node of no fit.
    pub fn slope_sigma(&self) -> f64 {
        if self.correlation <= 0.0 {
            return f64::INFINITY;
        }
        SLOPE_PER_PLACE * self.random_sigma() * SHARED_WINDOW / self.correlation
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl PlacedNode {
        /// A node of no weight.
        pub fn at(position: Point2, tangent: Vector2, footprint: f64) -> Self {
            let evidence = Evidence {
                footprint,
                random_sigma: 0.0,
                view_variance: 0.0,
                weight: 0.0,
                support: 0.0,
                views: 0,
                last_view: None,
                normal: None,
                tan_incidence: None,
            };
            Self { position, tangent, sigma: 0.0, correlation: 0.0, spacing: footprint, evidence }
        }
    }
}
