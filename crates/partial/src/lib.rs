//! One view to oriented curves on every section plane: partial modelling (dissertation, chapter 3).
//!
//! The one decision of this crate: curves are found **in the range image**, where samples are
//! neighbours, and not among points in space. It refuses to know other views and storage.
//!
//! * [`partial_model`]: by either [`Method`];
//! * [`one_pass`]: all planes in one sweep over the image;
//! * [`dissertation`]: plane by plane, in the dissertation's own steps;
//! * [`subpixel`]: where a plane passes between two pixels (3.6);
//! * [`BreakRule`]: where neighbouring pixels do not belong to one surface (3.4.2);
//! * [`RangeNoise`]: the range noise of a view, stated or estimated from its image;
//! * [`mod@smooth`]: edge-preserving smoothing of noisy images before that;
//! * [`PartialCurve`]: a curve with what only its view knows of it;
//! * [`SectionAxes`]: levels and plane coordinates straight from sensor coordinates.

mod axes;
mod continuation;
pub mod dissertation;
mod method;
mod near_planes;
pub mod one_pass;
mod partial_curve;
mod pixel_grid;
pub mod subpixel;

pub use axes::{MAX_LEVELS, SectionAxes};
pub use method::{Method, partial_model};
pub use partial_curve::{PartialCurve, PlaneCurves};
pub use transect_geometry::EndReason;
pub use transect_image::{BreakRule, Instructions};

use transect_image::PreparedView;

/// The curves of one view: its partial model.
#[derive(Debug, Clone, Default)]
pub struct PartialModel {
    /// The planes the view crosses, sorted, each with its curves in a fixed order.
    pub planes: Vec<PlaneCurves>,
    /// What was seen and left out on the way.
    pub counts: PartialCounts,
}

/// Counts of one view's partial modelling.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PartialCounts {
    /// Planes crossing an unbroken pair of neighbouring pixels: vertices before tidying.
    pub crossings: usize,
    /// Pairs of neighbouring valid pixels that do not belong to one surface, as the curves were found:
    /// pixels that no plane can come near count as they were given.
    pub jumps: usize,
    /// Chains of crossings too short to be a curve, which are left out: most are single crossings.
    pub lone: usize,
    /// Lines left out because noise alone explains them: the surface is nearly tangent to the plane.
    pub noise_lines: usize,
    /// Units that bridge missing pixels.
    pub bridged: usize,
    /// Range noise that was given or estimated, in the model's length unit.
    pub sigma: f64,
    /// Range noise that is left at the median of the pixels that were to be smoothed, in the model's length unit.
    pub sigma_after: f64,
    /// Pixels that smoothing changed; those that no plane can come near are not smoothed.
    pub smoothed: usize,
    /// Pixels that count as missing since they lie beyond an end of a curved guide.
    pub beyond_ends: usize,
    /// Pixels that count as missing since planes along a curved guide may cross where they are.
    pub beyond_reach: usize,
    /// Diameter of the window that it looked at, at the median of them, in pixels; 0 if none.
    pub window: f64,
}

impl PartialCounts {
    /// Takes over the noise of a view and what smoothing did.
    fn take_prepared(&mut self, prepared: &PreparedView<'_>) {
        self.sigma = prepared.sigma();
        self.sigma_after = self.sigma;
        if let Some(smoothed) = prepared.smoothed() {
            self.sigma_after *= smoothed.median_factor;
            self.smoothed = smoothed.changed;
            self.window = smoothed.window;
        }
    }
}

/// Why a view could not be modelled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PartialError {
    /// The planes lie so densely that a level no longer has a usable resolution.
    #[error(
        "the view spans {planes:.3e} planes of interval {interval}; at most {MAX_LEVELS} are possible: \
         is the interval in the right unit?"
    )]
    TooManyPlanes {
        /// How many planes the view's sensing volume spans.
        planes: f64,
        /// The interval, in the model's length unit.
        interval: f64,
    },
    /// So many crossings that their curves would not fit into memory.
    #[error(
        "the view crosses the planes of interval {interval} more than {MAX_CROSSINGS} times: \
         is the interval in the right unit?"
    )]
    TooManyCrossings {
        /// The interval, in the model's length unit.
        interval: f64,
    },
    /// The method is for parallel planes alone.
    #[error(
        "this method is for planes along a straight guide; along a curved one use the method `one_pass`"
    )]
    CurvedGuide,
    /// The method needs the inverse mapping F, which the sensor of the view does not have.
    #[error(
        "the method `{method}` needs a sensor with an inverse mapping, which that of view {view} \
         does not have"
    )]
    NoInverse {
        /// The method that was asked for.
        method: &'static str,
        /// Name of the view.
        view: String,
    },
}

/// Most crossings of one view, 2²³: with their curves they take about 0.9 GiB. A view of four million
/// pixels has that many if two planes pass between any two neighbours.
pub const MAX_CROSSINGS: usize = 1 << 23;
