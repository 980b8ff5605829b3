//! The crossings of a plane with the borders of labels.

use crate::repeats::OnCurve;
use transect_device::{Neighbour, Pixel};
use transect_geometry::Point2;

/// The plane crossing a border.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    /// The pixel before the border.
    pub first: Pixel,
    /// The contour pixel, whose code the border belongs to.
    pub second: Pixel,
    pub neighbour: Neighbour,
    /// Where, in plane coordinates.
    pub position: Point2,
    /// Share of the way from the first pixel to the second, from 0 to 1.
    pub parameter: f64,
    /// The pixel nearer to the crossing.
    pub nearest: Pixel,
    /// Distance between the two samples, in the length unit.
    pub pair_length: f64,
    /// Whether pixels are missing between this crossing and the next one of its curve.
    pub bridged_after: bool,
}

impl OnCurve for Crossing {
    fn position(&self) -> Point2 {
        self.position
    }

    fn spacing(&self) -> f64 {
        self.pair_length
    }

    fn bridged_after(&mut self) -> &mut bool {
        &mut self.bridged_after
    }
}
