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
    /// The curve, solid on the left; it carries the reasons for its ends and the bridged units too.
    pub curve: Curve,
    /// Of every node, the pixel nearest to it: row and column in the view (provenance).
    pub pixels: Vec<Pixel>,
    /// Why the curve begins and ends where it does; `None` for a closed curve.
    pub ends: Option<[EndReason; 2]>,
    /// Numbers of the units (node k to k+1) that bridge missing pixels; sorted. Empty for most
    /// curves.
    pub bridged: Vec<u32>,
}

impl PartialCurve {
    /// A curve through the nodes, which gets the ends' reasons and the marks of bridged units.
    ///
    /// `None` if the nodes are too few, or no measurements.
    pub(crate) fn new(
        (mut nodes, closed): (Vec<Node>, bool),
        pixels: Vec<Pixel>,
        ends: Option<[EndReason; 2]>,
        bridged: Vec<u32>,
    ) -> Option<Self> {
        for &k in &bridged {
            nodes.get_mut(k as usize)?.bridged = true;
        }
        let curve = Curve::new(nodes, closed).ok()?;
        let curve = curve.with_ends(ends.map_or([None; 2], |e| e.map(Some)));
        Some(Self { curve, pixels, ends, bridged })
    }
}
