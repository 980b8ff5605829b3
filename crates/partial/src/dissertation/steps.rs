//! The intermediate results of one plane, for pictures that explain the method.

use super::code::CodeImage;
use super::label::LabelImage;
use super::plane_image::PlaneImage;
use super::{Modeler, Traced};
use crate::PartialCurve;
use transect_device::{Pixel, View};
use transect_geometry::{EndReason, PlaneIndex, Point2, Vector2};

/// The result of each step of the method on one plane.
#[derive(Debug, Clone)]
pub struct PlaneSteps {
    /// The plane.
    pub plane: PlaneIndex,
    /// The view as it was modelled: smoothed where its noise asks for it.
    pub view: View,
    /// The plane range image (3.4.1).
    pub plane_image: PlaneImage,
    /// The label image before thinning (3.4.2), and after (3.5.2).
    pub labels: [LabelImage; 2],
    /// The codes after thinning (3.4.2).
    pub codes: CodeImage,
    /// The traced curves, in the order in which they were found.
    pub curves: Vec<CurveSteps>,
}

/// The result of each step on one curve.
#[derive(Debug, Clone, PartialEq)]
pub struct CurveSteps {
    /// The traced contour pixels in order, and whether missing pixels follow (3.5.1).
    pub pixels: Vec<(Pixel, bool)>,
    /// Why the trace begins and ends; `None` if it is closed.
    pub ends: Option<[EndReason; 2]>,
    /// The subpixel places in the order of the trace (3.6).
    pub crossings: Vec<CrossingStep>,
    /// Positive if the solid is on the left of the trace, negative if the trace is to be turned
    /// round; 0 if no node tells (3.7).
    pub votes: f64,
    /// The curve; `None` if it is too short for one.
    pub curve: Option<PartialCurve>,
}

/// A place where the plane passes between two pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossingStep {
    /// The pixel before the border, and the contour pixel.
    pub pair: [Pixel; 2],
    /// Share of the way from the first pixel to the second, from 0 to 1.
    pub parameter: f64,
    /// Place in plane coordinates.
    pub position: Point2,
    /// Unit direction in the plane into the solid, where the two rays tell it.
    pub towards_inside: Option<Vector2>,
}

impl Traced<'_> {
    /// All steps of the plane.
    pub(super) fn steps(self, modeler: &Modeler<'_>) -> PlaneSteps {
        let (samples, maker) = (&modeler.samples, modeler.maker(&self));
        let curve = |trace: &super::Trace| {
            let crossings = maker.crossings(trace);
            let step = |c: &super::crossing::Crossing| CrossingStep {
                pair: [c.first, c.second],
                parameter: c.parameter,
                position: c.position,
                towards_inside: maker.orient.towards_inside(c),
            };
            CurveSteps {
                pixels: trace.borders.iter().map(|b| (b.pixel, b.bridged_after)).collect(),
                ends: trace.ends,
                votes: maker.orient.votes(&crossings, trace.ends.is_none()),
                crossings: crossings.iter().map(step).collect(),
                curve: maker.directed(trace, crossings),
            }
        };
        PlaneSteps {
            plane: samples.axes.plane(self.level),
            view: samples.view.clone(),
            plane_image: self.plane_image.clone(),
            labels: [LabelImage::new(samples, self.level), self.labels.clone()],
            codes: self.codes.clone(),
            curves: self.traces.iter().map(curve).collect(),
        }
    }
}
