//! Why nodes do not make a curve.

/// Why nodes do not make a curve. Nodes count from 0.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CurveError {
    /// Fewer than two nodes for an open curve, or three for a closed one.
    #[error("{nodes} nodes cannot make {} curve", if *closed { "a closed" } else { "an open" })]
    TooFewNodes {
        /// How many there were.
        nodes: usize,
        /// Whether the curve was to be closed.
        closed: bool,
    },
    /// A coordinate is NaN or infinite.
    #[error("node {0} has a coordinate that is not a finite number")]
    NotFinite(usize),
    /// Standard deviation, footprint, weight, correlation or incidence is negative, NaN or
    /// infinite.
    #[error(
        "the {attribute} of node {node} is {value}; it must be a finite number of at least 0. \
         Correct the node, or leave it out"
    )]
    BadAttribute {
        /// The number of the node.
        node: usize,
        /// The field of [`Node`](crate::Node).
        attribute: &'static str,
        /// Its value, in the unit of the field.
        value: f32,
    },
    /// A component of the normal is NaN or infinite.
    #[error(
        "the normal of node {node} has the component {component}; it must be a finite number. \
         Correct the normal, or leave it out"
    )]
    BadNormal {
        /// The number of the node.
        node: usize,
        /// The component, without unit.
        component: f32,
    },
}
