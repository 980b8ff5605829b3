//! The curves of one view, with facts that only this view has.

use transect_device::Pixel;
use transect_geometry::{Curve, EndReason, Node, PlaneIndex};

/// The curves of one view on one plane.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneCurves {
    /// The plane.
    pub plane: PlaneIndex,
    /// Its curves, solid on the left; never empty.
    pub curves: Vec<PartialCurve>,
}

/// A curve of one view, with facts that only this view has.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialCurve {
    /// The curve, solid on the left. It states why it ends, and its nodes mark the units that
    /// bridge missing pixels.
    pub curve: Curve,
    /// Of every node, the pixel nearest to it: row and column in the view (provenance).
    pub pixels: Vec<Pixel>,
}

impl PartialCurve {
    /// A curve through the nodes, which gets the reasons for its ends; `None` for a closed curve.
    ///
    /// `None` if the nodes are too few, or no measurements.
    pub(crate) fn new(
        (nodes, closed): (Vec<Node>, bool),
        pixels: Vec<Pixel>,
        ends: Option<[EndReason; 2]>,
    ) -> Option<Self> {
        let curve = Curve::new(nodes, closed).ok()?;
        let curve = curve.with_ends(ends.map_or([None; 2], |ends| ends.map(Some)));
        Some(Self { curve, pixels })
    }
}
