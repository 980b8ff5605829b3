//! The curves of one view, with what only that view knows of them.

use transect_device::Pixel;
use transect_geometry::{Curve, PlaneIndex};

/// The curves of one view on one plane.
#[derive(Debug, Clone)]
pub struct PlaneCurves {
    /// The plane.
    pub plane: PlaneIndex,
    /// Its curves, solid on the left; never empty.
    pub curves: Vec<PartialCurve>,
}

/// A curve of one view, with what only that view knows of it.
#[derive(Debug, Clone)]
pub struct PartialCurve {
    /// The curve, solid on the left.
    pub curve: Curve,
    /// Of every node, the pixel nearest to it: row and column in the view (provenance).
    pub pixels: Vec<Pixel>,
    /// Why the curve begins and ends where it does; `None` for a closed curve.
    pub ends: Option<[EndReason; 2]>,
    /// Numbers of the units (node k to k+1) that bridge missing pixels; sorted. Empty for most
    /// curves.
    pub bridged: Vec<u32>,
}

/// Why a curve ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum EndReason {
    /// A pixel beside the end is missing.
    MissingPixel,
    /// The surface ends or hides behind another one: neighbouring pixels belong to different ones.
    RangeJump,
    /// The image ends.
    ImageBorder,
}

impl std::fmt::Display for EndReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::MissingPixel => "missing pixel",
            Self::RangeJump => "range jump",
            Self::ImageBorder => "image border",
        })
    }
}
